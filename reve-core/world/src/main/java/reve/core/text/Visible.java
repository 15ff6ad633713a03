// SPDX-License-Identifier: Apache-2.0
package reve.core.text;

import java.util.Locale;

/**
 * Escaping of untrusted text for terminals, logs and messages. It escapes three kinds of
 * characters:
 *
 * <ul>
 *   <li>control characters, which could forge lines or send commands to the terminal
 *   <li>bidirectional controls, which change the order of a line
 *   <li>other invisible characters
 * </ul>
 *
 * <p>Letters, marks, digits and signs of all scripts stay unchanged, with the joiners that scripts
 * need.
 */
public final class Visible {

    private static final int JOINER = 0x200d;
    private static final int NON_JOINER = 0x200c;
    private static final int LAST_ASCII = 0x7e;
    private static final int SHOWN = 64;

    private Visible() {}

    /**
     * Returns the text as one line. A backslash and {@code u{HEX}} replace each unsafe character.
     */
    public static String line(String text) {
        return isSafe(text, ' ') ? text : escaped(text);
    }

    /**
     * Returns at most the first 64 characters of the text as one line. Ends a longer text with "…".
     */
    public static String shortened(String text) {
        int length = text.codePointCount(0, text.length());
        return length <= SHOWN
                ? line(text)
                : line(text.substring(0, text.offsetByCodePoints(0, SHOWN))) + "…";
    }

    private static String escaped(String text) {
        var out = new StringBuilder(text.length() + 16);
        text.codePoints().forEach(c -> append(out, c));
        return out.toString();
    }

    /** Appends one character, escaped unless it is safe. */
    public static void append(StringBuilder out, int codePoint) {
        if (isSafe(codePoint)) {
            out.appendCodePoint(codePoint);
        } else {
            out.append("\\u{").append(Integer.toHexString(codePoint)).append('}');
        }
    }

    /**
     * Returns the JSON document with JSON escapes for unsafe characters beyond ASCII. Such
     * characters occur only in strings. Unsafe ASCII characters need no check, because JSON
     * requires their escapes.
     */
    public static String json(String document) {
        if (isSafe(document, '\n')) {
            return document;
        }
        var out = new StringBuilder(document.length() + 16);
        document.codePoints()
                .forEach(
                        c -> {
                            if (c <= LAST_ASCII || isSafe(c)) {
                                out.appendCodePoint(c);
                            } else {
                                for (char unit : Character.toChars(c)) {
                                    out.append(String.format(Locale.ROOT, "\\u%04x", (int) unit));
                                }
                            }
                        });
        return out.toString();
    }

    /**
     * Returns whether all characters of a text are safe.
     *
     * @param least first ASCII character that is safe without a check
     */
    private static boolean isSafe(String text, int least) {
        for (int i = 0; i < text.length(); i++) {
            char c = text.charAt(i);
            if ((c < least || c > LAST_ASCII) && !isSafe(c)) {
                return false; // a surrogate needs the slower check
            }
        }
        return true;
    }

    private static boolean isSafe(int codePoint) {
        return switch (Character.getType(codePoint)) {
            case Character.CONTROL,
                    Character.SURROGATE,
                    Character.PRIVATE_USE,
                    Character.UNASSIGNED,
                    Character.LINE_SEPARATOR,
                    Character.PARAGRAPH_SEPARATOR ->
                    false;
            case Character.SPACE_SEPARATOR -> codePoint == ' ';
            case Character.FORMAT -> codePoint == JOINER || codePoint == NON_JOINER;
            default -> true;
        };
    }
}
