// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeSet;

/**
 * The arrest of items whose changed numbers may make physics laws fail. An arrest sets the numbers
 * of an item to 0, so that laws do not move the item. For the world's thread only.
 */
public final class Arrests {
    /** The properties of an item that laws read, by kind. An arrest sets them to 0. */
    private static final Map<String, List<String>> NUMBERS =
            Map.of(
                    WorldPrototype.BODY,
                            List.of(
                                    "mass",
                                    "velocity",
                                    "angularVelocity",
                                    "inertia",
                                    "charge",
                                    "radius",
                                    "dragCoefficient",
                                    "linearDragCoefficient"),
                    WorldPrototype.SPRING, List.of("springConstant", "dampingConstant"),
                    WorldPrototype.SURFACE,
                            List.of("hardness", "surfaceDamping", "frictionCoefficient"));

    /**
     * Magnitude above which a number is extreme, in the SI unit of its property. No body of a
     * working world has such numbers.
     */
    private static final double EXTREME = 1e15;

    private static final String POSITION = "position";

    private final Items items;
    private final WorldGuard guard;

    /** Items whose physics properties or place were changed by actions or edits. */
    private final TreeSet<ItemId> changed = new TreeSet<>();

    Arrests(Items items, WorldGuard guard) {
        this.items = items;
        this.guard = guard;
    }

    /** Records that an action or an edit changes the physics properties or the place of an item. */
    public void suspect(ItemId item) {
        guard.requireEditable();
        changed.add(item);
    }

    /**
     * Returns the items that may have caused a failure, in the order of their ids. These items meet
     * all three conditions:
     *
     * <ul>
     *   <li>they have a physics aspect
     *   <li>they are not arrested
     *   <li>actions or edits have changed their physics properties or place since the world was
     *       built or resumed
     * </ul>
     *
     * @param failed the item at which a law failed. If it has extreme numbers, it is added at the
     *     end, because changed items may have pushed it
     */
    public List<Item> suspects(Optional<Item> failed) {
        guard.checkOwner();
        if (changed.isEmpty()) {
            return List.of();
        }
        var suspects = new ArrayList<Item>();
        changed.removeIf(id -> items.find(id) == null);
        items.of(changed).stream().filter(item -> excess(item) > 0).forEach(suspects::add);
        failed.filter(item -> isExtreme(item) && !suspects.contains(item)).ifPresent(suspects::add);
        return suspects;
    }

    /** Returns whether an item has an extreme number, which no body of a working world has. */
    public boolean isExtreme(Item item) {
        return excess(item) > EXTREME;
    }

    /**
     * Returns the largest absolute value of the item's numbers that laws read. The inverse of the
     * mass is included. Coordinates are included only if they are extreme. Returns 0 if the item is
     * arrested and was not moved far away after its arrest.
     */
    public double excess(Item item) {
        double most = 0;
        if (item.physics().isEmpty()) {
            return most;
        }
        for (Column column : columns(item)) {
            for (int i = 0; i < column.components(); i++) {
                double value = Math.abs(column.getDouble(item.checkedRow(), i));
                most = Math.max(most, value);
                if (value > 0 && column.name().equals(WorldPrototype.MASS)) {
                    most = Math.max(most, 1 / value);
                }
            }
        }
        if (item.kind().equals(WorldPrototype.BODY)) {
            Column position = item.table().column(POSITION);
            for (int i = 0; i < position.components(); i++) {
                double value = Math.abs(position.getDouble(item.checkedRow(), i));
                most = Math.max(most, value > EXTREME ? value : 0);
            }
        }
        return most;
    }

    /**
     * Arrests an item with a physics aspect. The item is then at rest, immovable, and exerts no
     * force. Extreme coordinates become 0, because distances to them would not be finite. The
     * arrest is not recorded as a change, just as changes by laws are not recorded.
     *
     * @return undoes the arrest; may be called in the same frame only
     */
    public Runnable arrest(Item item) {
        guard.requireEditable();
        var before = new ArrayList<Runnable>();
        for (Column column : columns(item)) {
            before.add(replace(column, item.checkedRow(), 0));
        }
        if (item.kind().equals(WorldPrototype.BODY)) {
            before.add(replace(item.table().column(POSITION), item.checkedRow(), EXTREME));
        }
        return () -> before.forEach(Runnable::run);
    }

    /** Sets numbers with a magnitude above {@code largest} to 0. */
    private static Runnable replace(Column column, int row, double largest) {
        double[] before = new double[column.components()];
        double[] after = new double[before.length];
        for (int i = 0; i < before.length; i++) {
            before[i] = column.getDouble(row, i);
            after[i] = Math.abs(before[i]) > largest ? 0 : before[i];
        }
        column.write(row, after);
        return () -> column.write(row, before);
    }

    private static List<Column> columns(Item item) {
        return NUMBERS.getOrDefault(item.kind(), List.of()).stream()
                .map(item.table()::physicsColumn)
                .toList();
    }
}
