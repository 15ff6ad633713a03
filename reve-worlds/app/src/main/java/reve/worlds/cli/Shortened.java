// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import reve.core.text.Rounded;

import java.util.Collection;
import java.util.Locale;
import java.util.Map;
import java.util.regex.Pattern;
import java.util.stream.Collectors;

/** Values as they appear in lines for people. JSON documents contain the complete values. */
final class Shortened {
    private static final Pattern SHA256 = Pattern.compile("[0-9a-f]{64}");
    private static final int DIGITS = 12;

    /** Numbers from this size on have three decimals, smaller ones four significant digits. */
    private static final double THREE_DECIMALS_FROM = 1;

    private static final double THREE_DECIMALS_BELOW = 1e7;

    private Shortened() {}

    /**
     * Returns a value as text. Rounds numbers, also those in lists and maps, and shortens SHA-256
     * hashes.
     */
    static String of(@Nullable Object value) {
        return switch (value) {
            case Double number -> number(number);
            case Float number -> number(number);
            case String text -> SHA256.matcher(text).matches() ? hash(text) : text;
            case Map<?, ?> map ->
                    map.entrySet().stream()
                            .map(each -> each.getKey() + "=" + of(each.getValue()))
                            .collect(Collectors.joining(", ", "{", "}"));
            case Collection<?> all ->
                    all.stream().map(Shortened::of).collect(Collectors.joining(", ", "[", "]"));
            case null -> "null";
            default -> value.toString();
        };
    }

    /** Returns the first 12 hexadecimal digits of a hash. */
    static String hash(String hash) {
        return hash.substring(0, Math.min(DIGITS, hash.length())) + "…";
    }

    private static String number(double number) {
        double size = Math.abs(number);
        if (size >= THREE_DECIMALS_FROM && size < THREE_DECIMALS_BELOW) {
            return String.format(Locale.ROOT, "%.3f", number).replaceFirst("\\.?0+$", "");
        }
        return Rounded.of(number);
    }
}
