// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The positions (line and column) of items, constants and laws in a world file, for warnings that
 * can be found only after loading. All objects of this class are equal, so that the comparison of
 * world descriptions ignores positions. Immutable.
 */
public final class Places {
    /** The aspects in which each value has a position. */
    private static final List<String> ASPECTS = List.of("physical", "physics");

    private static final Places NONE = new Places("", List.of(), Map.of());

    private final String file;
    private final List<Place> items;
    private final Map<String, Place> constants;

    /**
     * The position of an item and of the values in its aspects. Repetitions of an item share one
     * object.
     *
     * @param keys names of the values, such as {@code physics.mass}; the other arrays have one
     *     element for each key
     */
    record Place(
            String file,
            int line,
            int column,
            String pointer,
            String[] keys,
            String[] files,
            int[] lines,
            int[] columns) {

        /** Returns the position of an item and of its values. */
        static Place of(Node node) {
            List<String> keys = new ArrayList<>();
            List<Node> values = new ArrayList<>();
            for (String aspect : ASPECTS) {
                for (Node value : node.get(aspect).map(Node::children).orElse(List.of())) {
                    if (!value.isElement()) {
                        keys.add(aspect + "." + value.key());
                        values.add(value);
                    }
                }
            }
            return new Place(
                    node.file(),
                    node.line(),
                    node.column(),
                    node.pointer(),
                    keys.toArray(String[]::new),
                    values.stream().map(Node::file).toArray(String[]::new),
                    values.stream().mapToInt(Node::keyLine).toArray(),
                    values.stream().mapToInt(Node::keyColumn).toArray());
        }

        Problem warning(String key, String message) {
            for (int i = 0; i < keys.length; i++) {
                if (keys[i].equals(key)) {
                    return Problems.warning(
                            files[i],
                            lines[i],
                            columns[i],
                            pointer + "/" + key.replace('.', '/'),
                            message);
                }
            }
            return Problems.warning(file, line, column, pointer, message);
        }
    }

    private Places(String file, List<Place> items, Map<String, Place> constants) {
        this.file = file;
        this.items = List.copyOf(items);
        this.constants = Map.copyOf(constants);
    }

    /** Returns empty positions, for a world that was not read from a file. */
    public static Places none() {
        return NONE;
    }

    /**
     * Returns the places in the text of a file at which items and constants are written.
     *
     * @param items the place in the text of each item of the description
     */
    static Places of(String file, List<Place> items, List<Node> constants) {
        Map<String, Place> byName = new HashMap<>();
        constants.forEach(node -> byName.put(node.key(), Place.of(node)));
        return new Places(file, items, byName);
    }

    /**
     * Returns a warning about an item.
     *
     * @param item index in {@link WorldDescription#items}
     * @param key name of a value, such as {@code physics.mass}; if the file does not contain the
     *     value, the warning has the position of the item
     */
    public Problem item(int item, String key, String message) {
        return item < items.size() ? items.get(item).warning(key, message) : world(message);
    }

    /**
     * Returns a warning about a constant. Its position is the start of the file if the file does
     * not set the constant.
     */
    public Problem constant(String name, String message) {
        return Optional.ofNullable(constants.get(name))
                .map(place -> place.warning("", message))
                .orElseGet(() -> world(message));
    }

    /** Returns a warning about the reference to a law. */
    public Problem law(LawReference law, String message) {
        String[] parts = law.place().split(":(?=[0-9]+(:[0-9]+)?$)", -1);
        return parts.length == 3
                ? Problems.warning(
                        parts[0],
                        Integer.parseInt(parts[1]),
                        Integer.parseInt(parts[2]),
                        "",
                        message)
                : world(message);
    }

    /** Returns a warning about the file as a whole. */
    public Problem world(String message) {
        return Problems.warning(file, 1, 1, "", message);
    }

    @Override
    public boolean equals(Object other) {
        return other instanceof Places;
    }

    @Override
    public int hashCode() {
        return 0;
    }
}
