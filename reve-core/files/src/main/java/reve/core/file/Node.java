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
 * One value of a YAML file, and its position. An accessor for a type returns empty if the value has
 * another type. The schema check reports such a value once.
 */
final class Node {
    /** Maximum number of names that a message lists. */
    private static final int MAX_LISTED = 24;

    private final String file;
    private final @Nullable Node parent;
    private final Object key;
    private final int keyLine;
    private final int keyColumn;
    private final int line;
    private final int column;

    /** A map or list of nodes, String, Long, Double, Boolean, or null for an empty value. */
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

    /**
     * Creates the outermost value of a file.
     *
     * @param value in the form of {@link Slot#fill}
     */
    static Node root(String file, int line, int column, @Nullable Object value) {
        return new Node(file, null, "", line, column, line, column, value);
    }

    /**
     * Returns a node at this position with another value, which has the form of {@link Slot#fill}.
     */
    Node withValue(@Nullable Object other) {
        return new Node(file, parent, key, keyLine, keyColumn, line, column, other);
    }

    /**
     * Returns this value with its position, as the value of another mapping or list.
     *
     * @param owner the mapping or list, which does not change
     * @param otherKey a String for a mapping, an Integer for a list
     */
    Node as(Node owner, Object otherKey) {
        Node node = new Node(file, owner, otherKey, keyLine, keyColumn, line, column, value);
        node.textColumn = textColumn;
        return node;
    }

    /** Returns a node at this position with a list of numbers. */
    Node withNumbers(double[] numbers) {
        List<Node> elements = new ArrayList<>(numbers.length);
        Node list = withValue(elements);
        for (int i = 0; i < numbers.length; i++) {
            elements.add(new Node(file, list, i, line, column, line, column, numbers[i]));
        }
        return list;
    }

    /**
     * Returns this mapping completed with the values of a base, for example of a prefab. Mappings
     * under the same key are merged in the same way. Any other value of this mapping replaces the
     * value of the base. Every value keeps its position.
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

    /** Returns the number of values in this mapping and in its nested mappings. */
    int fieldCount() {
        int count = 0;
        for (Node field : children()) {
            count += field.isMapping() ? 1 + field.fieldCount() : 1;
        }
        return count;
    }

    /** Returns the number of values in this node, including all nested ones. */
    long valueCount() {
        long count = 1;
        for (Node child : children()) {
            count += child.valueCount();
        }
        return count;
    }

    /** Returns this mapping without one of its keys. */
    Node without(String name) {
        if (get(name).isEmpty()) {
            return this;
        }
        var fields = new LinkedHashMap<>(fieldMap());
        fields.remove(name);
        return withValue(fields);
    }

    /** The position of a key or list element whose value is not read yet. */
    record Slot(Node parent, Object key, int keyLine, int keyColumn) {
        /**
         * Creates the node of this key or element. Called as soon as the parser reaches the value.
         *
         * @param value a new LinkedHashMap or ArrayList for a mapping or list, otherwise the scalar
         *     value
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

    /**
     * Returns whether the file contains this value in the mapping of {@code owner} itself, and not
     * in a prefab of the owner.
     */
    boolean isWrittenIn(Node owner) {
        return parent != null && parent.parent == owner.parent && parent.key.equals(owner.key);
    }

    /**
     * Sets the column of the text's first character. It differs from the column of the value if the
     * value begins with a quote or on an earlier line.
     */
    void setTextColumn(int newTextColumn) {
        textColumn = newTextColumn;
    }

    /**
     * Returns the column of the text's first character; -1 if this character is on a later line
     * than the value.
     */
    int textColumn() {
        return textColumn;
    }

    /** Returns the name of the file that contains the value, for messages. */
    String file() {
        return file;
    }

    int line() {
        return line;
    }

    int column() {
        return column;
    }

    /** Returns the line of this value's key, or of the value if it has no key. */
    int keyLine() {
        return key instanceof String ? keyLine : line;
    }

    int keyColumn() {
        return key instanceof String ? keyColumn : column;
    }

    /** Returns the key in the mapping, or the index in the list, from 0. */
    String key() {
        return key.toString();
    }

    /**
     * Returns a name of this value for messages, such as {@code mass} or {@code laws[2]}; empty for
     * the root.
     */
    String label() {
        return parent == null || key instanceof String
                ? shorten(key())
                : parent.label() + "[" + key + "]";
    }

    /** Returns the JSON pointer from the root to this value. */
    String pointer() {
        return parent == null
                ? ""
                : parent.pointer() + "/" + key().replace("~", "~0").replace("/", "~1");
    }

    /** Returns whether this value is an element of a list, without a key. */
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

    /** Returns the value under a key; empty if this value is no mapping or has no such key. */
    Optional<Node> get(String name) {
        return isMapping() ? Optional.ofNullable(fieldMap().get(name)) : Optional.empty();
    }

    /** Returns the value at an index of a list, from 0. */
    Optional<Node> get(int index) {
        return isList() && index >= 0 && index < elementList().size()
                ? Optional.of(elementList().get(index))
                : Optional.empty();
    }

    /** Returns the values of a mapping or list, in the order of the file. */
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

    /** Returns a String, Long, Double or Boolean; empty for mappings, lists and empty values. */
    Optional<Object> scalar() {
        return isMapping() || isList() ? Optional.empty() : Optional.ofNullable(value);
    }

    /** Returns a description of this value for messages: {@code number 3}, {@code a list}. */
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

    /** Joins at most the first {@link #MAX_LISTED} names by commas, for messages. */
    static String list(List<String> names) {
        return names.size() <= MAX_LISTED
                ? String.join(", ", names)
                : String.join(", ", names.subList(0, MAX_LISTED))
                        + " and "
                        + (names.size() - MAX_LISTED)
                        + " more";
    }

    /** Returns the text, shortened if it is long. */
    static String shorten(String text) {
        return text.length() <= 48 ? text : text.substring(0, 47) + "…";
    }

    @SuppressWarnings("unchecked") // the value of a mapping always has this type
    private LinkedHashMap<String, Node> fieldMap() {
        return (LinkedHashMap<String, Node>) Objects.requireNonNull(value);
    }

    @SuppressWarnings("unchecked") // the value of a list always has this type
    private ArrayList<Node> elementList() {
        return (ArrayList<Node>) Objects.requireNonNull(value);
    }
}
