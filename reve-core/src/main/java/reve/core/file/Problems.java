package reve.core.file;

import java.util.ArrayList;
import java.util.List;
import java.util.regex.Pattern;

/** Collects what is wrong with one file; stops taking more when nobody would read on. */
final class Problems {
    /** Most problems that one report holds. */
    static final int MAX_REPORTED = 100;

    private static final Pattern CONTROL_CHARACTER = Pattern.compile("\\p{Cc}");

    private final String file;
    private final List<Problem> found = new ArrayList<>();

    Problems(String file) {
        this.file = file;
    }

    /** Where a node's value begins, as {@code file:line:column}. */
    String place(Node node) {
        return file + ":" + node.line() + ":" + node.column();
    }

    /** Notes a problem with the value of a node; of a single value, the first one says enough. */
    void add(Node node, String message) {
        boolean single = !node.isMapping() && !node.isList();
        if (!single || found.stream().noneMatch(
                problem -> problem.pointer().equals(node.pointer()))) {
            add(node.line(), node.column(), node.pointer(), message);
        }
    }

    /** Notes a problem with the key that a node stands under. */
    void addAtKey(Node node, String message) {
        add(node.keyLine(), node.keyColumn(), node.pointer(), message);
    }

    void add(int line, int column, String pointer, String message) {
        if (!full()) {
            found.add(problem(line, column, pointer, message));
        }
    }

    boolean full() {
        return found.size() >= MAX_REPORTED;
    }

    boolean isEmpty() {
        return found.isEmpty();
    }

    /** Ends the reading if anything was found. */
    void throwIfAny() throws WorldFileException {
        if (!found.isEmpty()) {
            throw exception();
        }
    }

    /** Notes a problem after which reading on makes no sense. */
    WorldFileException fatal(int line, int column, String message) {
        found.add(problem(line, column, "", message));
        return exception();
    }

    /** What a file contains must not control the terminal that shows the message. */
    private Problem problem(int line, int column, String pointer, String message) {
        return new Problem(file, line, column, pointer,
                CONTROL_CHARACTER.matcher(message).replaceAll(" "));
    }

    private WorldFileException exception() {
        var sorted = new ArrayList<>(found);
        sorted.sort(null);
        if (full()) {
            Problem last = sorted.getLast();
            sorted.add(new Problem(file, last.line(), last.column(), "",
                    "no more than " + MAX_REPORTED + " problems are shown; there may be others"));
        }
        return new WorldFileException(sorted);
    }
}
