// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;
import java.util.function.UnaryOperator;

/**
 * One of several physical descriptions of an item, for example a ball or a mesh of springs. Exactly
 * one level of an item is active. A LevelChange makes another level active. Immutable.
 *
 * @param name name of the level, unique among the levels of the item
 * @param isGroup true if the level consists of parts, which are items of their own; false if it is
 *     a description of the item itself
 * @param items for a group: the parts, with names, references and parents relative to the item, and
 *     places in the item's reference frame. Otherwise one definition, of which only shape,
 *     material, colour and physics count
 * @param when condition that makes the level active; empty if only edits and actions choose it
 */
public record Level(
        String name, boolean isGroup, List<ItemDefinition> items, Optional<LevelCondition> when) {

    /** Name of the symbol that contains the name of an item's active level. */
    public static final String SYMBOL = "level";

    private static final String SEPARATOR = ".";

    /**
     * Copies the list.
     *
     * @throws IllegalArgumentException naming the level if it has no mass, if a body among its
     *     parts has neither a mass nor a parent, or if it describes the item itself by several
     *     definitions
     */
    public Level {
        items = List.copyOf(items);
        if (!isGroup && items.size() != 1) {
            throw new IllegalArgumentException(
                    "level " + name + ": found " + items.size() + " descriptions, expected one");
        }
        for (ItemDefinition item : items) {
            boolean isBody = item.kind().equals(WorldPrototype.BODY);
            if (isBody && item.parent().isEmpty() && !(massOf(item) > 0)) {
                throw new IllegalArgumentException(
                        "level "
                                + name
                                + (isGroup ? ": its part " + item.name() : "")
                                + " has no mass; expected a mass above 0"
                                + (isGroup ? ", or a parent with which the part moves" : ""));
            }
        }
        if (items.stream().noneMatch(item -> massOf(item) > 0)) {
            throw new IllegalArgumentException(
                    "level " + name + " has no part with a mass; expected at least one");
        }
    }

    /** Returns the sum of the masses [kg]. */
    public double mass() {
        double sum = 0;
        for (ItemDefinition item : items) {
            sum += massOf(item);
        }
        return sum;
    }

    /**
     * Returns the first part with a mass. While a group is the active level, the item itself is
     * attached to this part.
     */
    public ItemDefinition carrier() {
        return items.stream().filter(item -> massOf(item) > 0).findFirst().orElseThrow();
    }

    /** Returns the beginning of the names of the parts of an item. */
    public static String prefix(String item) {
        return item + SEPARATOR;
    }

    /** Begins a copy of a part with full names, which begin with a prefix. */
    public static ItemDefinition.Builder full(String prefix, ItemDefinition part) {
        return renamed(part, prefix + part.name(), name -> prefix + name);
    }

    /** Returns a copy of a part whose names are relative to the item. */
    public static ItemDefinition relative(String prefix, ItemDefinition part) {
        return renamed(
                        part,
                        part.name().substring(prefix.length()),
                        name -> name.startsWith(prefix) ? name.substring(prefix.length()) : name)
                .build();
    }

    private static ItemDefinition.Builder renamed(
            ItemDefinition part, String name, UnaryOperator<String> other) {
        ItemDefinition.Builder copy = part.copy(name);
        part.references()
                .forEach(
                        (property, targets) ->
                                copy.reference(
                                        property,
                                        targets.stream().map(other).toArray(String[]::new)));
        part.parent().map(other).ifPresent(copy::parent);
        return copy;
    }

    static double massOf(ItemDefinition item) {
        return item.kind().equals(WorldPrototype.BODY)
                ? item.physics(WorldPrototype.MASS).map(mass -> mass[0]).orElse(0.0)
                : 0;
    }
}
