// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import java.io.Closeable;
import java.io.IOException;
import java.nio.channels.FileChannel;
import java.nio.channels.OverlappingFileLockException;
import java.nio.file.DirectoryStream;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.BasicFileAttributes;
import java.nio.file.attribute.FileAttribute;
import java.util.Optional;
import java.util.Set;

/**
 * A file to which one process appends. The file is locked until this object is closed or the
 * process ends. Devices are not locked. Pipes are refused, because opening one waits for a reader.
 *
 * <p>This process must not open the file a second time meanwhile, because closing any channel of
 * the file releases the lock. For one thread.
 */
public final class OwnedFile implements Closeable {
    private static final int TRIES = 5;

    /** Mask of the file type in a Unix file mode. The next constant is the type of a pipe. */
    private static final int TYPE_BITS = 0170000;

    private static final int PIPE = 0010000;

    private final Path path;
    private final FileChannel channel;
    private final Optional<Object> key;

    private OwnedFile(Path path, FileChannel channel, Optional<Object> key) {
        this.path = path;
        this.channel = channel;
        this.key = key;
    }

    /**
     * Opens a file, or creates it with these attributes.
     *
     * @throws IOException if the file cannot be opened, the path is a pipe, or another process has
     *     locked the file
     */
    public static OwnedFile open(Path path, FileAttribute<?>... attributes) throws IOException {
        for (int i = 0; i < TRIES; i++) {
            Optional<Object> before = key(path);
            if (before.isPresent()
                    && ((int) Files.getAttribute(path, "unix:mode") & TYPE_BITS) == PIPE) {
                throw new FileSystemException(
                        path.toString(), null, "it is a pipe, expected a file; name another file");
            }
            FileChannel channel =
                    FileChannel.open(
                            path,
                            Set.of(
                                    StandardOpenOption.CREATE,
                                    StandardOpenOption.WRITE,
                                    StandardOpenOption.APPEND),
                            attributes);
            try {
                if (Files.isRegularFile(path)) {
                    lock(path, channel);
                }
            } catch (IOException e) {
                channel.close();
                throw e;
            }
            Optional<Object> after = key(path);
            if (after.isPresent() && (before.isEmpty() || before.equals(after))) {
                return new OwnedFile(path, channel, after);
            }
            channel.close(); // another program moved the file before it was locked
        }
        throw new FileSystemException(
                path.toString(), null, "something moves or removes it again and again");
    }

    private static void lock(Path path, FileChannel channel) throws IOException {
        boolean locked;
        try {
            locked = channel.tryLock() != null;
        } catch (OverlappingFileLockException ofThisProcess) {
            locked = false;
        }
        if (!locked) {
            throw new FileSystemException(
                    path.toString(),
                    null,
                    "it is in use by another process;"
                            + " end that one first, or name another file");
        }
    }

    private static Optional<Object> key(Path path) throws IOException {
        try {
            return Optional.of(Files.readAttributes(path, BasicFileAttributes.class).fileKey());
        } catch (NoSuchFileException none) {
            return Optional.empty();
        }
    }

    /** Returns the open file; {@link #close} closes it. */
    public FileChannel channel() {
        return channel;
    }

    /**
     * Returns whether the path still leads to the open file. The result is false after another
     * program has moved or removed the file.
     */
    public boolean isInPlace() {
        try {
            return key(path).equals(key);
        } catch (IOException unknown) {
            return false;
        }
    }

    /**
     * Returns the damage that another program did to the file, as the end of a sentence, for
     * example "was moved or removed". Returns an empty text if the path leads to the complete file.
     * For any thread.
     *
     * @param written number of bytes that the file must have; ignored for a device
     */
    public String trouble(long written) {
        if (!isInPlace()) {
            return "was moved or removed";
        }
        try {
            long size = Files.size(path);
            return size < written && Files.isRegularFile(path)
                    ? "was cut to " + size + " of " + written + " bytes"
                    : "";
        } catch (IOException unknown) {
            return "";
        }
    }

