// SPDX-License-Identifier: Apache-2.0
package reve.core.text;

import java.lang.Character.UnicodeScript;
import java.util.EnumSet;
import java.util.Locale;
import java.util.Optional;
import java.util.Set;

/**
 * The rule for names that people compare by eye. Every character of such a name is visible, and
 * characters are displayed in the order in which they are stored. The rule permits names in any
 * script. Joiners and variation selectors are permitted where a script or an emoji needs them.
 */
public final class VisibleName {
    private static final int NON_JOINER = 0x200C;
    private static final int JOINER = 0x200D;

    /** Scripts in which a zero-width joiner or non-joiner changes the form of letters. */
    private static final Set<UnicodeScript> JOINED =
            EnumSet.of(
                    UnicodeScript.ARABIC,
                    UnicodeScript.SYRIAC,
                    UnicodeScript.MONGOLIAN,
                    UnicodeScript.NKO,
                    UnicodeScript.DEVANAGARI,
                    UnicodeScript.BENGALI,
                    UnicodeScript.GURMUKHI,
                    UnicodeScript.GUJARATI,
                    UnicodeScript.ORIYA,
                    UnicodeScript.TAMIL,
                    UnicodeScript.TELUGU,
                    UnicodeScript.KANNADA,
                    UnicodeScript.MALAYALAM,
                    UnicodeScript.SINHALA,
                    UnicodeScript.KHMER,
                    UnicodeScript.MYANMAR,
                    UnicodeScript.TIBETAN);

    private VisibleName() {}

    /**
     * Returns the reason why a text violates the rule, for a message; empty if it follows the rule.
     */
    public static Optional<String> fault(String text) {
        int last = text.length() - 1;
        if (last >= 0 && (isGap(text.codePointAt(0)) || isGap(text.charAt(last)))) {
            return Optional.of("begins or ends with a blank; remove it");
        }
        for (int i = 0; i < text.length(); i += Character.charCount(text.codePointAt(i))) {
            int character = text.codePointAt(i);
            if (isHidden(character) && !isNeeded(text, i, character)) {
                return Optional.of(
                        "contains " + name(character) + ", " + effect(character) + "; remove it");
            }
        }
        return Optional.empty();
    }

    private static boolean isGap(int character) {
        return Character.isWhitespace(character) || Character.isSpaceChar(character);
    }

    /**
     * Returns whether a character is a control, format or line separator character or has no width,
     * as defined in Unicode Technical Standard 39.
     */
    private static boolean isHidden(int character) {
        if (character < 0x7F) {
            return character < 0x20;
        }
        return switch (Character.getType(character)) {
            case Character.CONTROL,
                    Character.FORMAT,
                    Character.LINE_SEPARATOR,
                    Character.PARAGRAPH_SEPARATOR,
                    Character.SURROGATE ->
                    true;
            default -> isFiller(character) || isVariation(character);
        };
    }

    private static boolean isFiller(int character) {
        return switch (character) {
            case 0x034F, 0x115F, 0x1160, 0x17B4, 0x17B5, 0x2065, 0x2800, 0x3164, 0xFFA0 -> true;
            default ->
                    character >= 0xFFF0 && character <= 0xFFF8
                            || character >= 0xE0000 && character <= 0xE0FFF;
        };
    }

    private static boolean isVariation(int character) {
        return character >= 0xFE00 && character <= 0xFE0F
                || character >= 0x180B && character <= 0x180F && character != 0x180E
                || character >= 0xE0100 && character <= 0xE01EF;
    }

    /**
     * Returns whether the invisible character at an index changes how its neighbours are displayed.
     */
    private static boolean isNeeded(String text, int at, int character) {
        if (at == 0) {
            return false;
        }
        int before = text.codePointBefore(at);
        if (isVariation(character)) {
            return Character.isIdeographic(before)
                    || Character.isEmoji(before)
                    || UnicodeScript.of(before) == UnicodeScript.MONGOLIAN;
        }
        if (character != JOINER && character != NON_JOINER) {
            return false;
        }
        int end = at + Character.charCount(character);
        if (character == JOINER && (isPicture(before) || isVariation(before))) {
            return end < text.length() && isPicture(text.codePointAt(end));
        }
        UnicodeScript script = UnicodeScript.of(before);
        return JOINED.contains(script)
                && (character == JOINER || end < text.length())
                && (end == text.length() || UnicodeScript.of(text.codePointAt(end)) == script);
    }

    private static boolean isPicture(int character) {
        return Character.isExtendedPictographic(character) || Character.isEmojiModifier(character);
    }

    private static String effect(int character) {
        return switch (Character.getType(character)) {
            case Character.LINE_SEPARATOR, Character.PARAGRAPH_SEPARATOR -> "which ends a line";
            case Character.CONTROL -> "a control character";
            case Character.SURROGATE -> "half of a surrogate pair";
            default ->
                    isDirection(character)
                            ? "which changes the direction of text"
                            : "which is not seen";
        };
    }

    private static boolean isDirection(int character) {
        return character == 0x061C
                || character == 0x200E
                || character == 0x200F
                || character >= 0x202A && character <= 0x202E
                || character >= 0x2066 && character <= 0x2069;
    }

    private static String name(int character) {
        String name = Character.getName(character);
        return name == null
                ? code(character)
                : code(character) + " (" + name.toLowerCase(Locale.ROOT) + ")";
    }

    private static String code(int character) {
        return String.format("U+%04X", character);
    }
}
