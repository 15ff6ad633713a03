// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.Optional;

/**
 * Search for a quote or bracket that was not closed. A YAML parser reports only the position at
 * which parsing failed, which may be the end of the file. This search recognizes only quotes,
 * comments, brackets and block texts.
 */
final class Unclosed {
    /**
     * An opening quote or bracket.
     *
     * @param line line of the sign, from 1
     * @param column column of the sign, from 1
     * @param indent number of spaces at the start of the line
     */
    record Opening(char sign, int line, int column, int indent) {}

    private final String text;
    private final Deque<Opening> brackets = new ArrayDeque<>();
    private int at;
    private int line = 1;
    private int lineStart;

    /** Number of spaces at the start of the current line; -1 until it is computed. */
    private int indent = -1;

    /** Start of the last quoted text, if it spans several lines. */
    private @Nullable Opening quote;

    private int quoteEnd;

    private Unclosed(String text) {
        this.text = text;
    }

    /**
     * Returns the quote or bracket that is still open at the position where the parser failed.
     *
     * @param problemLine line of the failure, from 1
     * @param problemColumn column of the failure, from 1
     */
    static Optional<Opening> find(String text, int problemLine, int problemColumn) {
        var scan = new Unclosed(text);
        scan.read(problemLine, problemColumn);
        if (scan.quote != null && scan.quoteEnd >= problemLine) {
            return Optional.of(scan.quote);
        }
        boolean atEnd =
                text.substring(Math.min(scan.at, text.length()))
                        .lines()
                        .allMatch(rest -> rest.isBlank() || rest.stripLeading().startsWith("#"));
        int outer = scan.indentOf(problemLine);
        return Optional.ofNullable(scan.brackets.peekLast())
                .filter(opening -> atEnd || opening.line < problemLine && outer <= opening.indent);
    }

    private void read(int toLine, int toColumn) {
        boolean tokenStart = true;
        while (at < text.length()
                && (line < toLine || line == toLine && at - lineStart + 1 < toColumn)) {
            char c = text.charAt(at);
            if (c == '\n') {
                newLine();
                tokenStart = true;
            } else if (c == '#' && (at == lineStart || isBlank(text.charAt(at - 1)))) {
                skipLine();
            } else if (tokenStart && (c == '"' || c == '\'')) {
                readQuoted(c);
                tokenStart = false;
            } else if (c == '{' || c == '[') {
                if (tokenStart || !brackets.isEmpty()) {
                    brackets.addLast(opening(c));
                    tokenStart = true;
                }
                at++;
            } else if (c == '}' || c == ']') {
                brackets.pollLast();
                tokenStart = false;
                at++;
            } else if (tokenStart && (c == '|' || c == '>') && brackets.isEmpty()) {
                skipBlock();
            } else {
                tokenStart =
                        c == ',' && !brackets.isEmpty()
                                || isBlank(c) && tokenStart
                                || (c == ':' || c == '-' && tokenStart) && isBlankAt(at + 1);
                at++;
            }
        }
    }

    private void readQuoted(char sign) {
        Opening begin = opening(sign);
        at++;
        while (at < text.length() && text.charAt(at) != sign) {
            if (text.charAt(at) == '\\' && sign == '"') {
                at++;
            }
            if (at < text.length() && text.charAt(at) == '\n') {
                newLine();
            } else {
                at++;
            }
        }
        if (begin.line < line || at >= text.length()) {
            quote = begin;
            quoteEnd = line;
        }
        at++;
    }

    /** Skips a block text, whose lines are indented deeper than the line in which it begins. */
    private void skipBlock() {
        int outer = indent();
        skipLine();
        while (at < text.length()) {
            int next = at + 1;
            int depth = 0;
            while (next + depth < text.length() && text.charAt(next + depth) == ' ') {
                depth++;
            }
            boolean empty = next + depth >= text.length() || text.charAt(next + depth) == '\n';
            if (!empty && depth <= outer) {
                return;
            }
            newLine();
            skipLine();
        }
    }

    private void skipLine() {
        int end = text.indexOf('\n', at);
        at = end < 0 ? text.length() : end;
    }

    private void newLine() {
        at++;
        line++;
        lineStart = at;
        indent = -1;
    }

    private Opening opening(char sign) {
        return new Opening(sign, line, at - lineStart + 1, indent());
    }

    private int indent() {
        if (indent < 0) {
            indent = indentOf(line);
        }
        return indent;
    }

    private int indentOf(int which) {
        int start = lineStart;
        for (int other = line; other > which; other--) {
            start = text.lastIndexOf('\n', start - 2) + 1;
        }
        int blanks = 0;
        while (start + blanks < text.length() && text.charAt(start + blanks) == ' ') {
            blanks++;
        }
        return blanks;
    }

    private boolean isBlankAt(int index) {
        return index >= text.length() || isBlank(text.charAt(index));
    }

    private static boolean isBlank(char c) {
        return c == ' ' || c == '\t' || c == '\n' || c == '\r';
    }
}