    /**
     * Renames a file to {@code FILE.1}. First renames {@code FILE.1} to {@code FILE.2} and so on,
     * up to the first free number. The oldest file is replaced if no number is free.
     *
     * @param keep maximum number of older files, at least 1
     * @param kind check of the content of each older file
     * @return the new path of the file
     * @throws IOException if nothing was renamed, for example because an older file has other
     *     content or is in use
     */
    public static Path rotate(Path file, int keep, Kind kind) throws IOException {
        int free = 1;
        while (free < keep && Files.exists(older(file, free), LinkOption.NOFOLLOW_LINKS)) {
            requireOlder(older(file, free), kind);
            free++;
        }
        if (Files.exists(older(file, free), LinkOption.NOFOLLOW_LINKS)) {
            requireOlder(older(file, free), kind);
        }
        for (int i = free; i > 0; i--) {
            Files.move(older(file, i - 1), older(file, i), StandardCopyOption.ATOMIC_MOVE);
        }
        return older(file, 1);
    }

    /**
     * Check that a file has the content that the program expects, before the file is renamed or
     * replaced.
     */
    @FunctionalInterface
    public interface Kind {
        /**
         * Checks the content of a file.
         *
         * @throws IOException naming the file, if it has other content
         */
        void require(Path file) throws IOException;
    }

    /**
     * Checks that {@link #rotate} can rename a file later. Throws an exception in these cases:
     *
     * <ul>
     *   <li>an older file has other content
     *   <li>an older file is in use
     *   <li>the name of an older file would be too long
     * </ul>
     *
     * @param keep maximum number of older files
     */
    public static void requireOlder(Path file, int keep, Kind kind) throws IOException {
        requireName(file, "." + keep);
        Path folder = file.toAbsolutePath().getParent();
        if (!Files.isDirectory(folder)) {
            return;
        }
        String prefix = file.getFileName() + ".";
        try (DirectoryStream<Path> siblings =
                Files.newDirectoryStream(
                        folder, each -> each.getFileName().toString().startsWith(prefix))) {
            for (Path sibling : siblings) {
                String digits = sibling.getFileName().toString().substring(prefix.length());
                if (digits.matches("[1-9][0-9]{0,8}") && Integer.parseInt(digits) <= keep) {
                    requireOlder(older(file, Integer.parseInt(digits)), kind);
                }
            }
        }
    }

    /**
     * Throws an exception for an older file that must not be renamed or replaced. Checks the
     * content before the lock, because closing the file after reading releases locks of this
     * process.
     */
    private static void requireOlder(Path older, Kind kind) throws IOException {
        if (!Files.isRegularFile(older)) {
            throw new IOException(
                    older + " is there already and is no file; name another file, or remove it");
        }
        kind.require(older);
        try (FileChannel channel = FileChannel.open(older)) {
            if (channel.tryLock(0, Long.MAX_VALUE, true) == null) {
                throw new IOException(older + " is in use by another process; name another file");
            }
        } catch (OverlappingFileLockException ofThisProcess) {
            throw new IOException(older + " is in use by this process", ofThisProcess);
        }
    }

    /**
     * Checks that the file system permits a name that consists of the file's name and an ending.
     *
     * @param ending longest ending that the program appends to the name
     */
    public static void requireName(Path file, String ending) throws IOException {
        try {
            Files.readAttributes(
                    file.resolveSibling(file.getFileName() + ending), BasicFileAttributes.class);
        } catch (FileSystemException e) {
            if ("File name too long".equals(e.getReason())) {
                throw new IOException(
                        "its name is too long: the files beside it have names up to NAME"
                                + ending
                                + "; take a shorter name");
            }
        }
    }

    /**
     * Returns the path {@code FILE.number} of an older file. The number 0 means the file itself.
     */
    public static Path older(Path file, int number) {
        return number == 0 ? file : file.resolveSibling(file.getFileName() + "." + number);
    }

    /** Closes the file and releases the lock. Idempotent. */
    @Override
    public void close() throws IOException {
        channel.close();
    }
}
