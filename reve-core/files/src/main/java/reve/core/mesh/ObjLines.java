// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import java.nio.charset.StandardCharsets;
import java.util.Locale;

/**
 * Tokenizer of OBJ and MTL files, and of texts of numbers. A backslash at the end of a line
 * continues the line on the next one. A line that begins with {@code #} is a comment. The tokenizer
 * reads the bytes once and does not copy them.
 */
final class ObjLines {

    private static final int MAX_NUMBER_LENGTH = 64;
    private static final int SHOWN = 40;

    private final byte[] bytes;
    private final Sources sources;
    private final String format;
    private int at;

    /** Number of the line that contains {@link #at}, from 1. */
    private int line = 1;

    /** Start of the last word read. The next field is the end of this word. */
    private int from;

    private int to;

    /**
     * @param format start of messages about malformed lines, such as "not OBJ"
     */
    ObjLines(byte[] bytes, Sources sources, String format) {
        this.bytes = bytes;
        this.sources = sources;
        this.format = format;
    }

    /**
     * Advances to the next line that contains a word, and reads this word. Returns false at the end
     * of the file.
     */
    boolean next() {
        while (at < bytes.length) {
            if (word()) {
                if (bytes[from] != '#') {
                    return true;
                }
                skipLine();
            }
            if (at < bytes.length) {
                at++; // skips the line feed
                line++;
            }
        }
        return false;
    }

    /**
     * Returns whether the last word equals {@code keyword}, which is in lower case. Ignores the
     * case of the word.
     */
    boolean is(String keyword) {
        if (to - from != keyword.length()) {
            return false;
        }
        for (int i = 0; i < keyword.length(); i++) {
            if (Character.toLowerCase(bytes[from + i]) != keyword.charAt(i)) {
                return false;
            }
        }
        return true;
    }

    /** Reads the next word of the line. Returns false if there is none. */
    boolean word() {
        while (at < bytes.length && bytes[at] != '\n' && isGap(at)) {
            skipGap();
        }
        from = at;
        while (at < bytes.length && bytes[at] != '\n' && !isGap(at)) {
            at++;
        }
        to = at;
        return to > from;
    }

    /** Skips the rest of the line. */
    void skipLine() {
        while (at < bytes.length && bytes[at] != '\n') {
            skipGap();
        }
    }

    /** Moves back to the start of the last word, so that it is read again. */
    void back() {
        at = from;
    }

    /** Returns the trimmed text from the last word to the end of the line. */
    String fromWord() {
        back();
        return rest();
    }

    /** Returns the trimmed rest of the line. */
    String rest() {
        int begin = at;
        skipLine();
        String rest = new String(bytes, begin, at - begin, StandardCharsets.UTF_8);
        return (rest.indexOf('\n') < 0 ? rest : rest.replaceAll("\\\\\r?\n", " ")).strip();
    }

    /** Reads the next word as a number. */
    float number(String keyword) throws AssetException {
        if (!word()) {
            throw refuse("`" + keyword + "` has too few numbers");
        }
        return number();
    }

    /** Returns the last word as a number. */
    float number() throws AssetException {
        if (to - from <= MAX_NUMBER_LENGTH) {
            try {
                return Float.parseFloat(text());
            } catch (NumberFormatException none) {
                // The parser's exception is ignored. The exception below reports that the word is
                // no number.
            }
        }
        throw refuse("`" + text() + "` is no number");
    }

    /** Returns the last word as a finite number. */
    float finite() throws AssetException {
        float number = number();
        if (!Float.isFinite(number)) {
            throw refuse("`" + text() + "` is no finite 32-bit number");
        }
        return number;
    }

    /** Returns whether the last word is a number. */
    boolean isNumber() {
        try {
            number();
            return true;
        } catch (AssetException none) {
            return false;
        }
    }

    /**
     * Parses the last word as a corner of a face: {@code 1}, {@code 1/2}, {@code 1//3} or {@code
     * 1/2/3}.
     *
     * @param counts (3) number of positions, texture coordinates and normals read so far
     * @param into (3) receives the indices of the corner in these three lists, from 0; -1 for none
     */
    void corner(int[] counts, int[] into) throws AssetException {
        int begin = from;
        for (int part = 0; part < 3; part++) {
            int end = begin;
            while (end < to && bytes[end] != '/') {
                end++;
            }
            into[part] =
                    begin >= to || end == begin && part == 1 ? -1 : index(begin, end, counts[part]);
            begin = end + 1;
        }
        if (begin <= to || into[0] < 0) {
            throw refuse("`" + text() + "` is no corner of a face");
        }
    }

    /**
     * Parses an index into an index from 0. A positive index in the file counts from 1, and a
     * negative one is relative to the last element. The caller checks the upper limit after the
     * whole file is read.
     */
    private int index(int begin, int end, int count) throws AssetException {
        boolean back = begin < end && bytes[begin] == '-';
        long number = 0;
        int digits = back ? begin + 1 : begin;
        for (int i = digits; i < end; i++) {
            int digit = bytes[i] - '0';
            number =
                    digit < 0 || digit > 9 || number > Integer.MAX_VALUE
                            ? -1
                            : number < 0 ? -1 : 10 * number + digit;
        }
        long index = back ? count - number : number - 1;
        if (digits == end || number <= 0 || index < 0 || index > Integer.MAX_VALUE) {
            throw refuse("`" + text() + "` is no corner of a face that there is");
        }
        return (int) index;
    }

    AssetException refuse(String reason) {
        return sources.refuse(format + ": line " + line + ": " + reason);
    }

    /** Returns the last word, shortened for messages. */
    String text() {
        int length = Math.min(to - from, MAX_NUMBER_LENGTH);
        String word = new String(bytes, from, length, StandardCharsets.UTF_8);
        return length <= SHOWN || length == to - from ? word : word.substring(0, SHOWN) + "…";
    }

    /** Returns the last word in lower case. */
    String keyword() {
        return text().toLowerCase(Locale.ROOT);
    }

    /**
     * Returns whether the byte is white space or the start of a line continuation (a backslash and
     * a line end).
     */
    private boolean isGap(int place) {
        byte b = bytes[place];
        return b == ' ' || b == '\t' || b == '\r' || b == '\f' || joins(place) > 0;
    }

    private void skipGap() {
        int joined = joins(at);
        line += joined > 0 ? 1 : 0;
        at += Math.max(1, joined);
    }

    /** Returns the length of the line continuation at this place [bytes]; 0 if there is none. */
    private int joins(int place) {
        if (bytes[place] != '\\') {
            return 0;
        }
        int feed = place + 1 < bytes.length && bytes[place + 1] == '\r' ? place + 2 : place + 1;
        return feed < bytes.length && bytes[feed] == '\n' ? feed + 1 - place : 0;
    }
}
