package reve.core.agent;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.Optional;
import java.util.function.Consumer;
import org.msgpack.core.MessageBufferPacker;
import org.msgpack.core.MessagePack;
import tools.jackson.core.JsonGenerator;

/** How messages are written: the same fields in either. */
enum Encoding {
    /** One JSON object per line. */
    JSON("json") {
        @Override
        byte[] value(Consumer<MessageWriter> content) {
            var bytes = new ByteArrayOutputStream(256);
            try (JsonGenerator json = Json.MAPPER.createGenerator(bytes)) {
                content.accept(new JsonWriter(json));
            }
            return bytes.toByteArray();
        }

        @Override
        byte[] frame(byte[] message) {
            byte[] line = Arrays.copyOf(message, message.length + 1);
            line[message.length] = '\n';
            return line;
        }

        @Override
        byte[] fields(int count, Consumer<MessageWriter> content) {
            byte[] object = value(writer -> {
                writer.beginMap(count);
                content.accept(writer);
                writer.endMap();
            });
            return frame(Arrays.copyOfRange(object, 1, object.length));
        }

        @Override
        byte[] head(String type, long id, int count, int bytes) {
            String head = "{\"t\":\"" + type + "\"" + (id == ClientMessage.NO_ID ? "" : ",\"id\":" + id) + ",";
            return head.getBytes(StandardCharsets.US_ASCII);
        }
    },
    /** A MessagePack map behind its length in 4 bytes, the highest first. */
    MESSAGEPACK("msgpack") {
        @Override
        byte[] value(Consumer<MessageWriter> content) {
            try (MessageBufferPacker packer = PACKER.newBufferPacker()) {
                content.accept(new MessagePackWriter(packer));
                return packer.toByteArray();
            } catch (IOException e) {
                throw new UncheckedIOException(e); // it writes to memory
            }
        }

        @Override
        byte[] frame(byte[] message) {
            return ByteBuffer.allocate(LENGTH_BYTES + message.length).putInt(message.length).put(message).array();
        }

        @Override
        byte[] fields(int count, Consumer<MessageWriter> content) {
            return value(content);
        }

        @Override
        byte[] head(String type, long id, int count, int bytes) {
            boolean answers = id != ClientMessage.NO_ID;
            byte[] head = value(writer -> {
                writer.beginMap(count + (answers ? 2 : 1));
                writer.key("t");
                writer.text(type);
                if (answers) {
                    writer.key("id");
                    writer.integer(id);
                }
            });
            return ByteBuffer.allocate(LENGTH_BYTES + head.length).putInt(head.length + bytes).put(head).array();
        }
    };

    static final int LENGTH_BYTES = 4;

    /** Its buffers are as small as most messages, as they are made anew for each. */
    private static final MessagePack.PackerConfig PACKER = new MessagePack.PackerConfig().withBufferSize(512);

    private final String wireName;

    Encoding(String wireName) {
        this.wireName = wireName;
    }

    /** As the protocol writes it. */
    String wireName() {
        return wireName;
    }

    static Optional<Encoding> of(String wireName) {
        return Arrays.stream(values()).filter(encoding -> encoding.wireName.equals(wireName)).findFirst();
    }

    /** One value. */
    abstract byte[] value(Consumer<MessageWriter> content);

    /** A whole message as it goes over the wire. */
    abstract byte[] frame(byte[] message);

    /** The last fields of a message that begins with a {@link #head}, up to its end. */
    abstract byte[] fields(int count, Consumer<MessageWriter> content);

    /** The beginning of a message, before {@code count} fields in {@code bytes} bytes. */
    abstract byte[] head(String type, long id, int count, int bytes);
}
