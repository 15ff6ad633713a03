// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.nio.charset.StandardCharsets;

/**
 * Writer of MessagePack (github.com/msgpack/msgpack, spec.md). Each value has the shortest form of
 * its type.
 */
record MessagePackWriter(Bytes out) implements MessageWriter {

    @Override
    public void beginMap(int fields) {
        begin(fields, 0x80, 0xde);
    }

    @Override
    public void endMap() {
        // No end mark is written, because the header contains the number of fields.
    }

    @Override
    public void beginList(int values) {
        begin(values, 0x90, 0xdc);
    }

    @Override
    public void endList() {
        // No end mark is written, because the header contains the number of values.
    }

    @Override
    public void key(String name) {
        text(name);
    }

    @Override
    public void text(String text) {
        int length = utf8Length(text);
        if (length < 32) {
            out.put(0xa0 | length);
        } else if (length < 1 << 8) {
            out.put(0xd9).put(length);
        } else if (length < 1 << 16) {
            out.put(0xda).putShort(length);
        } else {
            out.put(0xdb).putInt(length);
        }
        out.put(text);
    }

    @Override
    public void truth(boolean truth) {
        out.put(truth ? 0xc3 : 0xc2);
    }

    @Override
    public void integer(long number) {
        if (number >= -32 && number < 128) {
            out.put((int) number);
        } else if (number >= 0 && number < 1L << 8) {
            out.put(0xcc).put((int) number);
        } else if (number >= 0 && number < 1L << 16) {
            out.put(0xcd).putShort((int) number);
        } else if (number >= 0 && number < 1L << 32) {
            out.put(0xce).putInt((int) number);
        } else if (number == (int) number) {
            out.put(0xd2).putInt((int) number);
        } else {
            out.put(0xd3).putLong(number);
        }
    }

    @Override
    public void number(double number) {
        out.put(0xcb).putDouble(number);
    }

    @Override
    public void bytes(byte[] bytes) {
        if (bytes.length < 1 << 8) {
            out.put(0xc4).put(bytes.length);
        } else if (bytes.length < 1 << 16) {
            out.put(0xc5).putShort(bytes.length);
        } else {
            out.put(0xc6).putInt(bytes.length);
        }
        out.put(bytes);
    }

    @Override
    public void fragment(Fragment fragment) {
        fragment.write(this, out);
    }

    @Override
    public Encoding encoding() {
        return Encoding.MESSAGEPACK;
    }

    /**
     * Writes a header. A number of up to 15 elements is part of the type byte; a larger one takes 2
     * or 4 further bytes.
     */
    private void begin(int elements, int fix, int of16) {
        if (elements < 16) {
            out.put(fix | elements);
        } else if (elements < 1 << 16) {
            out.put(of16).putShort(elements);
        } else {
            out.put(of16 + 1).putInt(elements);
        }
    }

    private static int utf8Length(String text) {
        for (int i = 0; i < text.length(); i++) {
            if (text.charAt(i) >= 0x80) {
                return text.getBytes(StandardCharsets.UTF_8).length;
            }
        }
        return text.length();
    }
}
