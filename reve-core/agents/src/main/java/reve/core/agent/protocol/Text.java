// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.text.Visible;

import java.nio.ByteBuffer;
import java.nio.charset.CharacterCodingException;
import java.nio.charset.StandardCharsets;

/**
 * Decoder of text from clients, and its conversion into a form that is safe to show in messages and
 * logs.
 */
public final class Text {

    private static final int SHOWN = 64;

    private static final char REPLACEMENT = '\ufffd';

    private Text() {}

    /**
     * Decodes a text.
     *
     * @throws CharacterCodingException if the bytes are not valid UTF-8
     */
    static String decode(byte[] utf8, int start, int length) throws CharacterCodingException {
        String text = new String(utf8, start, length, StandardCharsets.UTF_8);
        // The decoder inserts the replacement character for invalid UTF-8, but a client may also
        // send this character. The slower code below distinguishes the two cases.
        if (text.indexOf(REPLACEMENT) >= 0) {
            StandardCharsets.UTF_8.newDecoder().decode(ByteBuffer.wrap(utf8, start, length));
        }
        return text;
    }

    /**
     * Returns at most 64 characters of the text in quotes. Control characters and other invisible
     * characters are escaped.
     */
    public static String quote(String text) {
        var out = new StringBuilder(text.length() + 2).append('"');
        text.codePoints()
                .limit(SHOWN)
                .forEach(
                        c -> {
                            if (c == '"' || c == '\\') {
                                out.append('\\');
                            }
                            Visible.append(out, c);
                        });
        return out.append(isLong(text) ? "…\"" : "\"").toString();
    }

    private static boolean isLong(String text) {
        return text.codePointCount(0, text.length()) > SHOWN;
    }
}
