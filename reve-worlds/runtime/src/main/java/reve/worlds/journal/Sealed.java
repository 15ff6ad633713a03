// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.nio.charset.StandardCharsets;
import java.util.HexFormat;
import java.util.zip.CRC32C;

/** Texts in a database that begin with their checksum. */
final class Sealed {
    private static final int HEX_DIGITS = 8;

    private Sealed() {}

    /** Returns the text behind its checksum (CRC-32C of its UTF-8 form) and a colon. */
    static String seal(String text) {
        return HexFormat.of().toHexDigits(sum(text)) + ":" + text;
    }

    /**
     * Returns the text behind a checksum. Returns a text that begins with a bracket unchanged,
     * because earlier versions wrote no checksum.
     *
     * @throws IllegalArgumentException if the checksum is wrong
     */
    static String open(String sealed) {
        if (sealed.startsWith("[")) {
            return sealed;
        }
        String text = sealed.substring(Math.min(sealed.length(), HEX_DIGITS + 1));
        if (!sealed.equals(seal(text))) {
            throw new IllegalArgumentException("the text does not fit its checksum");
        }
        return text;
    }

    private static int sum(String text) {
        var sum = new CRC32C();
        sum.update(text.getBytes(StandardCharsets.UTF_8));
        return (int) sum.getValue();
    }
}
