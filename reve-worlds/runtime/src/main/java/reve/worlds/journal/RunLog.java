// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.image.CorruptException;
import reve.pe.PreparedLibrary;

import java.io.BufferedInputStream;
import java.io.DataInputStream;
import java.io.EOFException;
import java.io.IOException;
import java.io.InputStream;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.channels.Channels;
import java.nio.channels.FileChannel;
import java.nio.channels.FileLock;
import java.nio.channels.OverlappingFileLockException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.Arrays;
import java.util.HashSet;
import java.util.HexFormat;
import java.util.Iterator;
import java.util.List;
import java.util.NoSuchElementException;
import java.util.Optional;
import java.util.Set;
import java.util.UUID;
import java.util.zip.CRC32C;

/**
 * An append-only file of records: a complete recording, or frames of a store. The file begins with
 * a fixed mark. Each record begins with its length, a letter for its type, its frame, and the
 * CRC32C of these three. The content and the CRC32C of the content follow. Readers ignore an
 * incomplete record at the end of the file, which a crash may leave.
 */
public final class RunLog {
    /** Type letter of the first record in files of a store. */
    private static final char LINK = 'S';

    private static final byte[] MARK = "REVE run log 2\n".getBytes(StandardCharsets.US_ASCII);

    /** Size of a file without any record [bytes]. */
    static final int EMPTY_BYTES = MARK.length;

    private static final int HEAD_BYTES = Integer.BYTES + 1 + Long.BYTES;
    private static final int SUM_BYTES = Integer.BYTES;
    private static final int SHA_BYTES = 32;

    /** Maximum size of a record, which is also SQLite's limit for an image [bytes]. */
    static final int MAX_BYTES = 1_000_000_000;

    /**
     * Minimum size of a large content [bytes]. The checksum of a large content is verified before
     * memory is allocated for it.
     */
    private static final int LARGE_BYTES = 1 << 20;

    private static final int PIECE_BYTES = 1 << 16;

    /** Size of a file of frames of a store without any frame [bytes]. */
    static final int LINKED_BYTES = EMPTY_BYTES + HEAD_BYTES + 2 * SUM_BYTES + Link.BYTES;

    private RunLog() {}

    /**
     * The first record in a file of frames of a store; recordings have none.
     *
     * @param store identity of the store
     * @param number the number of the file
     * @param id the identity of the file
     * @param before the identity of the previous file; 0 if there is no previous file with an
     *     identity
     */
    record Link(UUID store, long number, long id, long before) {
        private static final int BYTES = 4 * Long.BYTES;

        private ByteBuffer encoded() {
            return RunLog.encoded(
                    LINK,
                    number,
                    ByteBuffer.allocate(BYTES)
                            .putLong(store.getMostSignificantBits())
                            .putLong(store.getLeastSignificantBits())
                            .putLong(id)
                            .putLong(before)
                            .array());
        }

        private static Link decoded(long number, byte[] content) {
            ByteBuffer bytes = ByteBuffer.wrap(content);
            return new Link(
                    new UUID(bytes.getLong(), bytes.getLong()),
                    number,
                    bytes.getLong(),
                    bytes.getLong());
        }
    }

    /**
     * Opens a recording; its records are read on demand.
     *
     * @throws CorruptException if the file is not a recording
     */
    public static Reader open(Path file) throws IOException {
        return new Reader(file);
    }

    /**
     * Returns whether a file begins like a recording; true also if a crash has left only a part of
     * the mark.
     */
    public static boolean isRecording(InputStream file) throws IOException {
        byte[] start = file.readNBytes(MARK.length + Integer.BYTES + 1);
        boolean stores =
                start.length > MARK.length + Integer.BYTES && start[start.length - 1] == LINK;
        return !stores
                && Arrays.equals(
                        start,
                        0,
                        Math.min(start.length, MARK.length),
                        MARK,
                        0,
                        Math.min(start.length, MARK.length));
    }

    /** Writer that appends each record by one write. For one thread, except {@link #force}. */
    static final class Writer implements AutoCloseable {
        private final Path file;
        private final FileChannel channel;
        private final long maxBytes;
        private final Optional<FilePlace> place;

        /** Number of bytes written; the file has at least this size. */
        private volatile long written;

        private final Set<String> libraries = new HashSet<>();
        private boolean full;

