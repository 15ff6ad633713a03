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
 * Collector of the problems (errors and warnings) in a world file and its included files. It limits
 * the number of problems.
 */
final class Problems {
    /** Maximum number of problems in one report. */
    static final int MAX_REPORTED = 100;

    /**
     * Maximum number of wrong names in one report for which the collector searches a similar known
     * name.
     */
    static final int MAX_SUGGESTIONS = 20;

    private static final Pattern CONTROL_CHARACTER = Pattern.compile("\\p{Cc}");

    private final String file;
    private final List<Problem> found;
    private final List<Problem> warnings;

    /**
     * Mappings with an unknown key. The unknown key may be a misspelling of the required one if
     * such a mapping lacks a required key.
     */
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

    /** Returns a collector for another file. It adds its problems to the same report. */
    Problems of(String otherFile) {
        return new Problems(otherFile, found, warnings, misspelt, suggestions);
    }

    /** Returns the name of the file that is being read. */
    String file() {
        return file;
    }

    /** Returns the position of a node's value, as {@code file:line:column}. */
    static String place(Node node) {
        return node.file() + ":" + node.line() + ":" + node.column();
    }

    /** Returns the position of a node's key, as {@code file:line:column}. */
    static String keyPlace(Node node) {
        return node.file() + ":" + node.keyLine() + ":" + node.keyColumn();
    }

    /**
     * Returns the position of another node for a message about {@code from}. The result is {@code
     * on line 5} in the same file, or {@code in f.yaml:5} in another file.
     */
    static String place(Node other, Node from) {
        return other.file().equals(from.file())
                ? "on line " + other.line()
                : "in " + other.file() + ":" + other.line();
    }

    /**
     * Records a problem with the value of a node. Only the first of several problems of one scalar
     * value is recorded.
     */
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

    /**
     * Records a problem at a character of a text. For a text in YAML block style, the position is
     * the start of the text.
     *
     * @param offset index of the character, from 0
     */
    void addInText(Node node, int offset, String message) {
        int column = node.textColumn() < 0 ? node.column() : node.textColumn() + offset;
        add(problem(node.file(), node.line(), column, node.pointer(), message));
    }

    /**
     * Records a problem with the key of a node. Like {@link #add(Node, String)}, this method
     * records only the first problem of a scalar value.
     */
    void addAtKey(Node node, String message) {
        if (isFirst(node)) {
            add(problem(node.file(), node.keyLine(), node.keyColumn(), node.pointer(), message));
        }
    }

    void add(int line, int column, String pointer, String message) {
        add(problem(file, line, column, pointer, message));
    }

    /** Records a key that a mapping cannot have. */
    void addUnknownKey(Node mapping, Node node, String message) {
        misspelt.add(mapping.file() + mapping.pointer());
        addAtKey(node, message);
    }

    /**
     * Returns whether the mapping has an unknown key. Missing keys of such a mapping are not
     * reported, because the unknown key may be a misspelling of the missing key.
     */
    boolean isMisspelt(Node mapping) {
        return misspelt.contains(mapping.file() + mapping.pointer());
    }

    /**
     * Returns the end of a message that suggests the intended name. Returns an empty text if no
     * known name is similar. Also returns an empty text after {@link #MAX_SUGGESTIONS} names,
     * because the search is slow.
     */
    String suggestion(String wrong, Collection<String> known) {
        return !full() && suggestions.take(1) ? Suggestion.of(wrong, known) : "";
    }

    /** Records a warning. A warning does not make the file invalid. */
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

    /** Creates a warning about a fault that is found only after the file was read. */
    static Problem warning(String file, int line, int column, String pointer, String message) {
        return problem(Problem.Severity.WARNING, file, line, column, pointer, message);
    }

    /**
     * Returns the warnings in order of position. Their number does not exceed {@link
     * #MAX_REPORTED}.
     */
    List<Problem> warnings() {
        return warnings.stream().sorted().toList();
    }

    /**
     * Adds a problem unless it was added before. The same problem occurs again if several items
     * take a value from one prefab.
     */
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
     * Throws an exception if all files together declare more than {@code most} values under a key.
     * Called before the values are read.
     *
     * @param declared the declared values
     * @param key name of the key, for the message
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

    /** Throws an exception if the report has its maximum number of errors. */
    void throwIfFull() throws WorldFileException {
        if (full()) {
            throw exception();
        }
    }

    /** Throws an exception if there is any error. */
    void throwIfAny() throws WorldFileException {
        if (!found.isEmpty()) {
            throw exception();
        }
    }

    /** Returns an exception for an error after which the file cannot be read further. */
    WorldFileException fatal(int line, int column, String message) {
        found.add(problem(file, line, column, "", message));
        return exception();
    }

    private static Problem problem(
            String file, int line, int column, String pointer, String message) {
        return problem(Problem.Severity.ERROR, file, line, column, pointer, message);
    }

    /**
     * Creates a problem. Escapes control characters, because the content of a file must not control
     * a terminal.
     */
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
