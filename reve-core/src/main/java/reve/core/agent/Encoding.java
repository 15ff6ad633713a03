package reve.core.agent;

import java.nio.ByteBuffer;
import java.util.Arrays;
import java.util.Optional;
import java.util.function.Consumer;

/** How messages are written: the same fields in either. */
enum Encoding {
    /** One JSON object per line. */
    JSON("json") {
        @Override
        MessageWriter writer(Bytes out) {
            return new JsonWriter(out);
        }

        @Override
        byte[] frame(byte[] message) {
            byte[] line = Arrays.copyOf(message, message.length + 1);
            line[message.length] = '\n';
            return line;
        }

        @Override
        byte[] head(Bytes scratch, String type, long id, int count, int bytes) {
            scratch.clear().put("{\"t\":\"").put(type).put('"');
            if (id != ClientMessage.NO_ID) {
                scratch.put(",\"id\":").put(Long.toString(id));
            }
            return scratch.put(',').toArray();
        }

        @Override
        byte[] fields(Bytes out) {
            return out.put("}\n").toArray();
        }
    },
    /** A MessagePack map behind its length in 4 bytes, the highest first. */
    MESSAGEPACK("msgpack") {
        @Override
        MessageWriter writer(Bytes out) {
            return new MessagePackWriter(out);
        }

        @Override
        byte[] frame(byte[] message) {
            return ByteBuffer.allocate(LENGTH_BYTES + message.length).putInt(message.length).put(message).array();
        }

        @Override
        byte[] head(Bytes scratch, String type, long id, int count, int bytes) {
            boolean answers = id != ClientMessage.NO_ID;
            MessageWriter writer = writer(scratch.clear().putInt(0));
            writer.beginMap(count + (answers ? 2 : 1));
            writer.key("t");
            writer.text(type);
            if (answers) {
                writer.key("id");
                writer.integer(id);
            }
            byte[] head = scratch.toArray();
            ByteBuffer.wrap(head).putInt(head.length - LENGTH_BYTES + bytes);
            return head;
        }

        @Override
        byte[] fields(Bytes out) {
            return out.toArray();
        }
    };

    static final int LENGTH_BYTES = 4;

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
    byte[] value(Consumer<MessageWriter> content) {
        var out = new Bytes();
        content.accept(writer(out));
        return out.toArray();
    }

    /** The last fields of a message that begins with a {@link #head}, up to its end. @param scratch to write in */
    byte[] fields(Bytes scratch, Consumer<MessageWriter> content) {
        content.accept(writer(scratch.clear()));
        return fields(scratch);
    }

    abstract MessageWriter writer(Bytes out);

    /** A whole message as it goes over the wire. */
    abstract byte[] frame(byte[] message);

    /** The beginning of a message, before {@code count} fields in {@code bytes} bytes. @param scratch to write in */
    abstract byte[] head(Bytes scratch, String type, long id, int count, int bytes);

    abstract byte[] fields(Bytes out);
}
