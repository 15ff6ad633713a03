// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import com.google.re2j.Pattern;
import com.google.re2j.PatternSyntaxException;

import dev.cel.common.ast.CelConstant;
import dev.cel.common.ast.CelExpr;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.regex.Matcher;

/**
 * Check of the regular expressions in calls of {@code matches}. They must be constants of limited
 * size.
 */
final class Patterns {
    static final String FUNCTION = "matches";

    /**
     * Maximum number of steps (compiled instructions) of a pattern. A pattern has about one step
     * per character, where repetitions count as if they were written out.
     */
    static final int MAX_SIZE = 1000;

    private static final java.util.regex.Pattern REPETITION =
            java.util.regex.Pattern.compile("\\{([0-9]{1,9})(,([0-9]{0,9}))?\\}");
    private static final java.util.regex.Pattern FOLDING =
            java.util.regex.Pattern.compile("\\(\\?[a-zA-Z]*i");
    private static final java.util.regex.Pattern BEYOND_ASCII =
            java.util.regex.Pattern.compile("[^\\x00-\\x7F]|\\\\[xpP0-9]");
    private static final java.util.regex.Pattern FLAGS =
            java.util.regex.Pattern.compile("\\(\\?[a-zA-Z-]*\\)");

    /** Escape of a set of characters in a class. */
    private static final java.util.regex.Pattern SET =
            java.util.regex.Pattern.compile("\\\\(?:[dDsSwW]|[pP](?:\\{[^}]*\\}|[^{]))");

    /** Escape of a character by its number. */
    private static final java.util.regex.Pattern CODE =
            java.util.regex.Pattern.compile(
                    "\\\\(?:x(?:\\{[0-9a-fA-F]*\\}|[0-9a-fA-F]{2})|0[0-7]{0,2}|[1-7][0-7]{1,2})");

    private Patterns() {}

    /**
     * Returns the number of steps of a call's pattern.
     *
     * @param pattern the last argument of the call
     * @throws IllegalArgumentException with the reason if the pattern is invalid
     */
    static int size(CelExpr pattern) {
        if (pattern.getKind() != CelExpr.ExprKind.Kind.CONSTANT
                || pattern.constant().getKind() != CelConstant.Kind.STRING_VALUE) {
            throw new IllegalArgumentException(
                    "the pattern of `matches` is computed, expected a constant text in quotes, such"
                            + " as '^a+$': compare computed texts with `==`, `startsWith`, `endsWith`"
                            + " or `contains`");
        }
        String text = pattern.constant().stringValue();
        if (foldsBeyondAscii(text)) {
            throw new IllegalArgumentException(
                    "the pattern ignores the case of characters beyond ASCII, expected only ASCII"
                            + " with `(?i)`: write both cases, as in `[Ää]`");
        }
        long size = estimate(text);
        if (size <= MAX_SIZE) {
            try {
                size = Pattern.compile(text).programSize();
            } catch (PatternSyntaxException broken) {
                throw new IllegalArgumentException(
                        "the pattern is broken: "
                                + broken.getDescription()
                                + " `"
                                + broken.getPattern()
                                + "`, expected RE2 syntax",
                        broken);
            }
        }
        if (size > MAX_SIZE) {
            throw new IllegalArgumentException(
                    "the pattern has "
                            + (size == Long.MAX_VALUE ? "far too many" : size)
                            + " steps with its repetitions written out, expected "
                            + MAX_SIZE
                            + " at most: repeat less often, or with `*` and `+`");
        }
        return (int) size;
    }

    /**
     * Returns whether the pattern ignores case and contains characters beyond ASCII. For some of
     * these characters, the library for regular expressions does not terminate.
     */
    static boolean foldsBeyondAscii(String pattern) {
        return FOLDING.matcher(pattern).find() && BEYOND_ASCII.matcher(pattern).find();
    }

