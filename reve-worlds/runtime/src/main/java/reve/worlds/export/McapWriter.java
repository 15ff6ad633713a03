// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import net.jpountz.lz4.LZ4Factory;
import net.jpountz.lz4.LZ4FrameOutputStream;
import net.jpountz.xxhash.XXHashFactory;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.TreeMap;
import java.util.zip.CRC32;

/**
 * A writer of the MCAP format, version 0 (specification at mcap.dev). The file contains messages in
 * chunks that are compressed with LZ4, an index of each chunk, and a summary with statistics at the
 * end. Equal input gives equal bytes. For one thread.
 */
final class McapWriter {
    private static final byte[] MAGIC = {(byte) 0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
    private static final String COMPRESSION = "lz4";

    /** Size before compression at which a chunk is complete and is written [bytes]. */
    private static final int CHUNK_BYTES = 1 << 20;

    private static final int HEADER = 0x01;
    private static final int FOOTER = 0x02;
    private static final int SCHEMA = 0x03;
    private static final int CHANNEL = 0x04;
    private static final int MESSAGE = 0x05;
    private static final int CHUNK = 0x06;
    private static final int MESSAGE_INDEX = 0x07;
    private static final int CHUNK_INDEX = 0x08;
    private static final int STATISTICS = 0x0B;
    private static final int METADATA = 0x0C;
    private static final int METADATA_INDEX = 0x0D;
    private static final int SUMMARY_OFFSET = 0x0E;
    private static final int DATA_END = 0x0F;

    private final OutputStream out;
    private final CRC32 sum = new CRC32();
    private final List<byte[]> schemas = new ArrayList<>();
    private final List<byte[]> channels = new ArrayList<>();
    private final List<byte[]> chunkIndexes = new ArrayList<>();
    private final List<byte[]> metadataIndexes = new ArrayList<>();
    private final TreeMap<Integer, Long> messages = new TreeMap<>();
    private Record chunk = new Record();

    /** For each channel, the time and the position of each message of the chunk, alternating. */
    private final TreeMap<Integer, List<Long>> places = new TreeMap<>();

    private long position;
    private long chunkFirst = Long.MAX_VALUE;
    private long chunkLast;
    private long first = Long.MAX_VALUE;
    private long last;

    /**
     * A buffer for the content of a record, or for a list of records. Numbers are little-endian.
     */
    private static final class Record extends ByteArrayOutputStream {
        private final ByteBuffer number = ByteBuffer.allocate(8).order(ByteOrder.LITTLE_ENDIAN);

        Record u8(int value) {
            write(value);
            return this;
        }

        Record u16(int value) {
            write(number.clear().putShort((short) value).array(), 0, 2);
            return this;
        }

        Record u32(long value) {
            write(number.clear().putInt((int) value).array(), 0, 4);
            return this;
        }

        Record u64(long value) {
            write(number.clear().putLong(value).array(), 0, 8);
            return this;
        }

        Record raw(byte[] bytes) {
            write(bytes, 0, bytes.length);
            return this;
        }

        Record text(String value) {
            byte[] bytes = value.getBytes(StandardCharsets.UTF_8);
            return u32(bytes.length).raw(bytes);
        }

        Record map(Map<String, String> map) {
            Record entries = new Record();
            map.forEach((key, value) -> entries.text(key).text(value));
            return u32(entries.size()).raw(entries.toByteArray());
        }

        /** Appends a record of this type. */
        Record record(int type, byte[] content) {
            return u8(type).u64(content.length).raw(content);
        }
    }

    /** Writes the beginning of a file; the caller closes the stream after {@link #finish()}. */
    McapWriter(OutputStream out, String library) throws IOException {
        this.out = out;
        write(MAGIC);
        write(HEADER, new Record().text("").text(library).toByteArray());
    }

    /**
     * Adds a channel with messages in JSON.
     *
     * @param schema a JSON schema of the messages
     * @return the number of the channel
     */
    int channel(String topic, String schemaName, byte[] schema, Map<String, String> metadata) {
        int number = channels.size() + 1;
        byte[] schemaRecord =
                new Record()
                        .u16(number)
                        .text(schemaName)
                        .text("jsonschema")
                        .u32(schema.length)
                        .raw(schema)
                        .toByteArray();
        byte[] channel =
                new Record()
                        .u16(number)
                        .u16(number)
                        .text(topic)
                        .text("json")
                        .map(metadata)
                        .toByteArray();
        schemas.add(schemaRecord);
        channels.add(channel);
        chunk.record(SCHEMA, schemaRecord).record(CHANNEL, channel);
        messages.put(number, 0L);
        return number;
    }

    /**
     * Adds a message.
     *
     * @param nanos time of the message [ns], not negative
     */
    void message(int channel, long nanos, byte[] json) throws IOException {
        long sequence = messages.merge(channel, 1L, Long::sum);
        List<Long> place = places.computeIfAbsent(channel, _ -> new ArrayList<>());
        place.add(nanos);
        place.add((long) chunk.size());
        chunk.record(
                MESSAGE,
                new Record()
                        .u16(channel)
                        .u32(sequence)
                        .u64(nanos)
                        .u64(nanos)
                        .raw(json)
                        .toByteArray());
        chunkFirst = Math.min(chunkFirst, nanos);
        chunkLast = Math.max(chunkLast, nanos);
        first = Math.min(first, nanos);
        last = Math.max(last, nanos);
        if (chunk.size() >= CHUNK_BYTES) {
            endChunk();
        }
    }

    /**
     * Writes a record with data about the whole file. It comes after the messages written so far.
     */
    void metadata(String name, Map<String, String> data) throws IOException {
        endChunk();
        byte[] record = new Record().text(name).map(data).toByteArray();
        long start = position;
        write(METADATA, record);
        metadataIndexes.add(new Record().u64(start).u64(position - start).text(name).toByteArray());
    }

    private void endChunk() throws IOException {
        if (chunk.size() == 0) {
            return;
        }
        byte[] plain = chunk.toByteArray();
        byte[] packed = compressed(plain);
        boolean empty = places.isEmpty();
        long start = position;
        write(
                CHUNK,
                new Record()
                        .u64(empty ? 0 : chunkFirst)
                        .u64(chunkLast)
                        .u64(plain.length)
                        .u32(checksum(plain))
                        .text(COMPRESSION)
                        .u64(packed.length)
                        .raw(packed)
                        .toByteArray());
        long length = position - start;
        Map<Integer, Long> offsets = new LinkedHashMap<>();
        for (Map.Entry<Integer, List<Long>> place : places.entrySet()) {
            offsets.put(place.getKey(), position);
            Record list = new Record();
            place.getValue().forEach(list::u64);
            write(
                    MESSAGE_INDEX,
                    new Record()
                            .u16(place.getKey())
                            .u32(list.size())
                            .raw(list.toByteArray())
                            .toByteArray());
        }
        Record map = new Record();
        offsets.forEach((channel, offset) -> map.u16(channel).u64(offset));
        chunkIndexes.add(
                new Record()
                        .u64(empty ? 0 : chunkFirst)
                        .u64(chunkLast)
                        .u64(start)
                        .u64(length)
                        .u32(map.size())
                        .raw(map.toByteArray())
                        .u64(position - start - length)
                        .text(COMPRESSION)
                        .u64(packed.length)
                        .u64(plain.length)
                        .toByteArray());
        chunk = new Record();
        places.clear();
        chunkFirst = Long.MAX_VALUE;
        chunkLast = 0;
    }

    /**
     * Returns an LZ4 frame. Uses an encoder in Java, because the output of a native encoder would
     * depend on the machine.
     */
    private static byte[] compressed(byte[] plain) {
        var packed = new ByteArrayOutputStream();
        try (var frame =
                new LZ4FrameOutputStream(
                        packed,
                        LZ4FrameOutputStream.BLOCKSIZE.SIZE_1MB,
                        plain.length,
                        LZ4Factory.safeInstance().fastCompressor(),
                        XXHashFactory.safeInstance().hash32(),
                        LZ4FrameOutputStream.FLG.Bits.BLOCK_INDEPENDENCE,
                        LZ4FrameOutputStream.FLG.Bits.CONTENT_SIZE)) {
            frame.write(plain);
        } catch (IOException impossible) {
            throw new UncheckedIOException(impossible);
        }
        return packed.toByteArray();
    }

    private static long checksum(byte[] bytes) {
        var crc = new CRC32();
        crc.update(bytes);
        return crc.getValue();
    }

    /** Writes the last chunk, the summary and the end of the file. */
    void finish() throws IOException {
        endChunk();
        write(DATA_END, new Record().u32(sum.getValue()).toByteArray());
        long start = position;
        sum.reset();
        Record groups = new Record();
        group(groups, SCHEMA, schemas);
        group(groups, CHANNEL, channels);
        group(groups, STATISTICS, List.of(statistics()));
        group(groups, CHUNK_INDEX, chunkIndexes);
        group(groups, METADATA_INDEX, metadataIndexes);
        long offsets = position;
        write(groups.toByteArray());
        Record footer = new Record().u8(FOOTER).u64(20).u64(start).u64(offsets);
        write(footer.toByteArray());
        write(new Record().u32(sum.getValue()).raw(MAGIC).toByteArray());
    }

    private void group(Record groups, int type, List<byte[]> records) throws IOException {
        long start = position;
        for (byte[] record : records) {
            write(type, record);
        }
        if (!records.isEmpty()) {
            groups.record(
                    SUMMARY_OFFSET,
                    new Record().u8(type).u64(start).u64(position - start).toByteArray());
        }
    }

    private byte[] statistics() {
        Record counts = new Record();
        messages.forEach((channel, count) -> counts.u16(channel).u64(count));
        long all = messages.values().stream().mapToLong(Long::longValue).sum();
        return new Record()
                .u64(all)
                .u16(schemas.size())
                .u32(channels.size())
                .u32(0)
                .u32(metadataIndexes.size())
                .u32(chunkIndexes.size())
                .u64(all == 0 ? 0 : first)
                .u64(last)
                .u32(counts.size())
                .raw(counts.toByteArray())
                .toByteArray();
    }

    private void write(int type, byte[] content) throws IOException {
        write(new Record().record(type, content).toByteArray());
    }

    private void write(byte[] bytes) throws IOException {
        out.write(bytes);
        sum.update(bytes);
        position += bytes.length;
    }
}
