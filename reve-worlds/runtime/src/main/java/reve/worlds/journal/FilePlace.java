// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.attribute.BasicFileAttributes;

/**
 * A path and the identity of the file that was opened there. A comparison of both shows whether the
 * file was moved or removed. Data that is written to such a file would be lost. For any thread.
 */
record FilePlace(Path path, Object key) {
    static FilePlace of(Path path) throws IOException {
        return new FilePlace(path, attributes(path).fileKey());
    }

    /** Returns whether the path leads to another file now. */
    boolean isReplaced() {
        try {
            return !attributes(path).fileKey().equals(key);
        } catch (IOException unknown) {
            return false;
        }
    }

    /**
     * Returns the end of a sentence that states what happened to the file. The result is empty if
     * the path still leads to the complete file, or if the state of the file is unknown.
     *
     * @param bytes minimum size of the file [bytes]
     */
    String trouble(long bytes) {
        try {
            BasicFileAttributes now = attributes(path);
            return !now.fileKey().equals(key)
                    ? "was replaced by another file"
                    : now.size() < bytes
                            ? "was cut to " + now.size() + " of " + bytes + " bytes"
                            : "";
        } catch (NoSuchFileException e) {
            return "was removed";
        } catch (IOException unknown) {
            return "";
        }
    }

    private static BasicFileAttributes attributes(Path path) throws IOException {
        return Files.readAttributes(path, BasicFileAttributes.class);
    }
}
