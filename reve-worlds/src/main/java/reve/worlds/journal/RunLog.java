package reve.worlds.journal;

import java.io.BufferedInputStream;
import java.io.DataInputStream;
import java.io.IOException;
import java.io.InputStream;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.channels.FileChannel;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.Arrays;
import java.util.HexFormat;
import java.util.Iterator;
import java.util.NoSuchElementException;
import java.util.zip.CRC32C;
import org.jspecify.annotations.Nullable;
import reve.core.store.CorruptException;

/**
 * A recording: one file, only ever added to. A mark, then each record as its length, a letter for
 * what it is, its numbers and bytes, and the CRC32C of all of these. A file that ends in the middle
 * of a record, as after a crash, ends before it.
 */
public final class RunLog {
    private static final byte[] MARK = "REVE run log 1\n".getBytes(StandardCharsets.US_ASCII);
    private static final int HEAD_BYTES = Integer.BYTES + 1 + 2 * Long.BYTES;
    private static final int SHA_BYTES = 32;

    private RunLog() {}

    /** Begins a recording in place of what the file held. */
    public static JournalSink create(Path file) throws IOException {
        FileChannel channel = FileChannel.open(file, StandardOpenOption.CREATE,
                StandardOpenOption.WRITE, StandardOpenOption.TRUNCATE_EXISTING);
        try {
            writeFully(channel, ByteBuffer.wrap(MARK));
        } catch (IOException e) {
            channel.close();
            throw e;
        }
        return new Writer(file, channel);
    }

    /**
     * The records of a recording, which is read as it goes.
     *
     * @throws CorruptException if the file is no recording
     */
    public static Reader open(Path file) throws IOException {
        return new Reader(file);
    }

    private static void writeFully(FileChannel channel, ByteBuffer bytes) throws IOException {
        while (bytes.hasRemaining()) {
            channel.write(bytes);
        }
    }

    private record Writer(Path file, FileChannel channel) implements JournalSink {
        @Override
        public void write(JournalRecord record) throws IOException {
            long end = channel.position();
            try {
                writeFully(channel, encoded(record));
            } catch (IOException e) {
                channel.truncate(end).position(end);
                throw new IOException(file + " could not be written: " + e.getMessage(), e);
            }
        }

        @Override
        public void close() throws IOException {
            channel.close();
        }
    }

    private static ByteBuffer encoded(JournalRecord record) {
        return switch (record) {
            case JournalRecord.Library library -> encoded('L', 0, 0,
                    HexFormat.of().parseHex(library.sha256()), library.bytes());
            case JournalRecord.Image image ->
                    encoded('I', image.frame(), image.frame(), image.bytes());
            case JournalRecord.Frames frames ->
                    encoded('F', frames.first(), frames.last(), frames.lines());
        };
    }

    private static ByteBuffer encoded(char letter, long first, long last, byte[]... parts) {
        int length = Arrays.stream(parts).mapToInt(part -> part.length).sum();
        ByteBuffer record = ByteBuffer.allocate(HEAD_BYTES + length + Integer.BYTES)
                .order(ByteOrder.LITTLE_ENDIAN)
                .putInt(length).put((byte) letter).putLong(first).putLong(last);
        for (byte[] part : parts) {
            record.put(part);
        }
        return record.putInt(checksum(record.array(), record.position())).flip();
    }

    private static int checksum(byte[] bytes, int length) {
        var crc = new CRC32C();
        crc.update(bytes, 0, length);
        return (int) crc.getValue();
    }

    /** Records one after the other. One thread. */
    public static final class Reader implements Iterator<JournalRecord>, AutoCloseable {
        private final Path file;
        private final DataInputStream in;
        private final long size;
        private long at = MARK.length;
        private boolean cut;
        private @Nullable JournalRecord next;

        private Reader(Path file) throws IOException {
            this.file = file;
            size = Files.size(file);
            InputStream stream = Files.newInputStream(file);
            in = new DataInputStream(new BufferedInputStream(stream, 1 << 16));
            if (!Arrays.equals(in.readNBytes(MARK.length), MARK)) {
                in.close();
                throw new CorruptException(file + " is no recording of this version of REVE");
            }
            next = read();
        }

        /** Whether the file ends in the middle of a record; known at the end. */
        public boolean wasCut() {
            return cut;
        }

        @Override
        public boolean hasNext() {
            return next != null;
        }

        /** @throws CorruptException naming the place in the file, if a record is damaged */
        @Override
        public JournalRecord next() {
            JournalRecord record = next;
            if (record == null) {
                throw new NoSuchElementException(file + " has ended");
            }
            try {
                next = read();
            } catch (IOException e) {
                throw new UncheckedIOException(file + " cannot be read: "
                        + e.getMessage(), e);
            }
            return record;
        }

        @Override
        public void close() throws IOException {
            in.close();
        }

        private @Nullable JournalRecord read() throws IOException {
            long left = size - at;
            if (left < HEAD_BYTES + Integer.BYTES) {
                cut = left > 0;
                return null;
            }
            byte[] head = in.readNBytes(HEAD_BYTES);
            int length = ByteBuffer.wrap(head).order(ByteOrder.LITTLE_ENDIAN).getInt();
            if (length < 0) {
                throw damaged();
            }
            if (length > left - HEAD_BYTES - Integer.BYTES) {
                cut = true;
                return null;
            }
            byte[] record = Arrays.copyOf(head, HEAD_BYTES + length);
            in.readFully(record, HEAD_BYTES, length);
            int sum = Integer.reverseBytes(in.readInt());
            if (sum != checksum(record, record.length)) {
                throw damaged();
            }
            at += record.length + Integer.BYTES;
            return decoded(record);
        }

        private JournalRecord decoded(byte[] record) {
            ByteBuffer head = ByteBuffer.wrap(record).order(ByteOrder.LITTLE_ENDIAN);
            head.getInt();
            char letter = (char) head.get();
            long first = head.getLong();
            long last = head.getLong();
            byte[] body = Arrays.copyOfRange(record, HEAD_BYTES, record.length);
            return switch (letter) {
                case 'L' -> new JournalRecord.Library(
                        HexFormat.of().formatHex(body, 0, SHA_BYTES),
                        Arrays.copyOfRange(body, SHA_BYTES, body.length));
                case 'I' -> new JournalRecord.Image(first, body);
                case 'F' -> new JournalRecord.Frames(first, last, body);
                default -> throw damaged();
            };
        }

        private CorruptException damaged() {
            return new CorruptException(file + " is damaged in the record at byte " + at
                    + "; nothing after it can be trusted");
        }
    }
}
