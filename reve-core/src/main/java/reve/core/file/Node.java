// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;

/**
 * One value of a file and where it stands. The asking methods answer "empty" where a value has
 * another type than asked for: that is for the schema to report, once.
 */
final class Node {
    /** Most names that a message lists. */
    private static final int MAX_LISTED = 24;

    private final String file;
    private final @Nullable Node parent;
    private final Object key;
    private final int keyLine;
    private final int keyColumn;
    private final int line;
    private final int column;

    /** A map or list of nodes, String, Long, Double, Boolean, or null for nothing. */
    private final @Nullable Object value;

    private int textColumn;

    private Node(
            String file,
            @Nullable Node parent,
            Object key,
            int keyLine,
            int keyColumn,
            int line,
            int column,
            @Nullable Object value) {
        this.file = file;
        this.parent = parent;
        this.key = key;
        this.keyLine = keyLine;
        this.keyColumn = keyColumn;
        this.line = line;
        this.column = column;
        this.value = value;
        this.textColumn = column;
    }

    /** The outermost value of a file; {@code value} as {@link Slot#fill}. */
    static Node root(String file, int line, int column, @Nullable Object value) {
        return new Node(file, null, "", line, column, line, column, value);
    }

    /** Another value that takes the place of this one; as {@link Slot#fill}. */
    Node withValue(@Nullable Object other) {
        return new Node(file, parent, key, keyLine, keyColumn, line, column, other);
    }

    /** A list of numbers that takes the place of this value. */
    Node withNumbers(double[] numbers) {
        List<Node> elements = new ArrayList<>(numbers.length);
        Node list = withValue(elements);
        for (int i = 0; i < numbers.length; i++) {
            elements.add(new Node(file, list, i, line, column, line, column, numbers[i]));
        }
        return list;
    }

    /**
     * This mapping with all that it leaves open taken from another one: mappings under the same key
     * are laid over each other in the same way, anything else here hides what is there. Every value
     * keeps the place where it stands.
     */
    Node over(Node base) {
        var fields = new LinkedHashMap<>(base.fieldMap());
        fieldMap()
                .forEach(
                        (name, value) ->
                                fields.merge(
                                        name,
                                        value,
                                        (below, above) ->
                                                above.isMapping() && below.isMapping()
                                                        ? above.over(below)
                                                        : above));
        return withValue(fields);
    }

    /** How many values the mapping holds, and the mappings in it. */
    int fieldCount() {
        int count = 0;
        for (Node field : children()) {
            count += field.isMapping() ? 1 + field.fieldCount() : 1;
        }
        return count;
    }

    /** How many values this is, with all that it holds. */
    long valueCount() {
        long count = 1;
        for (Node child : children()) {
            count += child.valueCount();
        }
        return count;
    }

    /** This mapping without one of its keys. */
    Node without(String name) {
        if (get(name).isEmpty()) {
            return this;
        }
        var fields = new LinkedHashMap<>(fieldMap());
        fields.remove(name);
        return withValue(fields);
    }

    /** A place in a mapping or a list that waits for its value. */
    record Slot(Node parent, Object key, int keyLine, int keyColumn) {
        /**
         * @param value a new LinkedHashMap or ArrayList for a mapping or list, else the scalar
         */
        Node fill(int line, int column, @Nullable Object value) {
            Node node = new Node(parent.file, parent, key, keyLine, keyColumn, line, column, value);
            if (parent.value instanceof List<?>) {
                parent.elementList().add(node);
            } else {
                parent.fieldMap().put((String) key, node);
            }
            return node;
        }
    }

    /** Whether this stands in the mapping that {@code owner} was written as, not in a prefab. */
    boolean isWrittenIn(Node owner) {
        return parent != null && parent.parent == owner.parent && parent.key.equals(owner.key);
    }

    /** Says that the text does not begin in the column of the value: behind a quote, or below. */
    void setTextColumn(int newTextColumn) {
        textColumn = newTextColumn;
    }

    /** Where the first character of a text stands, -1 if in another line than the value begins. */
    int textColumn() {
        return textColumn;
    }

    /** The file that the value stands in, as messages call it. */
    String file() {
        return file;
    }

    int line() {
        return line;
    }

    int column() {
        return column;
    }

    /** Where the key of this value stands; where the value stands if it has none. */
    int keyLine() {
        return key instanceof String ? keyLine : line;
    }

    int keyColumn() {
        return key instanceof String ? keyColumn : column;
    }

    /** The key in the mapping, or the number in the list from 0. */
    String key() {
        return key.toString();
    }

    /** How messages name this value: {@code mass}, {@code laws[2]}; empty for the root. */
    String label() {
        return parent == null || key instanceof String
                ? shorten(key())
                : parent.label() + "[" + key + "]";
    }

    /** The JSON pointer from the root to here. */
    String pointer() {
        return parent == null
                ? ""
                : parent.pointer() + "/" + key().replace("~", "~0").replace("/", "~1");
    }

    /** Whether it is in a list, and has no name. */
    boolean isElement() {
        return !(key instanceof String);
    }

    boolean isMapping() {
        return value instanceof Map<?, ?>;
    }

    boolean isList() {
        return value instanceof List<?>;
    }

    boolean isNothing() {
        return value == null;
    }

    /** The value under a key of a mapping. */
    Optional<Node> get(String name) {
        return isMapping() ? Optional.ofNullable(fieldMap().get(name)) : Optional.empty();
    }

    /** The value at a place of a list, from 0. */
    Optional<Node> get(int index) {
        return isList() && index >= 0 && index < elementList().size()
                ? Optional.of(elementList().get(index))
                : Optional.empty();
    }

    /** What a mapping or list holds, in the order of the file. */
    Collection<Node> children() {
        return isMapping() ? fieldMap().values() : isList() ? elementList() : List.of();
    }

    Optional<String> text() {
        return value instanceof String text ? Optional.of(text) : Optional.empty();
    }

    Optional<Double> number() {
        return value instanceof Number number
                ? Optional.of(number.doubleValue())
                : Optional.empty();
    }

    Optional<Boolean> truth() {
        return value instanceof Boolean truth ? Optional.of(truth) : Optional.empty();
    }

    /** String, Long, Double or Boolean; empty for mappings, lists and nothing. */
    Optional<Object> scalar() {
        return isMapping() || isList() ? Optional.empty() : Optional.ofNullable(value);
    }

    /** What was found, for messages: {@code number 3}, {@code a list}. */
    String describe() {
        return switch (value) {
            case null -> "nothing";
            case String text -> "text `" + shorten(text) + "`";
            case Boolean truth -> "`" + truth + "`";
            case Number number -> "number " + number;
            case Map<?, ?> map -> "a mapping";
            default -> "a list of " + elementList().size();
        };
    }

    /** Names for messages, with commas between them; of many, the first. */
    static String list(List<String> names) {
        return names.size() <= MAX_LISTED
                ? String.join(", ", names)
                : String.join(", ", names.subList(0, MAX_LISTED))
                        + " and "
                        + (names.size() - MAX_LISTED)
                        + " more";
    }

    /** The text or, of a long one, its beginning. */
    static String shorten(String text) {
        return text.length() <= 48 ? text : text.substring(0, 47) + "…";
    }

    @SuppressWarnings("unchecked") // by construction
    private LinkedHashMap<String, Node> fieldMap() {
        return (LinkedHashMap<String, Node>) Objects.requireNonNull(value);
    }

    @SuppressWarnings("unchecked") // by construction
    private ArrayList<Node> elementList() {
        return (ArrayList<Node>) Objects.requireNonNull(value);
    }
}
