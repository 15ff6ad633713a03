// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import org.msgpack.core.MessageFormat;
import org.msgpack.core.MessageInsufficientBufferException;
import org.msgpack.core.MessagePack;
import org.msgpack.core.MessagePackException;
import org.msgpack.core.MessageSizeException;
import org.msgpack.core.MessageUnpacker;
import org.msgpack.value.ValueType;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.JsonNodeFactory;
import tools.jackson.databind.node.ObjectNode;

import java.io.IOException;
import java.math.BigInteger;
import java.nio.ByteBuffer;

/**
 * Decoder of MessagePack into JSON trees, with the limits of {@link Json}. Refuses values that JSON
 * cannot represent.
 */
public final class MessagePackReader {

    private static final JsonNodeFactory NODES = JsonNodeFactory.instance;
    private static final MessagePack.UnpackerConfig CONFIG = new MessagePack.UnpackerConfig();

    private final MessageUnpacker unpacker;
    private final int bytes;
    private final Binary binary;

    /** A conversion of binary values, which JSON does not have, into texts. */
    public interface Binary {
        /**
         * Returns the text for a binary value.
         *
         * @throws IllegalArgumentException if binary values are not allowed
         */
        String text(byte[] bytes);
    }

    private MessagePackReader(ByteBuffer message, Binary binary) {
        this.binary = binary;
        this.unpacker = CONFIG.newUnpacker(message);
        this.bytes = message.remaining();
    }

    /**
     * Reads a message that is exactly one value.
     *
     * @throws IllegalArgumentException with the reason if the bytes are not exactly one value
     */
    public static JsonNode read(ByteBuffer message) {
        return read(
                message,
                bytes -> {
                    throw new IllegalArgumentException(
                            "a value of type BINARY, expected what JSON has too");
                });
    }

    /** Reads like {@link #read(ByteBuffer)}, and converts binary values into texts. */
    public static JsonNode read(ByteBuffer message, Binary binary) {
        var reader = new MessagePackReader(message, binary);
        try {
            JsonNode node = reader.value(Json.MAX_DEPTH);
            if (reader.unpacker.getTotalReadBytes() != reader.bytes) {
                throw new IllegalArgumentException("bytes follow the message");
            }
            return node;
        } catch (IOException | MessagePackException e) {
            throw new IllegalArgumentException(reason(e), e);
        }
    }

    private static String reason(Exception e) {
        return switch (e) {
            case MessageInsufficientBufferException ends -> "the message ends within a value";
            case MessageSizeException large ->
                    "a length is " + large.getSize() + ", which is too large";
            case Exception other when other.getMessage() != null -> other.getMessage();
            default -> "a value cannot be read";
        };
    }

    private JsonNode value(int depth) throws IOException {
        MessageFormat format = unpacker.getNextFormat();
        ValueType type = format.getValueType();
        return switch (type) {
            case NIL -> {
                unpacker.unpackNil();
                yield NODES.nullNode();
            }
            case BOOLEAN -> NODES.booleanNode(unpacker.unpackBoolean());
            case INTEGER ->
                    format == MessageFormat.UINT64
                            ? integer(unpacker.unpackBigInteger())
                            : NODES.numberNode(unpacker.unpackLong());
            case FLOAT -> NODES.numberNode(finite(unpacker.unpackDouble()));
            case STRING -> NODES.stringNode(text());
            case ARRAY -> list(depth);
            case MAP -> map(depth);
            case BINARY -> NODES.stringNode(binary.text(payload(unpacker.unpackBinaryHeader())));
            case EXTENSION ->
                    throw new IllegalArgumentException(
                            "a value of type " + type + ", expected what JSON has too");
        };
    }

    private String text() throws IOException {
        byte[] utf8 = payload(unpacker.unpackRawStringHeader());
        return Text.decode(utf8, 0, utf8.length);
    }

    private byte[] payload(int claimed) throws IOException {
        if (claimed < 0 || claimed > bytes - unpacker.getTotalReadBytes()) {
            throw new IllegalArgumentException(claimed + " bytes do not fit into " + bytes);
        }
        return unpacker.readPayload(claimed);
    }

    private static double finite(double number) {
        if (!Double.isFinite(number)) {
            throw new IllegalArgumentException("a number is " + number);
        }
        return number;
    }

    private static JsonNode integer(BigInteger number) {
        return number.bitLength() < Long.SIZE
                ? NODES.numberNode(number.longValue())
                : NODES.numberNode(number.doubleValue());
    }

    private JsonNode list(int depth) throws IOException {
        int length = length(unpacker.unpackArrayHeader(), depth);
        ArrayNode list = NODES.arrayNode();
        for (int i = 0; i < length; i++) {
            list.add(value(depth - 1));
        }
        return list;
    }

    private JsonNode map(int depth) throws IOException {
        int length = length(unpacker.unpackMapHeader(), depth);
        ObjectNode map = NODES.objectNode();
        for (int i = 0; i < length; i++) {
            String key = text();
            if (map.has(key)) {
                throw new IllegalArgumentException(
                        "the key " + Text.quote(key) + " is there twice");
            }
            map.set(key, value(depth - 1));
        }
        return map;
    }

    /**
     * Checks a length before memory is allocated. A length that exceeds the remaining bytes is
     * refused, because each element needs at least one byte.
     */
    private int length(int claimed, int depth) {
        if (depth == 0) {
            throw new IllegalArgumentException("it is nested deeper than " + Json.MAX_DEPTH);
        }
        if (claimed < 0 || claimed > bytes - unpacker.getTotalReadBytes()) {
            throw new IllegalArgumentException(
                    "a list or map of "
                            + claimed
                            + " elements does not fit into "
                            + bytes
                            + " bytes");
        }
        return claimed;
    }
}
