// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import java.io.IOException;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.stream.Stream;

/**
 * Lists of the files in folders that other processes may replace at any time. A pipe or file in the
 * place of the folder is refused, and does not block the caller. For any thread.
 */
public final class FolderFiles {
    private static final int O_NONBLOCK = 0x800;
    private static final int O_DIRECTORY = 0x10000;
    private static final int O_CLOEXEC = 0x80000;
    private static final int ENOENT = 2;
    private static final int ENOTDIR = 20;

    private FolderFiles() {}

    /**
     * Returns the paths of all files in a folder, in the order of their names. A link in the place
     * of the folder is followed.
     *
     * @throws IOException with the reason, if it is not a folder, or cannot be read
     */
    public static List<Path> in(Path folder) throws IOException {
        int descriptor = Posix.open(folder.toString(), O_NONBLOCK | O_DIRECTORY | O_CLOEXEC);
        switch (-descriptor) {
            case ENOENT -> throw refused(folder, "there is no such folder");
            case ENOTDIR -> throw refused(folder, "it is not a folder");
            default -> {
                if (descriptor < 0) {
                    throw refused(folder, Posix.words(-descriptor));
                }
            }
        }
        // The path in /proc is used, because it leads to the opened folder even if another folder
        // is now at the original path.
        try (Stream<Path> files = Files.list(Path.of("/proc/self/fd/" + descriptor))) {
            return files.map(file -> folder.resolve(file.getFileName())).sorted().toList();
        } finally {
            Posix.close(descriptor);
        }
    }

    private static FileSystemException refused(Path folder, String reason) {
        return new FileSystemException(folder.toString(), null, reason);
    }
}
