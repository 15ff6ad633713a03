// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Replacement of values of a world file. A path names each value. It consists of the keys that lead
 * to the value, joined by dots. The step to an element of a list is the element's {@code name}, or
 * the element itself if it is a text.
 *
 * <p>A replaced value keeps the position of the replacement in its file, so problems are reported
 * at this position.
 */
final class Overrides {
    private static final String SEPARATOR = ".";
    private static final String INCLUDE = "include";

    private final Problems problems;
    private final List<Node> parts;
    private final int root;

    private Overrides(WorldSource source, Problems problems) {
        this.problems = problems;
        this.parts = new ArrayList<>(source.parts());
        this.root = parts.indexOf(source.world());
    }

    /**
     * Returns the world file with replaced values, after the schema check.
     *
     * @param sets mappings from paths to values; later ones replace earlier ones
     * @param files resolves the files that the world names
     * @param seed seed of the world's random numbers
     */
    static WorldSource apply(
            WorldSource source, List<Node> sets, SourceFiles files, long seed, Problems problems)
            throws WorldFileException {
        var overrides = new Overrides(source, problems);
        for (Node set : sets) {
            set.children().forEach(overrides::apply);
        }
        problems.throwIfAny();
        for (int i = 0; i < overrides.parts.size(); i++) {
            Node part = overrides.parts.get(i);
            if (part != source.parts().get(i)) {
                if (i == overrides.root) {
                    SchemaCheck.check(part, problems.of(part.file()));
                } else {
                    SchemaCheck.checkPart(part, problems.of(part.file()));
                }
            }
        }
        return new WorldSource(
                overrides.parts.get(overrides.root), List.copyOf(overrides.parts), files, seed);
    }

    private void apply(Node value) {
        String path = value.key();
        if (path.equals(INCLUDE) || path.startsWith(INCLUDE + SEPARATOR)) {
            problems.addAtKey(value, "`include` names files that are read once, for all runs");
            return;
        }
        int chosen = root;
        int deepest = -1;
        for (int i = 0; i < parts.size(); i++) {
            int depth = depth(parts.get(i), path);
            if (depth > deepest || depth == deepest && i == root) {
                deepest = depth;
                chosen = i;
            }
        }
        parts.set(chosen, set(parts.get(chosen), path, value));
    }

    /** Returns the number of steps of the path that exist below the node. */
    private static int depth(Node node, String path) {
        Optional<Step> step = step(node, path);
        return step.isEmpty() || step.get().rest.isEmpty()
                ? (step.isEmpty() ? 0 : 1)
                : 1 + depth(step.get().child, step.get().rest);
    }

    /**
     * The first step of a path.
     *
     * @param key key of the child, or its index in a list
     * @param rest path that begins at the child; empty if the path ends there
     */
    private record Step(Object key, Node child, String rest) {}

    /**
     * Returns the step to a child. The path may begin with the names of several children, because
     * names may contain dots. The longest of these names is used.
     */
    private static Optional<Step> step(Node node, String path) {
        Step longest = null;
        int length = -1;
        int index = 0;
        for (Node child : node.children()) {
            Optional<String> name = node.isMapping() ? Optional.of(child.key()) : nameOf(child);
            if (name.isPresent() && name.get().length() > length && begins(path, name.get())) {
                length = name.get().length();
                longest =
                        new Step(
                                node.isMapping() ? child.key() : index,
                                child,
                                path.length() == length ? "" : path.substring(length + 1));
            }
            index++;
        }
        return Optional.ofNullable(longest);
    }

    private static boolean begins(String path, String name) {
        return path.equals(name) || path.startsWith(name + SEPARATOR);
    }

    /** Returns the name by which a path refers to an element of a list. */
    private static Optional<String> nameOf(Node element) {
        return element.isMapping()
                ? element.get("name")
                        .flatMap(Node::text)
                        .or(
                                () ->
                                        element.get("text")
                                                .flatMap(Node::text)
                                                .map(WorldReader::nameInText))
                : element.text();
    }

    private Node set(Node node, String path, Node value) {
        Optional<Step> step = step(node, path);
        if (node.isList()) {
            return step.isPresent() ? inList(node, step.get(), value) : unknown(node, path, value);
        }
        if (node.text().isPresent() && node.isElement()) {
            return set(named(node), path, value);
        }
        if (!node.isMapping()) {
            problems.addAtKey(
                    value,
                    "`"
                            + Node.shorten(value.key())
                            + "`: `"
                            + node.label()
                            + "` is "
                            + node.describe()
                            + " in the world file, which has no keys");
            return node;
        }
        Map<String, Node> fields = new LinkedHashMap<>();
        node.children().forEach(child -> fields.put(child.key(), child));
        if (step.isPresent()) {
            String key = (String) step.get().key;
            fields.put(key, replaced(node, key, step.get(), value));
        } else {
            int end = path.indexOf(SEPARATOR);
            String key = end < 0 ? path : path.substring(0, end);
            Node owner = value.as(node, key);
            fields.put(
                    key,
                    end < 0
                            ? owner
                            : set(
                                    owner.withValue(new LinkedHashMap<String, Node>()),
                                    path.substring(end + 1),
                                    value));
        }
        return node.withValue(fields);
    }

    private Node replaced(Node owner, Object key, Step step, Node value) {
        return step.rest.isEmpty() ? value.as(owner, key) : set(step.child, step.rest, value);
    }

    private Node inList(Node list, Step step, Node value) {
        List<Node> elements = new ArrayList<>(list.children());
        elements.set((Integer) step.key, replaced(list, step.key, step, value));
        return list.withValue(elements);
    }

    /**
     * Converts an element of a list that is only a name into a mapping with this name, so that
     * values can be added to it.
     */
    private static Node named(Node element) {
        Map<String, Node> fields = new LinkedHashMap<>();
        Node mapping = element.withValue(fields);
        fields.put("name", element.as(mapping, "name"));
        return mapping;
    }

    private Node unknown(Node list, String path, Node value) {
        List<String> names = new ArrayList<>();
        for (Node part : parts) {
            part.get(list.key())
                    .ifPresent(
                            same ->
                                    same.children()
                                            .forEach(
                                                    element ->
                                                            nameOf(element).ifPresent(names::add)));
        }
        int end = path.indexOf(SEPARATOR);
        String wanted = end < 0 ? path : path.substring(0, end);
        problems.addAtKey(
                value,
                "`"
                        + Node.shorten(value.key())
                        + "`: "
                        + list.label()
                        + " of the world file contain no `"
                        + Node.shorten(wanted)
                        + "`"
                        + problems.suggestion(wanted, names));
        return list;
    }
}
