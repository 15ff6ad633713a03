// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.sqlite.SQLiteErrorCode;

import java.io.IOException;
import java.nio.channels.FileChannel;
import java.nio.file.AccessDeniedException;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.sql.SQLException;
import java.util.List;
import java.util.Optional;

/** Messages for files that could not be opened, read or written. */
final class FileTrouble {
    private static final int CODE_BITS = 0xff;

    /** Disk space that SQLite needs for opening a database [bytes]. */
    private static final long ROOM = 1 << 20;

    private FileTrouble() {}

    /**
     * Returns an exception with a message for a failed file operation.
     *
     * @param what the operation, as a participle such as "read"
     */
    static IOException of(Path file, String what, IOException e) {
        return new IOException(file + " could not be " + what + ": " + reason(file, e), e);
    }

    /**
     * Returns an exception with a message for a failed database operation.
     *
     * @param what the operation, as a participle such as "read"
     */
    static IOException of(Path file, String what, SQLException e) {
        SQLiteErrorCode code = SQLiteErrorCode.getErrorCode(e.getErrorCode() & CODE_BITS);
        if (code == SQLiteErrorCode.SQLITE_BUSY) {
            return new IOException(
                    file
                            + " is in use by another process (the database is locked);"
                            + " end that one first, or name another file",
                    e);
        }
        String reason =
                switch (code) {
                    case SQLITE_CANTOPEN, SQLITE_READONLY, SQLITE_PERM -> whyNotOpened(file);
                    case SQLITE_FULL, SQLITE_IOERR -> whyNotWritten(file, e);
                    default -> e.getMessage();
                };
        return new IOException(file + " could not be " + what + ": " + reason, e);
    }

    /**
     * Returns the kind of object at the path, such as a folder or a broken link. The result is
     * empty for a readable file.
     */
    static Optional<String> noFile(Path file) {
        if (Files.isDirectory(file)) {
            return Optional.of(file + " is a folder");
        }
        return Files.isSymbolicLink(file) && !Files.exists(file)
                ? Optional.of(file + " is a link to a file that is not there")
                : Optional.empty();
    }

    static String reason(Path file, IOException e) {
        return switch (e) {
            case NoSuchFileException gone -> noPlace(file.toAbsolutePath().getParent());
            case AccessDeniedException denied -> "permission denied";
            case FileSystemException other when other.getReason() != null ->
                    advised(other.getReason());
            default -> e.getMessage() == null ? e.toString() : advised(e.getMessage());
        };
    }

    private static String advised(String reason) {
        return reason.contains("Too many open files")
                ? "Too many open files; raise the limit of " + "the process (ulimit -n)"
                : reason;
    }

    private static String whyNotWritten(Path file, SQLException e) {
        Path folder = file.toAbsolutePath().getParent();
        try {
            long free = Files.getFileStore(folder).getUsableSpace();
            if (free < ROOM) {
                return "the disk is full, "
                        + free
                        + " bytes are free, expected "
                        + ROOM
                        + " at least; make room on the disk of "
                        + folder
                        + ", or move the store with all its files to another one";
            }
        } catch (IOException unknown) {
            e.addSuppressed(unknown);
        }
        return "the disk refused to read or write: " + e.getMessage();
    }

    /**
     * Returns why a file cannot be opened. SQLite does not report the reason, so this method opens
     * the file itself and returns the system's message.
     */
    private static String whyNotOpened(Path file) {
        Path folder = file.toAbsolutePath().getParent();
        for (String beside : List.of("-wal", "-shm")) {
            Path other = Path.of(file + beside);
            if (Files.isDirectory(other) || Files.isSymbolicLink(other)) {
                return other
                        + (Files.isDirectory(other) ? " is a folder" : " is a link")
                        + ", expected a file of the database or nothing; move it away";
            }
        }
        try (FileChannel _ =
                FileChannel.open(file, StandardOpenOption.READ, StandardOpenOption.WRITE)) {
            return Files.isWritable(folder)
                    ? "SQLite could not open a file beside it; raise the "
                            + "limit of open files (ulimit -n), and see that "
                            + file
                            + "-wal may be "
                            + "read and written"
                    : "the folder " + folder + " may not be written";
        } catch (IOException e) {
            return reason(file, e);
        }
    }

    private static String noPlace(Path folder) {
        return Files.isDirectory(folder)
                ? "the folder " + folder + " takes no such file"
                : "there is no folder " + folder;
    }
}
