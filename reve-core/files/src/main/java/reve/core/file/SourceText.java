// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.io.IOException;
import java.io.InputStream;
import java.nio.ByteBuffer;
import java.nio.CharBuffer;
import java.nio.charset.CharsetDecoder;
import java.nio.charset.CoderResult;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;

/**
 * Reader of a file's text. It refuses files that are too large, are not UTF-8 or would take the
 * parser too long.
 */
final class SourceText {
    /** Maximum size of a world file with all included files [bytes]. */
    static final int MAX_BYTES = 16 << 20;

    /**
     * Maximum length of a stretch of text without any of the {@link #BREAKS} [characters]. The
     * parser needs seconds for a longer stretch.
     */
    static final int MAX_STRETCH = 65_536;

    private static final String BREAKS = "\n,:[]{}\"";

    private SourceText() {}

    /**
     * Reads a regular UTF-8 file.
     *
     * @param bytes number of bytes that may still be read
     * @throws IOException if the system cannot read the file
     */
    static String read(Path path, Problems problems, Allowance bytes)
            throws IOException, WorldFileException {
        if (!Files.exists(path)) {
            throw problems.fatal(1, 1, "there is no such file");
        }
        if (!Files.isRegularFile(path)) {
            throw problems.fatal(
                    1,
                    1,
                    Files.isDirectory(path)
                            ? "a folder; name the world file in it"
                            : "not a regular file");
        }
        try (InputStream in = Files.newInputStream(path)) {
            // At most the stated size is read. Reading more from a file with the stated size 0,
            // such as /proc/kmsg, could block for ever.
            int size = (int) Math.min(Files.size(path), MAX_BYTES + 1L);
            return decode(in.readNBytes(size), problems, bytes);
        }
    }

    static String decode(byte[] bytes, Problems problems, Allowance allowed)
            throws WorldFileException {
        if (!allowed.take(bytes.length)) {
            throw problems.fatal(
                    1,
                    1,
                    "larger than "
                            + (MAX_BYTES >> 20)
                            + " MiB, the limit for a world file with all that it includes");
        }
        CharsetDecoder decoder = StandardCharsets.UTF_8.newDecoder();
        CharBuffer text = CharBuffer.allocate(bytes.length);
        CoderResult result = decoder.decode(ByteBuffer.wrap(bytes), text, true);
        text.flip();
        if (result.isError()) {
            throw atEnd(text, problems, "not UTF-8 text from here on; save the file as UTF-8");
        }
        int start = !text.isEmpty() && text.charAt(0) == '\uFEFF' ? 1 : 0;
        String decoded = text.subSequence(start, text.length()).toString();
        checkStretches(decoded, problems);
        return decoded;
    }

    private static void checkStretches(String text, Problems problems) throws WorldFileException {
        int begin = 0;
        for (int i = 0; i < text.length(); i++) {
            if (BREAKS.indexOf(text.charAt(i)) >= 0) {
                begin = i + 1;
            } else if (i - begin >= MAX_STRETCH) {
                throw atEnd(
                        text.substring(0, begin),
                        problems,
                        "more than "
                                + MAX_STRETCH
                                + " characters in one piece; is this a world file?");
            }
        }
    }

    /**
     * Returns an exception whose position is the end of a text.
     *
     * @param text beginning of the file up to the position of the error
     */
    private static WorldFileException atEnd(CharSequence text, Problems problems, String message) {
        int line = 1;
        int column = 1;
        for (int i = 0; i < text.length(); i++) {
            boolean lineBreak = text.charAt(i) == '\n';
            column = lineBreak ? 1 : column + 1;
            line += lineBreak ? 1 : 0;
        }
        return problems.fatal(line, column, message);
    }
}
