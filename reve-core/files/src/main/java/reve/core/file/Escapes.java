// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Optional;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * Check of escapes in double-quoted YAML texts. It exists because the YAML parser accepts unpaired
 * surrogates, and throws unsuitable exceptions for some invalid escapes.
 */
final class Escapes {
    private static final Pattern ESCAPE =
            Pattern.compile("\\\\(?:u([0-9A-Fa-f]{4})|U([0-9A-Fa-f]{8})|\\R|.)", Pattern.DOTALL);

    /**
     * An invalid escape.
     *
     * @param offset position in the text [characters]
     * @param message the error, and the text to write instead
     */
    record Wrong(int offset, String message) {}

    private Escapes() {}

    /** Returns whether a text contains an unpaired surrogate. */
    static boolean hasHalf(String text) {
        for (int i = 0; i < text.length(); i++) {
            if (Character.isHighSurrogate(text.charAt(i))
                    && i + 1 < text.length()
                    && Character.isLowSurrogate(text.charAt(i + 1))) {
                i++;
            } else if (Character.isSurrogate(text.charAt(i))) {
                return true;
            }
        }
        return false;
    }

    /** Returns the first invalid escape at or after an offset. */
    static Optional<Wrong> find(String text, int from) {
        Matcher escape = ESCAPE.matcher(text);
        int at = from;
        while (escape.find(at)) {
            at = escape.end();
            long code = code(escape);
            if (code > Character.MAX_CODE_POINT) {
                return Optional.of(
                        new Wrong(
                                escape.start(),
                                "`"
                                        + escape.group()
                                        + "` is no character; the last one is `\\U0010FFFF`"));
            }
            if (!isHalf(code)) {
                continue;
            }
            int begin = escape.start();
            String half = escape.group();
            boolean whole =
                    isHigh(code)
                            && escape.find(at)
                            && escape.start() == at
                            && isHalf(code(escape))
                            && !isHigh(code(escape));
            if (!whole) {
                return Optional.of(
                        new Wrong(
                                begin,
                                "`"
                                        + half
                                        + "` is half a character; write the character itself, or"
                                        + " both halves, as in `\\uD83D\\uDE00`"));
            }
            at = escape.end();
        }
        return Optional.empty();
    }

    /** Returns the code point that an escape represents; -1 if the escape is invalid. */
    private static long code(Matcher escape) {
        String digits = escape.group(1) != null ? escape.group(1) : escape.group(2);
        return digits == null ? -1 : Long.parseLong(digits, 16);
    }

    private static boolean isHalf(long code) {
        return code >= Character.MIN_SURROGATE && code <= Character.MAX_SURROGATE;
    }

    private static boolean isHigh(long code) {
        return code <= Character.MAX_HIGH_SURROGATE;
    }
}
