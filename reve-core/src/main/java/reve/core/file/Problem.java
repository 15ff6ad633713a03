package reve.core.file;

import java.util.Comparator;

/**
 * One thing that is wrong with a world file.
 *
 * @param file the file's name as the caller gave it
 * @param line from 1
 * @param column from 1, in characters
 * @param pointer JSON pointer of the value, such as {@code /items/0/physics/mass}; empty for the
 *     file as a whole
 * @param message what was found, what was expected, what to do
 */
public record Problem(String file, int line, int column, String pointer, String message)
        implements Comparable<Problem> {
    private static final Comparator<Problem> BY_POSITION = Comparator.comparing(Problem::file)
            .thenComparingInt(Problem::line).thenComparingInt(Problem::column)
            .thenComparing(Problem::message).thenComparing(Problem::pointer);

    @Override
    public int compareTo(Problem other) {
        return BY_POSITION.compare(this, other);
    }

    /** {@code file:line:column: message}. */
    @Override
    public String toString() {
        return file + ":" + line + ":" + column + ": " + message;
    }
}
