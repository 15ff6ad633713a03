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

    /** Other values of items that have a position. */
    private static final List<String> KEYS = List.of("sensors", "voice");

    private static final Places NONE = new Places("", List.of(), Map.of(), Optional.empty());

    private final String file;
    private final List<Place> items;
    private final Map<String, Place> constants;
    private final Optional<Place> template;

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
            for (String key : KEYS) {
                node.get(key).ifPresent(values::add);
                node.get(key).ifPresent(_ -> keys.add(key));
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

    private Places(
            String file,
            List<Place> items,
            Map<String, Place> constants,
            Optional<Place> template) {
        this.file = file;
        this.items = List.copyOf(items);
        this.constants = Map.copyOf(constants);
        this.template = template;
    }

    /** Returns empty positions, for a world that was not read from a file. */
    public static Places none() {
        return NONE;
    }

    /**
     * Returns the positions of items and constants in the text of a file.
     *
     * @param items the positions of the items of the description, in the same order
     * @param template the template of agents' bodies, if there is one
     */
    static Places of(
            String file, List<Place> items, List<Node> constants, Optional<Node> template) {
        Map<String, Place> byName = new HashMap<>();
        constants.forEach(node -> byName.put(node.key(), Place.of(node)));
        return new Places(file, items, byName, template.map(Place::of));
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
     * Returns a warning about the template of agents' bodies.
     *
     * @param key name of a value, as in {@link #item}
     */
    public Problem template(String key, String message) {
        return template.map(place -> place.warning(key, message)).orElseGet(() -> world(message));
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
