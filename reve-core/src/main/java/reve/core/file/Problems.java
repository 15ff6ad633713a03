// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.text.Suggestion;
import reve.core.text.Visible;

import java.util.ArrayList;
import java.util.Collection;
import java.util.HashSet;
import java.util.List;
import java.util.Set;
import java.util.regex.Pattern;

/**
 * Collects what is wrong with a world file and those that it includes; stops taking more when
 * nobody would read on.
 */
final class Problems {
    /** Most problems that one report holds. */
    static final int MAX_REPORTED = 100;

    /** Most names for which one report looks for what was meant. */
    static final int MAX_SUGGESTIONS = 20;

    private static final Pattern CONTROL_CHARACTER = Pattern.compile("\\p{Cc}");

    private final String file;
    private final List<Problem> found;
    private final List<Problem> warnings;

    /** Mappings in which a key is not known: what they seem to lack may be that. */
    private final Set<String> misspelt;

    private final Allowance suggestions;

    Problems(String file) {
        this(
                file,
                new ArrayList<>(),
                new ArrayList<>(),
                new HashSet<>(),
                new Allowance(MAX_SUGGESTIONS));
    }

    private Problems(
            String file,
            List<Problem> found,
            List<Problem> warnings,
            Set<String> misspelt,
            Allowance suggestions) {
        this.suggestions = suggestions;
        this.file = file;
        this.found = found;
        this.warnings = warnings;
        this.misspelt = misspelt;
    }

    /** The same problems, to be told of another file. */
    Problems of(String otherFile) {
        return new Problems(otherFile, found, warnings, misspelt, suggestions);
    }

    /** The file that is being read. */
    String file() {
        return file;
    }

    /** Where a node's value begins, as {@code file:line:column}. */
    static String place(Node node) {
        return node.file() + ":" + node.line() + ":" + node.column();
    }

    /** Where the key of a node's value stands, as {@code file:line:column}. */
    static String keyPlace(Node node) {
        return node.file() + ":" + node.keyLine() + ":" + node.keyColumn();
    }

    /** Where another node stands, for messages: {@code on line 5}, or {@code in f.yaml:5}. */
    static String place(Node other, Node here) {
        return other.file().equals(here.file())
                ? "on line " + other.line()
                : "in " + other.file() + ":" + other.line();
    }

    /** Notes a problem with the value of a node; of a single value, the first one says enough. */
    void add(Node node, String message) {
        if (isFirst(node)) {
            add(problem(node.file(), node.line(), node.column(), node.pointer(), message));
        }
    }

    private boolean isFirst(Node node) {
        return node.isMapping()
                || node.isList()
                || found.stream()
                        .noneMatch(
                                problem ->
                                        problem.file().equals(node.file())
                                                && problem.pointer().equals(node.pointer()));
    }

    /** Notes a problem at a character of a text, from 0; of a text in block style, at its start. */
    void addInText(Node node, int offset, String message) {
        int column = node.textColumn() < 0 ? node.column() : node.textColumn() + offset;
        add(problem(node.file(), node.line(), column, node.pointer(), message));
    }

    /** Notes a problem with the key that a node stands under, as {@link #add(Node, String)}. */
    void addAtKey(Node node, String message) {
        if (isFirst(node)) {
            add(problem(node.file(), node.keyLine(), node.keyColumn(), node.pointer(), message));
        }
    }

    void add(int line, int column, String pointer, String message) {
        add(problem(file, line, column, pointer, message));
    }

    /** Notes a key that a mapping cannot have. */
    void addUnknownKey(Node mapping, Node node, String message) {
        misspelt.add(mapping.file() + mapping.pointer());
        addAtKey(node, message);
    }

    /** Whether a key of the mapping is not known, so that what it lacks needs no telling. */
    boolean isMisspelt(Node mapping) {
        return misspelt.contains(mapping.file() + mapping.pointer());
    }

    /**
     * The end of a message that says which name was probably meant. Empty if none is near, and for
     * all but the first names: to look for them takes longer than all else.
     */
    String suggestion(String wrong, Collection<String> known) {
        return !full() && suggestions.take(1) ? Suggestion.of(wrong, known) : "";
    }

    /** Notes what does not keep a file from being valid. */
    void warn(Node node, String message) {
        Problem warning =
                problem(
                        Problem.Severity.WARNING,
                        node.file(),
                        node.line(),
                        node.column(),
                        node.pointer(),
                        message);
        if (warnings.size() < MAX_REPORTED && !warnings.contains(warning)) {
            warnings.add(warning);
        }
    }

    /** By their places, as many as a report holds. */
    List<Problem> warnings() {
        return warnings.stream().sorted().toList();
    }

    /** What several items have from one place is told once. */
    private void add(Problem problem) {
        if (!full() && !found.contains(problem)) {
            found.add(problem);
        }
    }

    boolean full() {
        return found.size() >= MAX_REPORTED;
    }

    boolean isEmpty() {
        return found.isEmpty();
    }

    /**
     * Ends the reading if all files together declare too many, before anything is made of them.
     *
     * @param declared what they declare
     * @param key under which they do
     */
    void requireAtMost(int most, List<Node> declared, String key) throws WorldFileException {
        if (declared.size() > most) {
            Node first = declared.get(most);
            throw of(first.file())
                    .fatal(
                            first.keyLine(),
                            first.keyColumn(),
                            key
                                    + ": found "
                                    + declared.size()
                                    + " in all files, expected at most "
                                    + most);
        }
    }

    /** Ends the reading if no more would be told. */
    void throwIfFull() throws WorldFileException {
        if (full()) {
            throw exception();
        }
    }

    /** Ends the reading if anything was found. */
    void throwIfAny() throws WorldFileException {
        if (!found.isEmpty()) {
            throw exception();
        }
    }

    /** Notes a problem after which reading on makes no sense. */
    WorldFileException fatal(int line, int column, String message) {
        found.add(problem(file, line, column, "", message));
        return exception();
    }

    private static Problem problem(
            String file, int line, int column, String pointer, String message) {
        return problem(Problem.Severity.ERROR, file, line, column, pointer, message);
    }

    /** What a file contains must not control the terminal that shows the message. */
    private static Problem problem(
            Problem.Severity severity,
            String file,
            int line,
            int column,
            String pointer,
            String message) {
        return new Problem(
                severity,
                file,
                line,
                column,
                pointer,
                Visible.line(CONTROL_CHARACTER.matcher(message).replaceAll(" ")));
    }

    private WorldFileException exception() {
        var sorted = new ArrayList<>(found);
        sorted.sort(null);
        if (full()) {
            Problem last = sorted.getLast();
            sorted.add(
                    problem(
                            last.file(),
                            last.line(),
                            last.column(),
                            "",
                            "no more than "
                                    + MAX_REPORTED
                                    + " problems are shown; there may be others"));
        }
        return new WorldFileException(sorted);
    }
}