        /** Begins a recording in an empty file, which the writer closes. */
        Writer(Path file, FileChannel channel, long maxBytes) throws IOException {
            this(file, channel, maxBytes, ByteBuffer.wrap(MARK), false);
        }

        /** Begins a file of frames of a store. */
        Writer(Path file, Link link) throws IOException {
            this(
                    file,
                    emptied(file),
                    Long.MAX_VALUE,
                    ByteBuffer.allocate(LINKED_BYTES).put(MARK).put(link.encoded()).flip(),
                    true);
        }

        private Writer(
                Path file, FileChannel channel, long maxBytes, ByteBuffer start, boolean isWatched)
                throws IOException {
            this.file = file;
            this.channel = channel;
            this.maxBytes = maxBytes;
            try {
                place = isWatched ? Optional.of(FilePlace.of(file)) : Optional.empty();
                add(start);
            } catch (IOException e) {
                channel.close();
                throw e;
            }
        }

        /** Opens a file of a store. Does not follow a link, and does not wait for a pipe. */
        private static FileChannel emptied(Path file) throws IOException {
            if (Files.exists(file, LinkOption.NOFOLLOW_LINKS)
                    && !Files.isRegularFile(file, LinkOption.NOFOLLOW_LINKS)
                    && !Files.isDirectory(file)) {
                // A folder needs no check, because the system refuses to write to it.
                throw new IOException(
                        file + " is no regular file, expected a file of the store; move it away");
            }
            try {
                // A file opened with APPEND stays shorter than {@code written} after another
                // program has truncated it. The method trouble() detects this.
                FileChannel channel =
                        FileChannel.open(
                                file,
                                LinkOption.NOFOLLOW_LINKS,
                                StandardOpenOption.CREATE,
                                StandardOpenOption.WRITE,
                                StandardOpenOption.APPEND);
                try {
                    requireFree(file, channel);
                    return channel.truncate(0);
                } catch (IOException e) {
                    channel.close();
                    throw e;
                }
            } catch (IOException e) {
                throw FileTrouble.of(file, "written", e);
            }
        }

        /** Refuses a file that another process has locked, such as the recording of a server. */
        private static void requireFree(Path file, FileChannel channel) throws IOException {
            try (FileLock lock = channel.size() == 0 ? null : channel.tryLock()) {
                if (lock == null && channel.size() > 0) {
                    throw new IOException(
                            file
                                    + " is in use by another program, expected a file of the store;"
                                    + " let that program write to another file");
                }
            } catch (OverlappingFileLockException ofThisProcess) {
                throw new IOException(
                        file
                                + " is in use as another file of this server, expected a file of the"
                                + " store",
                        ofThisProcess);
            }
        }

        void write(JournalRecord record) throws IOException {
            switch (record) {
                case JournalRecord.Library library -> {
                    if (!libraries.contains(library.sha256())) {
                        add(
                                encoded(
                                        'L',
                                        0,
                                        HexFormat.of().parseHex(library.sha256()),
                                        library.bytes()));
                        libraries.add(library.sha256());
                    }
                }
                case JournalRecord.Image image -> add(encoded('I', image.frame(), image.bytes()));
                case JournalRecord.Frame frame -> add(encoded('F', frame.frame(), frame.json()));
            }
        }

        /** Writes all of the records, or none if they exceed the size limit. */
        void write(List<JournalRecord.Library> needed, JournalRecord.Image image)
                throws IOException {
            long end = channel.position();
            long writtenBefore = written;
            Set<String> before = Set.copyOf(libraries);
            try {
                for (JournalRecord.Library library : needed) {
                    write(library);
                }
                write(image);
            } catch (IOException e) {
                written = writtenBefore;
                takeBack(end, e);
                libraries.retainAll(before);
                throw e;
            }
        }

        /** Returns whether a record was refused because of the size limit. */
        boolean hasItsLimit() {
            return full;
        }

        /**
         * Flushes the written data to the disk, so that it survives a power failure. For any
         * thread.
         */
        void force() throws IOException {
            try {
                channel.force(false);
            } catch (IOException e) {
                throw failed(e);
            }
        }

        /** Returns a message if this file was moved, removed or truncated; empty otherwise. */
        String trouble() {
            long bytes = written;
            String what = place.map(existing -> existing.trouble(bytes)).orElse("");
            return what.isEmpty() ? "" : file + " " + what;
        }

