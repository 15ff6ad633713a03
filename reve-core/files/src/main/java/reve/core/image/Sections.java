// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import java.io.ByteArrayOutputStream;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.zip.CRC32C;

/**
 * The codec of named byte arrays (sections) as one block. Reading detects every flipped or missing
 * bit. A block has these parts:
 *
 * <ul>
 *   <li>magic bytes and the version of the format
 *   <li>for each section its name, length and bytes, then the CRC32C of these three
 *   <li>the CRC32C of the block
 * </ul>
 */
public final class Sections {

    private static final byte[] MARK = "REVE\r\n\032\n".getBytes(StandardCharsets.US_ASCII);
    private static final int VERSION = 1;

    private Sections() {}

    /**
     * Encodes sections.
     *
     * @param sections bytes by name; a name has at most 255 bytes of UTF-8
     */
    public static byte[] write(Map<String, byte[]> sections) {
        var out = new ByteArrayOutputStream();
        out.writeBytes(MARK);
        out.writeBytes(little(Integer.BYTES).putInt(VERSION).array());
        out.writeBytes(little(Integer.BYTES).putInt(sections.size()).array());
        sections.forEach(
                (name, bytes) -> {
                    byte[] title = name.getBytes(StandardCharsets.UTF_8);
                    byte[] head =
                            little(1 + title.length + Integer.BYTES)
                                    .put((byte) title.length)
                                    .put(title)
                                    .putInt(bytes.length)
                                    .array();
                    out.writeBytes(head);
                    out.writeBytes(bytes);
                    out.writeBytes(checksum(head, bytes));
                });
        out.writeBytes(checksum(out.toByteArray()));
        return out.toByteArray();
    }

    /**
     * Decodes a block.
     *
     * @throws CorruptException with the error and its position
     */
    public static Map<String, byte[]> read(byte[] block) {
        if (block.length < MARK.length + 3 * Integer.BYTES
                || !Arrays.equals(MARK, 0, MARK.length, block, 0, MARK.length)) {
            throw new CorruptException(
                    "it begins with no mark of an image: it was cut, damaged, " + "or is none");
        }
        ByteBuffer in = ByteBuffer.wrap(block).order(ByteOrder.LITTLE_ENDIAN);
        in.position(MARK.length);
        int version = in.getInt();
        if (version != VERSION) {
            throw new CorruptException(
                    "its format is version " + version + ", this program reads " + VERSION);
        }
        int end = block.length - Integer.BYTES;
        int count = in.getInt();
        Map<String, byte[]> sections = new LinkedHashMap<>();
        for (int i = 0; i < count; i++) {
            readSection(in, end, sections);
        }
        byte[] all = checksum(Arrays.copyOf(block, end));
        if (in.position() != end || !Arrays.equals(all, 0, 4, block, end, end + 4)) {
            throw new CorruptException("its checksum is wrong");
        }
        return Collections.unmodifiableMap(sections);
    }

    private static void readSection(ByteBuffer in, int end, Map<String, byte[]> into) {
        int start = in.position();
        byte[] title = take(in, end, in.position() < end ? Byte.toUnsignedInt(in.get()) : 0);
        String name = new String(title, StandardCharsets.UTF_8);
        if (end - in.position() < Integer.BYTES) {
            throw new CorruptException("it ends in the middle of section " + into.size());
        }
        byte[] bytes = take(in, end, in.getInt());
        byte[] head = Arrays.copyOfRange(in.array(), start, in.position() - bytes.length);
        byte[] found = take(in, end, Integer.BYTES);
        if (!Arrays.equals(found, checksum(head, bytes))) {
            throw new CorruptException("the checksum of section " + into.size() + " is wrong");
        }
        into.put(name, bytes);
    }

    private static byte[] take(ByteBuffer in, int end, int length) {
        if (length < 0 || length > end - in.position()) {
            throw new CorruptException("it ends too early");
        }
        byte[] bytes = new byte[length];
        in.get(bytes);
        return bytes;
    }

    private static byte[] checksum(byte[]... blocks) {
        var crc = new CRC32C();
        for (byte[] block : blocks) {
            crc.update(block);
        }
        return little(Integer.BYTES).putInt((int) crc.getValue()).array();
    }

    private static ByteBuffer little(int bytes) {
        return ByteBuffer.allocate(bytes).order(ByteOrder.LITTLE_ENDIAN);
    }
}
