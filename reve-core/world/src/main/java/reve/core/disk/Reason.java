// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import java.io.IOException;
import java.nio.file.AccessDeniedException;
import java.nio.file.FileSystemException;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;

/**
 * The reason of a failed file operation as text. Many exceptions of the system contain only the
 * path.
 */
public final class Reason {
    private Reason() {}

    /**
     * Returns an exception whose message names the file and the reason. Some exceptions of the
     * system name no file, for example for a full disk.
     */
    public static FileSystemException naming(Path file, IOException failure) {
        var named = new FileSystemException(file.toString(), null, of(failure));
        named.initCause(failure);
        return named;
    }

    /** Returns the reason without the path, because the caller names the file. */
    public static String of(Exception failure) {
        return switch (failure) {
            case NoSuchFileException gone ->
                    "there is no folder " + Path.of(gone.getFile()).toAbsolutePath().getParent();
            case AccessDeniedException denied -> "permission denied";
            case FileSystemException other when other.getReason() != null -> other.getReason();
            case IOException nameless when nameless.getMessage() == null -> nameless.toString();
            default -> String.valueOf(failure.getMessage());
        };
    }
}