        /**
         * Returns the number of bytes written so far; the file has at least this size. For any
         * thread.
         */
        long written() {
            return written;
        }

        boolean isOpen() {
            return channel.isOpen();
        }

        @Override
        public void close() throws IOException {
            channel.close();
        }

        private void add(ByteBuffer bytes) throws IOException {
            if (bytes.remaining() - HEAD_BYTES - 2 * SUM_BYTES > MAX_BYTES) {
                throw new IOException(
                        file
                                + " cannot hold a record of "
                                + bytes.remaining()
                                + " bytes, expected at most "
                                + MAX_BYTES);
            }
            long end = channel.position();
            long after = written + bytes.remaining();
            // After a record that does not fit, all later records are refused, because no record
            // may follow a gap.
            full |= bytes.remaining() > maxBytes - end;
            if (full) {
                throw new IOException(file + " has its limit of " + maxBytes + " bytes");
            }
            try {
                while (bytes.hasRemaining()) {
                    channel.write(bytes);
                }
                written = after;
            } catch (IOException e) {
                takeBack(end, e);
                throw failed(e);
            }
        }

        private void takeBack(long end, IOException after) {
            try {
                channel.truncate(end).position(end);
            } catch (IOException e) {
                after.addSuppressed(e);
            }
        }

        private IOException failed(IOException e) {
            return FileTrouble.of(file, "written", e);
        }
    }

    private static ByteBuffer encoded(char letter, long frame, byte[]... parts) {
        int length = Math.toIntExact(Arrays.stream(parts).mapToLong(part -> part.length).sum());
        ByteBuffer record =
                ByteBuffer.allocate(HEAD_BYTES + length + 2 * SUM_BYTES)
                        .order(ByteOrder.LITTLE_ENDIAN)
                        .putInt(length)
                        .put((byte) letter)
                        .putLong(frame);
        record.putInt(checksum(record.array(), 0, HEAD_BYTES));
        for (byte[] part : parts) {
            record.put(part);
        }
        return record.putInt(checksum(record.array(), HEAD_BYTES + SUM_BYTES, length)).flip();
    }

    private static int checksum(byte[] bytes, int from, int length) {
        var crc = new CRC32C();
        crc.update(bytes, from, length);
        return (int) crc.getValue();
    }

    /** Reader of the records in order. For one thread. */
    public static final class Reader implements Iterator<JournalRecord>, AutoCloseable {
        private final Path file;
        private final FileChannel channel;
        private final DataInputStream in;
        private final long size;
        private long at = MARK.length;
        private boolean cut;
        private @Nullable Link link;
        private @Nullable JournalRecord next;
        private @Nullable CorruptException damage;

        private Reader(Path file) throws IOException {
            this.file = file;
            if (!Files.isRegularFile(file)) {
                throw new IOException(
                        Files.exists(file)
                                ? file + " is no file that could be a " + "recording"
                                : "there is no recording " + file);
            }
            channel = FileChannel.open(file);
            in =
                    new DataInputStream(
                            new BufferedInputStream(Channels.newInputStream(channel), PIECE_BYTES));
            try {
                size = channel.size();
                if (!Arrays.equals(in.readNBytes(MARK.length), MARK)) {
                    throw new CorruptException(file + " is no recording of this version of REVE");
                }
                advance();
            } catch (IOException | RuntimeException e) {
                in.close();
                throw e;
            }
        }

        private void advance() throws IOException {
            next = null;
            try {
                next = read();
            } catch (CorruptException e) {
                damage = e;
            }
        }

        /** Returns the link to the store that the file belongs to; empty for a recording. */
        Optional<Link> link() {
            return Optional.ofNullable(link);
        }

        /**
         * Returns the number of the last frame that the file seems to have, for a progress message;
         * -1 for none. Reads only the heads of the records, and does not check their checksums.
         */
        public long lastFrame() throws IOException {
            ByteBuffer head = ByteBuffer.allocate(HEAD_BYTES).order(ByteOrder.LITTLE_ENDIAN);
            long last = -1;
            long next = at;
            while (next + HEAD_BYTES + 2 * SUM_BYTES <= size) {
                fill(head.clear(), next);
                int length = head.getInt();
                char letter = (char) head.get();
                if (length < 0 || "LIF".indexOf(letter) < 0) {
                    break;
                }
                last = letter == 'L' ? last : Math.max(last, head.getLong());
                next += HEAD_BYTES + (long) length + 2 * SUM_BYTES;
            }
            return last;
        }

