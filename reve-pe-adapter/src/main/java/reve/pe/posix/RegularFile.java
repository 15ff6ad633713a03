// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import java.io.FileNotFoundException;
import java.io.IOException;
import java.io.InputStream;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.nio.file.attribute.BasicFileAttributes;

/**
 * Reader of regular files in folders that other processes may change at any time. A link, pipe or
 * device in the place of the file is refused, and does not block the caller. For any thread.
 */
public final class RegularFile {
    private static final int O_RDONLY = 0;
    private static final int O_NONBLOCK = 0x800;
    private static final int O_NOFOLLOW = 0x20000;
    private static final int O_CLOEXEC = 0x80000;
    private static final int ENOENT = 2;
    private static final int ELOOP = 40;

    private RegularFile() {}

    /**
     * Reads a whole file.
     *
     * @param most maximum size [bytes]
     * @throws IOException with the reason, if the file is not a regular file, is larger, or cannot
     *     be read
     */
    public static byte[] read(Path file, int most) throws IOException {
        int descriptor =
                Posix.open(file.toString(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
        if (descriptor == -ELOOP) {
            throw new IOException(
                    "expected a regular file, found a symbolic link; copy the file itself here");
        }
        if (descriptor == -ENOENT) {
            throw new FileNotFoundException("there is no such file");
        }
        if (descriptor < 0) {
            throw new IOException(Posix.words(-descriptor));
        }
        try {
            Path opened = Path.of("/proc/self/fd/" + descriptor);
            BasicFileAttributes attributes =
                    Files.readAttributes(opened, BasicFileAttributes.class);
            if (!attributes.isRegularFile()) {
                throw new IOException("expected a regular file, found " + kind(attributes));
            }
            // The path in /proc is used, because it leads to the opened file even if another file
            // is now at the original path.
            try (InputStream in = Files.newInputStream(opened)) {
                byte[] bytes = attributes.size() > most ? null : in.readNBytes(most + 1);
                if (bytes == null || bytes.length > most) {
                    throw new IOException("it has more than " + most + " bytes");
                }
                return bytes;
            }
        } finally {
            Posix.close(descriptor);
        }
    }

    /** Returns the kind of a file that is not a regular file; an empty text for a regular file. */
    public static String otherKind(Path file) throws IOException {
        BasicFileAttributes attributes =
                Files.readAttributes(file, BasicFileAttributes.class, LinkOption.NOFOLLOW_LINKS);
        return attributes.isRegularFile() ? "" : kind(attributes);
    }

    private static String kind(BasicFileAttributes attributes) {
        return attributes.isSymbolicLink()
                ? "a symbolic link; copy the file itself here"
                : attributes.isDirectory() ? "a folder" : "a special file";
    }
}
