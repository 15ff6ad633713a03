// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Comparator;

/**
 * An error or a warning about a world file.
 *
 * @param severity whether the problem causes the refusal of the file
 * @param file name of the file, in the form in which the caller gave it
 * @param line number of the line, from 1
 * @param column number of the character in the line, from 1
 * @param pointer JSON pointer of the value, such as {@code /items/0/physics/mass}; empty for the
 *     file as a whole
 * @param message states what was found, what was expected, and what to do
 */
public record Problem(
        Severity severity, String file, int line, int column, String pointer, String message)
        implements Comparable<Problem> {
    /** The effect of a problem on the file. */
    public enum Severity {
        /** A problem because of which the file is refused. */
        ERROR,
        /** A problem of a valid file that may differ from the intention of its author. */
        WARNING
    }

    private static final Comparator<Problem> BY_POSITION =
            Comparator.comparing(Problem::file)
                    .thenComparingInt(Problem::line)
                    .thenComparingInt(Problem::column)
                    .thenComparing(Problem::message)
                    .thenComparing(Problem::pointer);

    @Override
    public int compareTo(Problem other) {
        return BY_POSITION.compare(this, other);
    }

    /** Returns {@code file:line:column: message}, or {@code file:line:column: warning: message}. */
    @Override
    public String toString() {
        return file
                + ":"
                + line
                + ":"
                + column
                + ": "
                + (severity == Severity.WARNING ? "warning: " : "")
                + message;
    }
}
