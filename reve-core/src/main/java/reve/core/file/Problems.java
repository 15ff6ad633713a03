package reve.core.file;

import java.util.ArrayList;
import java.util.List;

/** Collects what is wrong with one file; stops taking more when nobody would read on. */
final class Problems {
    /** Most problems that one report holds. */
    static final int MAX_REPORTED = 100;

    private final String file;
    private final List<Problem> found = new ArrayList<>();
    private boolean cutShort;

    Problems(String file) {
        this.file = file;
    }

    /** Notes a problem with the value of a node. */
    void add(Node node, String message) {
        add(node.line(), node.column(), node.pointer(), message);
    }

    /** Notes a problem with the key that a node stands under. */
    void addAtKey(Node node, String message) {
        add(node.keyLine(), node.keyColumn(), node.pointer(), message);
    }

    void add(int line, int column, String pointer, String message) {
        if (full()) {
            cutShort = true;
        } else {
            found.add(new Problem(file, line, column, pointer, message));
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
        found.add(new Problem(file, line, column, "", message));
        return exception();
    }

    private WorldFileException exception() {
        var sorted = new ArrayList<>(found);
        sorted.sort(null);
        if (cutShort) {
            Problem last = sorted.getLast();
            sorted.add(new Problem(file, last.line(), last.column(), "",
                    "more than " + MAX_REPORTED + " problems; only these are shown"));
        }
        return new WorldFileException(sorted);
    }
}