    /** Returns a lower bound of the number of steps of a pattern. Does not compile the pattern. */
    static long estimate(String pattern) {
        Deque<Long> outside = new ArrayDeque<>();
        Matcher repetition = REPETITION.matcher(pattern);
        long sum = 3;
        long last = 0;
        int end;
        for (int at = 0; at < pattern.length(); at = end) {
            char c = pattern.charAt(at);
            end = end(pattern, at);
            if (c == '(' && end > at + 1) {
                // The parentheses contain flags and no group.
                sum = add(sum, 1);
            } else if (c == '(') {
                outside.push(sum);
                sum = 3;
            } else if (c == ')' && !outside.isEmpty()) {
                last = sum;
                sum = add(outside.pop(), last);
            } else if (c == '{' && repetition.region(at, pattern.length()).lookingAt()) {
                end = repetition.end();
                boolean exact = repetition.group(2) == null;
                last = add(multiply(exact ? last : add(last, 1), times(repetition)), 1);
                sum = add(sum, last);
            } else if (c == '*' || c == '+' || c == '?' || c == '|') {
                last = add(last, 2);
                sum = add(sum, 2);
            } else if (!pattern.startsWith("\\Q\\E", at)) {
                // The quotation is empty. A repetition after it repeats the element before the
                // quotation.
                last = 1;
                sum = add(sum, pattern.startsWith("\\Q", at) ? end - at : 1);
            }
        }
        while (!outside.isEmpty()) {
            sum = add(sum, outside.pop());
        }
        return sum;
    }

    private static long times(Matcher repetition) {
        String most = repetition.group(3);
        return Math.max(
                1,
                Math.max(
                        Long.parseLong(repetition.group(1)),
                        most == null || most.isEmpty() ? 0 : Long.parseLong(most)));
    }

    /**
     * Returns the end of the element that begins at {@code at}. An element is an escape, a class,
     * flags or a character.
     */
    private static int end(String pattern, int at) {
        return switch (pattern.charAt(at)) {
            case '\\' -> escape(pattern, at);
            case '[' -> characterClass(pattern, at);
            case '(' -> flags(pattern, at);
            default -> at + 1;
        };
    }

    /**
     * Returns the end of an escape such as {@code \\d}, {@code \\p{Greek}}, {@code \\x{1F}} or
     * {@code \\Q…\\E}.
     */
    private static int escape(String pattern, int at) {
        char kind = at + 1 < pattern.length() ? pattern.charAt(at + 1) : 0;
        String until =
                kind == 'Q'
                        ? "\\E"
                        : "pPx".indexOf(kind) >= 0 && pattern.startsWith("{", at + 2) ? "}" : "";
        if (until.isEmpty()) {
            return Math.min(pattern.length(), at + 2);
        }
        int end = pattern.indexOf(until, at + 2);
        return end < 0 ? pattern.length() : end + until.length();
    }

    /** Returns the end of a character class such as {@code [a-z]}. */
    private static int characterClass(String pattern, int at) {
        int i = at + 1;
        if (pattern.startsWith("^", i)) {
            i++;
        }
        int first = i;
        while (i < pattern.length() && (pattern.charAt(i) != ']' || i == first)) {
            int named = pattern.startsWith("[:", i) ? pattern.indexOf(":]", i + 2) : -1;
            Matcher set = SET.matcher(pattern).region(i, pattern.length());
            if (named >= 0) {
                i = named + 2;
            } else if (set.lookingAt()) {
                // A set of characters, such as \d, begins no range.
                i = set.end();
            } else {
                i = classCharacter(pattern, i);
                boolean range =
                        pattern.startsWith("-", i)
                                && i + 1 < pattern.length()
                                && pattern.charAt(i + 1) != ']';
                i = range ? classCharacter(pattern, i + 1) : i;
            }
        }
        return Math.min(pattern.length(), i + 1);
    }

    /** Returns the end of the character, which may be an escape, that begins at {@code at}. */
    private static int classCharacter(String pattern, int at) {
        Matcher code = CODE.matcher(pattern).region(at, pattern.length());
        if (code.lookingAt()) {
            return code.end();
        }
        int escaped = pattern.charAt(at) == '\\' && at + 1 < pattern.length() ? at + 1 : at;
        return escaped + Character.charCount(pattern.codePointAt(escaped));
    }

    /**
     * Returns the index after flags such as {@code (?i)}. The text may begin a group instead, such
     * as {@code (?i:} or {@code (}. The method then returns the index after the opening characters
     * of the group.
     */
    private static int flags(String pattern, int at) {
        Matcher flags = FLAGS.matcher(pattern).region(at, pattern.length());
        return flags.lookingAt() ? flags.end() : at + 1;
    }

    private static long add(long a, long b) {
        return a > Long.MAX_VALUE - b ? Long.MAX_VALUE : a + b;
    }

    private static long multiply(long a, long b) {
        return a > Long.MAX_VALUE / b ? Long.MAX_VALUE : a * b;
    }
}
