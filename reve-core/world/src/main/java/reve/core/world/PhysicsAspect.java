// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * The physics properties of an item, as a view of its row. Laws use these properties. An item with
 * an empty physics aspect is scenery, which laws cannot move. For the world's thread only.
 */
public final class PhysicsAspect {

    private final Item item;

    PhysicsAspect(Item item) {
        this.item = item;
    }

    /** Returns whether the item is scenery, which laws do not use. */
    public boolean isEmpty() {
        return item.checkedRow() >= item.table().physicsRowCount();
    }

    /**
     * Returns the names of all physics properties of the item's kind in a fixed order. Returns none
     * if the aspect is empty.
     */
    public Set<String> properties() {
        var names = new LinkedHashSet<String>();
        if (!isEmpty()) {
            for (PropertyDescriptor property : item.world().prototype.properties()) {
                if (property.kind().equals(item.kind())) {
                    names.add(property.name());
                }
            }
        }
        return names;
    }

    /**
     * Returns the value of a numeric property with one component, in its unit.
     *
     * @throws IllegalArgumentException if the kind has no such property or the property has more
     *     components
     * @throws IllegalStateException if the aspect is empty
     */
    public double scalar(String property) {
        Column column = existing(property);
        if (column.components() != 1) {
            throw new IllegalArgumentException(
                    item
                            + ": "
                            + property
                            + " has "
                            + column.components()
                            + " components: ask for the vector");
        }
        return column.getDouble(item.checkedRow(), 0);
    }

    /**
     * Returns all components of a numeric property, in its unit. Throws the same exceptions as
     * {@link #scalar}.
     */
    public double[] vector(String property) {
        Column column = existing(property);
        int row = item.checkedRow();
        double[] values = new double[column.components()];
        for (int i = 0; i < values.length; i++) {
            values[i] = column.getDouble(row, i);
        }
        return values;
    }

    /**
     * Returns the name of the body's substance; empty if it has none. The name is that of the item
     * of the kind {@link WorldPrototype#SUBSTANCE_PAIR} with the values of the substance, without
     * {@link WorldPrototype#SUBSTANCE_PREFIX}.
     */
    public Optional<String> substance() {
        if (isEmpty()
                || !item.kind().equals(WorldPrototype.BODY)
                || !item.world().prototype.hasSubstances()) {
            return Optional.empty();
        }
        int code = (int) scalar(WorldPrototype.SUBSTANCE);
        Table rows = item.world().table(WorldPrototype.SUBSTANCE_PAIR);
        Column codes = rows.column("substances");
        for (int row = 0; code != 0 && row < rows.rowCount(); row++) {
            if (codes.getInt(row, 0) == 0 && codes.getInt(row, 1) == code) {
                String name = item.world().symbols.name(rows.idAt(row));
                return Optional.of(
                        name.startsWith(WorldPrototype.SUBSTANCE_PREFIX)
                                ? name.substring(WorldPrototype.SUBSTANCE_PREFIX.length())
                                : name);
            }
        }
        return Optional.empty();
    }

    /**
     * Sets a numeric property. An item whose aspect was empty changes from scenery into an item
     * with a physics aspect, and its row moves. The phases PHYSICS, DERIVE and PUBLISH of a frame
     * refuse such a move.
     *
     * @throws IllegalArgumentException naming item, property and value if the property is unknown,
     *     components are missing, or a number is not finite or does not fit its type
     */
    public void set(String property, double... values) {
        Column column = column(property);
        Values.requireFits(item.name(), column.descriptor(), values);
        Attachment attachment = item.symbols().attachment();
        if (attachment != null && property.equals(WorldPrototype.MASS)) {
            String parent = item.world().symbols.name(attachment.parent());
            Hierarchy.requireNoMass(item + " is attached to " + parent + ": ", values[0]);
        }
        boolean first = isEmpty();
        if (first) {
            item.world().giveFirstPhysics(item.symbols());
        }
        List<Double> from = first ? null : numbers(column);
        write(property, values);
        note(property, from, numbers(column));
    }

    /**
     * Clears the aspect. The item becomes scenery, which laws do not move, and its row moves. The
     * phases PHYSICS, DERIVE and PUBLISH of a frame refuse such a move.
     *
     * @throws IllegalArgumentException naming the items that refer to this item, or if this is the
     *     item {@code world}
     */
    public void clear() {
        if (isEmpty()) {
            return;
        }
        Map<String, Object> before = new LinkedHashMap<>();
        for (String property : properties()) {
            Column column = column(property);
            before.put(
                    property,
                    column.type() == ScalarType.REF ? references(property) : numbers(column));
        }
        item.world().takePhysics(item.symbols());
        before.forEach((property, from) -> note(property, from, null));
    }

    /**
     * Sets a numeric property of an item with a physics aspect, without checks and without
     * recording the change.
     */
    void write(String property, double... values) {
        Column column = column(property);
        int row = item.checkedRow();
        for (int i = 0; i < values.length; i++) {
            column.write(row, i, values[i]);
        }
    }

    /**
     * Returns the item to which a property with one reference refers. Throws the same exceptions as
     * {@link #scalar}.
     */
    public ItemId reference(String property) {
        List<ItemId> all = references(property);
        if (all.size() != 1) {
            throw new IllegalArgumentException(
                    item
                            + ": "
                            + property
                            + " refers to "
                            + all.size()
                            + " items: ask for the references");
        }
        return all.getFirst();
    }

    /**
     * Returns the items to which a reference property refers, in order. Throws the same exceptions
     * as {@link #scalar}.
     */
    public List<ItemId> references(String property) {
        Column column = existing(property);
        int row = item.checkedRow();
        var ids = new ArrayList<ItemId>(column.components());
        for (int i = 0; i < column.components(); i++) {
            ids.add(new ItemId(column.getReference(row, i)));
        }
        return ids;
    }

    /**
     * Sets the items to which a reference property refers. The phases PHYSICS, DERIVE and PUBLISH
     * of a frame refuse this change.
     *
     * @throws IllegalArgumentException naming item and property if a target does not exist, is of
     *     the wrong kind or has no physics aspect
     */
    public void setReferences(String property, ItemId... targets) {
        List<ItemId> from = references(property);
        item.world().setReferences(item.symbols(), existing(property), List.of(targets));
        note(property, from, List.of(targets));
    }

    private List<Double> numbers(Column column) {
        int row = item.checkedRow();
        List<Double> numbers = new ArrayList<>(column.components());
        for (int i = 0; i < column.components(); i++) {
            numbers.add(column.getDouble(row, i));
        }
        return List.copyOf(numbers);
    }

    private void note(String property, @Nullable Object from, @Nullable Object to) {
        item.world()
                .note(
                        new WorldChange.Edited(
                                item.id(), WorldChange.Aspect.PHYSICS, property, from, to));
    }

    private Column existing(String property) {
        Column column = column(property);
        if (isEmpty()) {
            throw new IllegalStateException(
                    item + " is scenery: its physics aspect is empty, so it has no " + property);
        }
        return column;
    }

    private Column column(String property) {
        item.checkedRow();
        return item.table().physicsColumn(property);
    }
}