        /**
         * Returns whether the file ends in the middle of a record. Valid after the last record was
         * read.
         */
        public boolean wasCut() {
            return cut;
        }

        @Override
        public boolean hasNext() {
            return next != null || damage != null;
        }

        /**
         * Returns the next record.
         *
         * @throws CorruptException naming the position in the file, if the record is damaged
         */
        @Override
        public JournalRecord next() {
            if (damage != null) {
                throw damage;
            }
            JournalRecord record = next;
            if (record == null) {
                throw new NoSuchElementException(file + " has ended");
            }
            try {
                advance();
            } catch (IOException e) {
                throw new UncheckedIOException(FileTrouble.of(file, "read", e).getMessage(), e);
            }
            return record;
        }

        @Override
        public void close() throws IOException {
            in.close();
        }

        private @Nullable JournalRecord read() throws IOException {
            long left = size - at;
            if (left < HEAD_BYTES + SUM_BYTES) {
                cut = left > 0;
                return null;
            }
            byte[] bytes = new byte[HEAD_BYTES];
            in.readFully(bytes);
            ByteBuffer head = ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN);
            int length = head.getInt();
            if (nextSum() != checksum(bytes, 0, HEAD_BYTES) || length < 0) {
                throw damaged();
            }
            if (length > left - HEAD_BYTES - 2 * SUM_BYTES) {
                cut = true;
                return null;
            }
            boolean fits =
                    length
                            <= (bytes[Integer.BYTES] == 'L'
                                    ? PreparedLibrary.MAX_BYTES + SHA_BYTES
                                    : MAX_BYTES);
            if (!fits || length > LARGE_BYTES && !isGood(length)) {
                throw damaged();
            }
            byte[] content = new byte[length];
            in.readFully(content);
            if (nextSum() != checksum(content, 0, length)) {
                throw damaged();
            }
            char letter = (char) head.get();
            long frame = head.getLong();
            if (letter == LINK && at == MARK.length && length == Link.BYTES) {
                link = Link.decoded(frame, content);
                at = LINKED_BYTES;
                return read();
            }
            JournalRecord record = decoded(letter, frame, content);
            at += HEAD_BYTES + length + 2 * SUM_BYTES;
            return record;
        }

        /**
         * Returns whether the checksum of a content is right. The checksum is verified before
         * memory is allocated, because a damaged or sparse file can claim any length.
         */
        private boolean isGood(int length) throws IOException {
            long from = at + HEAD_BYTES + SUM_BYTES;
            ByteBuffer piece = ByteBuffer.allocate(PIECE_BYTES).order(ByteOrder.LITTLE_ENDIAN);
            var crc = new CRC32C();
            for (long end = from + length; from < end; from += piece.limit()) {
                fill(piece.clear().limit((int) Math.min(piece.capacity(), end - from)), from);
                crc.update(piece);
            }
            fill(piece.clear().limit(SUM_BYTES), from);
            return piece.getInt() == (int) crc.getValue();
        }

        private void fill(ByteBuffer piece, long from) throws IOException {
            while (piece.hasRemaining()) {
                if (channel.read(piece, from + piece.position()) < 0) {
                    throw new EOFException("it has become shorter");
                }
            }
            piece.flip();
        }

        private int nextSum() throws IOException {
            return Integer.reverseBytes(in.readInt());
        }

        private JournalRecord decoded(char letter, long frame, byte[] content) {
            return switch (letter) {
                case 'L' -> {
                    if (content.length < SHA_BYTES) {
                        throw damaged();
                    }
                    yield new JournalRecord.Library(
                            HexFormat.of().formatHex(content, 0, SHA_BYTES),
                            Arrays.copyOfRange(content, SHA_BYTES, content.length));
                }
                case 'I' -> new JournalRecord.Image(frame, content);
                case 'F' -> new JournalRecord.Frame(frame, content);
                default -> throw damaged();
            };
        }

        private CorruptException damaged() {
            return new CorruptException(
                    file
                            + " is damaged in the record at byte "
                            + at
                            + "; nothing after it can be trusted");
        }
    }
}
