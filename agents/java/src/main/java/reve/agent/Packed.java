// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import org.msgpack.core.MessageBufferPacker;
import org.msgpack.core.MessagePack;
import org.msgpack.core.MessagePacker;
import org.msgpack.core.MessageUnpacker;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.JsonNodeFactory;
import tools.jackson.databind.node.ObjectNode;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.util.Map;

/**
 * Converts messages between trees of JSON nodes and MessagePack. A message in MessagePack begins
 * with its length, which takes 4 bytes.
 */
final class Packed {

    static final int LENGTH_BYTES = 4;

    private static final JsonNodeFactory NODES = JsonNodeFactory.instance;

    private Packed() {}

    static byte[] write(JsonNode message) {
        try (MessageBufferPacker packer = MessagePack.newDefaultBufferPacker()) {
            write(packer, message);
            byte[] bytes = packer.toByteArray();
            return ByteBuffer.allocate(LENGTH_BYTES + bytes.length)
                    .putInt(bytes.length)
                    .put(bytes)
                    .array();
        } catch (IOException e) {
            throw new UncheckedIOException(e); // cannot happen: it writes to memory
        }
    }

    private static void write(MessagePacker packer, JsonNode node) throws IOException {
        if (node.isObject()) {
            packer.packMapHeader(node.size());
            for (Map.Entry<String, JsonNode> field : node.properties()) {
                packer.packString(field.getKey());
                write(packer, field.getValue());
            }
        } else if (node.isArray()) {
            packer.packArrayHeader(node.size());
            for (JsonNode element : node.values()) {
                write(packer, element);
            }
        } else if (node.isString()) {
            packer.packString(node.stringValue());
        } else if (node.isBoolean()) {
            packer.packBoolean(node.booleanValue());
        } else if (node.isIntegralNumber()) {
            packer.packLong(node.longValue());
        } else {
            packer.packDouble(node.doubleValue());
        }
    }

    /**
     * Reads one message.
     *
     * @param message the bytes behind the length prefix
     * @throws IOException or a RuntimeException of msgpack-core if the bytes are not a valid
     *     message
     */
    static JsonNode read(byte[] message) throws IOException {
        try (MessageUnpacker unpacker = MessagePack.newDefaultUnpacker(message)) {
            return read(unpacker);
        }
    }

    private static JsonNode read(MessageUnpacker unpacker) throws IOException {
        return switch (unpacker.getNextFormat().getValueType()) {
            case NIL -> {
                unpacker.unpackNil();
                yield NODES.nullNode();
            }
            case BOOLEAN -> NODES.booleanNode(unpacker.unpackBoolean());
            case INTEGER -> NODES.numberNode(unpacker.unpackLong());
            case FLOAT -> NODES.numberNode(unpacker.unpackDouble());
            case STRING -> NODES.stringNode(unpacker.unpackString());
            case ARRAY -> list(unpacker);
            case MAP -> map(unpacker);
            case BINARY -> NODES.binaryNode(unpacker.readPayload(unpacker.unpackBinaryHeader()));
            case EXTENSION ->
                    throw new IOException("the server sent a value that JSON has no form of");
        };
    }

    private static JsonNode list(MessageUnpacker unpacker) throws IOException {
        int length = unpacker.unpackArrayHeader();
        ArrayNode list = NODES.arrayNode();
        for (int i = 0; i < length; i++) {
            list.add(read(unpacker));
        }
        return list;
    }

    private static JsonNode map(MessageUnpacker unpacker) throws IOException {
        int length = unpacker.unpackMapHeader();
        ObjectNode map = NODES.objectNode();
        for (int i = 0; i < length; i++) {
            map.set(unpacker.unpackString(), read(unpacker));
        }
        return map;
    }
}
