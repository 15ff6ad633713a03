// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

/**
 * Check of an XML file before a parser reads it. The parser of the JDK keeps each tag and each
 * comment as a whole, so a tag of many megabytes would fill the memory. The check also refuses
 * document types, which could define entities and name other files.
 */
final class XmlBounds {
    /** Maximum length of a tag, a comment, a section of raw text or an instruction [bytes]. */
    private static final int MAX_MARKUP = 65_536;

    private final byte[] bytes;
    private final Sources sources;
    private int at;
    private int line = 1;

    private XmlBounds(byte[] bytes, Sources sources) {
        this.bytes = bytes;
        this.sources = sources;
    }

    /** Refuses a file with a document type, too long markup, or another encoding than ASCII's. */
    static void require(byte[] bytes, Sources sources) throws AssetException {
        new XmlBounds(bytes, sources).scan();
    }

    private void scan() throws AssetException {
        if (starts("\u00ef\u00bb\u00bf")) {
            at = 3; // the byte order mark of UTF-8
        }
        while (at < bytes.length && bytes[at] >= 0 && bytes[at] <= ' ') {
            advance();
        }
        if (at < bytes.length && bytes[at] != '<') {
            throw refuse("this is not XML: expected `<` and a text in UTF-8");
        }
        while (at < bytes.length) {
            if (bytes[at] == 0) {
                throw refuse("this is not XML: found a byte 0, expected a text in UTF-8");
            }
            if (bytes[at] == '<') {
                markup();
            } else {
                advance();
            }
        }
    }

    private void markup() throws AssetException {
        if (starts("<!--")) {
            skipTo("-->");
        } else if (starts("<![CDATA[")) {
            skipTo("]]>");
        } else if (starts("<?")) {
            skipTo("?>");
        } else if (starts("<!")) {
            throw refuse("a document type or an entity, expected neither; remove it");
        } else {
            tag();
        }
    }

    private void skipTo(String end) throws AssetException {
        int begin = at;
        while (at < bytes.length && !starts(end)) {
            next(begin);
        }
        at = Math.min(bytes.length, at + end.length());
    }

    /** Skips a tag. Its attributes may contain {@code >} in quotes. */
    private void tag() throws AssetException {
        int begin = at;
        byte quote = 0;
        while (at < bytes.length && (quote != 0 || bytes[at] != '>')) {
            byte b = bytes[at];
            if (quote == 0 && (b == '"' || b == '\'')) {
                quote = b;
            } else if (b == quote) {
                quote = 0;
            }
            next(begin);
        }
        at++;
    }

    private void next(int begin) throws AssetException {
        if (at - begin > MAX_MARKUP) {
            throw refuse("a tag or comment is longer than " + MAX_MARKUP + " bytes; shorten it");
        }
        advance();
    }

    private void advance() {
        line += bytes[at++] == '\n' ? 1 : 0;
    }

    private boolean starts(String text) {
        for (int i = 0; i < text.length(); i++) {
            if (at + i >= bytes.length || (bytes[at + i] & 0xff) != text.charAt(i)) {
                return false;
            }
        }
        return true;
    }

    private AssetException refuse(String reason) {
        return sources.refuse("not COLLADA: line " + line + ": " + reason);
    }
}
