// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.text.Visible;
import reve.core.text.VisibleName;

import java.util.regex.Pattern;

/** The rules for names in worlds. */
final class Names {

    static final int MAX_LENGTH = 128;

    private static final Pattern IDENTIFIER = Pattern.compile("[A-Za-z][A-Za-z0-9_]{0,46}");
    private static final Pattern WORLD_NAME = Pattern.compile("[A-Za-z0-9][A-Za-z0-9 ._-]*");

    private Names() {}

    /** Checks the name of an item or a symbol, which people choose and read. */
    static String require(String what, String name) {
        if (name.isBlank()) {
            throw new IllegalArgumentException(what + " is empty");
        }
        if (name.length() > MAX_LENGTH) {
            throw new IllegalArgumentException(
                    what
                            + " \""
                            + name.substring(0, 32)
                            + "...\" has "
                            + name.length()
                            + " characters, at most "
                            + MAX_LENGTH
                            + " are allowed");
        }
        for (int i = 0; i < name.length(); i++) {
            if (Character.isISOControl(name.charAt(i))) {
                throw new IllegalArgumentException(
                        what + " \"" + escaped(name) + "\" contains a control character");
            }
        }
        if (!isUnicode(name)) {
            throw new IllegalArgumentException(
                    what + " \"" + escaped(name) + "\" is no Unicode: half of a surrogate pair");
        }
        return name;
    }

    /** Checks the name of a new item, which must also meet the rules of {@link VisibleName}. */
    static String requireItemName(String what, String name) {
        require(what, name);
        VisibleName.fault(name)
                .ifPresent(
                        fault -> {
                            throw new IllegalArgumentException(
                                    what + " \"" + Visible.line(name) + "\" " + fault);
                        });
        return name;
    }

    /** Checks the name of a world, which becomes part of file names on any file system. */
    static String requireWorldName(String name) {
        require("world name", name);
        if (!WORLD_NAME.matcher(name).matches()) {
            throw new IllegalArgumentException(
                    "world name \""
                            + name
                            + "\": expected a letter (a to z) or digit, then letters, digits,"
                            + " spaces, ., _ or -: it becomes part of file names");
        }
        return name;
    }

    /** Returns whether a text can be encoded in UTF-8: it has no unpaired surrogate. */
    static boolean isUnicode(String text) {
        for (int i = 0; i < text.length(); i++) {
            if (Character.isSurrogate(text.charAt(i))) {
                if (!Character.isSupplementaryCodePoint(text.codePointAt(i))) {
                    return false;
                }
                i++;
            }
        }
        return true;
    }

    /**
     * Checks the name of a property or kind, which laws look up. The maximum length fits the 48
     * bytes of the C interface.
     */
    static String requireIdentifier(String what, String name) {
        if (!IDENTIFIER.matcher(name).matches()) {
            throw new IllegalArgumentException(
                    what
                            + " \""
                            + escaped(name)
                            + "\": expected a letter, then letters, digits or _, at most 47 in"
                            + " all");
        }
        return name;
    }

    private static String escaped(String name) {
        StringBuilder out = new StringBuilder();
        name.chars()
                .limit(MAX_LENGTH)
                .forEach(
                        c -> {
                            if (Character.isISOControl(c) || Character.isSurrogate((char) c)) {
                                out.append(String.format("\\u%04x", c));
                            } else {
                                out.append((char) c);
                            }
                        });
        return out.toString();
    }
}
