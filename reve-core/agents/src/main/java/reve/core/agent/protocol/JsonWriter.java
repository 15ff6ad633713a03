// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Base64;

/** Writer of JSON (RFC 8259) without spaces. */
final class JsonWriter implements MessageWriter {

    private static final String HEX = "0123456789abcdef";

    private final Bytes out;

    /** True after a value, so that a comma must precede the next value. */
    private boolean behindValue;

    JsonWriter(Bytes out) {
        this.out = out;
    }

    /** Returns a writer that appends fields to an object whose last field is complete. */
    static JsonWriter behindField(Bytes out) {
        var writer = new JsonWriter(out);
        writer.behindValue = true;
        return writer;
    }

    @Override
    public void beginMap(int fields) {
        begin('{');
    }

    @Override
    public void endMap() {
        end('}');
    }

    @Override
    public void beginList(int values) {
        begin('[');
    }

    @Override
    public void endList() {
        end(']');
    }

    @Override
    public void key(String name) {
        text(name);
        out.put(':');
        behindValue = false;
    }

    @Override
    public void text(String text) {
        beginValue();
        out.put('"');
        int written = 0;
        for (int i = 0; i < text.length(); i++) {
            char c = text.charAt(i);
            if (c < ' ' || c == '"' || c == '\\') {
                out.put(text.substring(written, i));
                escape(c);
                written = i + 1;
            }
        }
        out.put(written == 0 ? text : text.substring(written)).put('"');
    }

    @Override
    public void truth(boolean truth) {
        beginValue();
        out.put(truth ? "true" : "false");
    }

    @Override
    public void integer(long number) {
        beginValue();
        out.put(Long.toString(number));
    }

    @Override
    public void number(double number) {
        beginValue();
        out.put(Double.toString(number));
    }

    @Override
    public void bytes(byte[] bytes) {
        beginValue();
        out.put('"').put(Base64.getEncoder().encode(bytes)).put('"');
    }

    @Override
    public void fragment(Fragment fragment) {
        beginValue();
        behindValue = false;
        fragment.write(this, out);
        behindValue = true;
    }

    @Override
    public Encoding encoding() {
        return Encoding.JSON;
    }

    private void escape(char c) {
        if (c < ' ') {
            out.put("\\u00").put(HEX.charAt(c >> 4)).put(HEX.charAt(c & 0xf));
        } else {
            out.put('\\').put(c);
        }
    }

    private void begin(char bracket) {
        beginValue();
        out.put(bracket);
        behindValue = false;
    }

    private void end(char bracket) {
        out.put(bracket);
        behindValue = true;
    }

    private void beginValue() {
        if (behindValue) {
            out.put(',');
        }
        behindValue = true;
    }
}
