// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Arrays;
import java.util.Optional;
import java.util.function.Consumer;

/** The encoding of messages. Messages have the same fields in all encodings. */
public enum Encoding {
    /** One JSON object per line. */
    JSON("json") {
        @Override
        MessageWriter writer(Bytes out) {
            return new JsonWriter(out);
        }

        @Override
        public MessageWriter fields(Bytes out) {
            return JsonWriter.behindField(out);
        }

        @Override
        public MessageWriter begin(Bytes out, String type, long id, int fields) {
            out.put("{\"t\":\"").put(type).put('"');
            if (id != ClientMessage.NO_ID) {
                out.put(",\"id\":").put(id);
            }
            return fields(out);
        }

        @Override
        public void end(Bytes out, int start) {
            out.put("}\n");
        }
    },
    /** One MessagePack map per message, after its length as a big-endian number of 4 bytes. */
    MESSAGEPACK("msgpack") {
        @Override
        MessageWriter writer(Bytes out) {
            return new MessagePackWriter(out);
        }

        @Override
        public MessageWriter fields(Bytes out) {
            return writer(out);
        }

        @Override
        public MessageWriter begin(Bytes out, String type, long id, int fields) {
            boolean answers = id != ClientMessage.NO_ID;
            MessageWriter writer = writer(out.putInt(0));
            writer.beginMap(fields + (answers ? 2 : 1));
            writer.key("t");
            writer.text(type);
            if (answers) {
                writer.key("id");
                writer.integer(id);
            }
            return writer;
        }

        @Override
        public void end(Bytes out, int start) {
            out.setInt(start, out.size() - start - LENGTH_BYTES);
        }
    };

    /** Size of the length prefix of a MessagePack message [bytes]. */
    public static final int LENGTH_BYTES = 4;

    private final String wireName;

    Encoding(String wireName) {
        this.wireName = wireName;
    }

    /** Returns the name of the encoding in the protocol. */
    public String wireName() {
        return wireName;
    }

    /** Finds an encoding by its name in the protocol. */
    public static Optional<Encoding> of(String wireName) {
        return Arrays.stream(values())
                .filter(encoding -> encoding.wireName.equals(wireName))
                .findFirst();
    }

    /** Encodes one value. */
    public byte[] value(Consumer<MessageWriter> content) {
        var out = new Bytes();
        content.accept(writer(out));
        return out.toArray();
    }

    abstract MessageWriter writer(Bytes out);

    /** Returns a writer of fields that are appended to other fields of a message. */
    public abstract MessageWriter fields(Bytes out);

    /**
     * Begins a message.
     *
     * @param fields number of fields, each a key and a value, before {@link #end}
     */
    public abstract MessageWriter begin(Bytes out, String type, long id, int fields);

    /** Ends the message that begins at position {@code start}. */
    public abstract void end(Bytes out, int start);
}
