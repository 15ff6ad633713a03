// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.List;
import java.util.stream.Collectors;

/**
 * Thrown if a world file is refused. The message contains all problems, one per line, in the order
 * of the file.
 */
public final class WorldFileException extends Exception {
    private static final long serialVersionUID = 1L;

    private final transient List<Problem> problems;

    WorldFileException(List<Problem> problems) {
        super(problems.stream().map(Problem::toString).collect(Collectors.joining("\n")));
        this.problems = List.copyOf(problems);
    }

    /** Returns the problems sorted by position. There is at least one. */
    public List<Problem> problems() {
        return problems;
    }
}
