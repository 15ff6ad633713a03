// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.attribute.BasicFileAttributes;

/**
 * A path and the file that it led to when the file was opened: what is written to a file that was
 * moved or removed is lost with it. Any thread.
 */
record FilePlace(Path path, Object key) {
    static FilePlace of(Path path) throws IOException {
        return new FilePlace(path, attributes(path).fileKey());
    }

    /**
     * Returns what became of the file, as the rest of a sentence; empty if its path still leads to
     * all of it, or that cannot be told.
     *
     * @param bytes size that it has at least
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
