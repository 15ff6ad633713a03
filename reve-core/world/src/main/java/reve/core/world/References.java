// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Collection;
import java.util.HashSet;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Set;
import java.util.function.BiConsumer;

/**
 * Setter of the reference columns, such as {@code end1} of a spring. It also counts the references
 * to each item.
 */
final class References {

    private final List<Table> tables;
    private final Hierarchy hierarchy;

    /** Number of references to each item; contains no entry for 0 references. */
    private final IdMap referrers = new IdMap();

    References(List<Table> tables, Hierarchy hierarchy) {
        this.tables = tables;
        this.hierarchy = hierarchy;
    }

    /**
     * Checks that a reference property can refer to an item.
     *
     * @throws IllegalArgumentException if a reference property cannot refer to an item
     */
    static void requireTarget(
            String where,
            PropertyDescriptor property,
            String target,
            String kind,
            boolean hasPhysics) {
        String expected = property.refersTo().orElseThrow();
        if (!kind.equals(expected)) {
            throw new IllegalArgumentException(
                    where
                            + " refers to "
                            + target
                            + " of kind "
                            + kind
                            + ", expected kind "
                            + expected);
        }
        if (!hasPhysics) {
            throw new IllegalArgumentException(
                    where
                            + " refers to "
                            + target
                            + ", which is scenery: give it a physics property (mass 0 makes it"
                            + " immovable)");
        }
    }

    /** Returns whether references to an item exist. */
    boolean isReferredTo(ItemId item) {
        return referrers.get(item.value(), 0) > 0;
    }

    /** Sets a reference to a target that the caller has checked. */
    void set(Column column, int row, int component, ItemId target) {
        count(column.getReference(row, component), -1);
        column.setReference(row, component, target.value());
        count(target.value(), 1);
    }

    /**
     * Clears all references that an item has to others, because it is removed or loses its physics
     * aspect.
     */
    void release(Table table, ItemId item) {
        if (!table.hasPhysics(item)) {
            return;
        }
        for (Column column : table.references()) {
            for (int i = 0; i < column.components(); i++) {
                count(column.getReference(table.rowOf(item), i), -1);
            }
        }
    }

    /** Counts all references in the columns again. */
    void countAll() {
        referrers.clear();
        for (Table table : tables) {
            for (Column column : table.references()) {
                for (int row = 0; row < table.physicsRowCount(); row++) {
                    for (int i = 0; i < column.components(); i++) {
                        count(column.getReference(row, i), 1);
                    }
                }
            }
        }
    }

    /**
     * Returns the items that refer to an item or are attached to it. Equal worlds give the same
     * order.
     */
    Set<ItemId> referrers(ItemId item) {
        return holding(Set.of(item));
    }

    /**
     * Returns the items that refer to one of the items or are attached to one of them. Equal worlds
     * give the same order.
     */
    Set<ItemId> holding(Collection<ItemId> items) {
        Set<ItemId> referring = new LinkedHashSet<>();
        addReferrers(items, referring);
        return referring;
    }

    /**
     * Returns an item, followed by all items that refer to it or are attached to it, directly or
     * through other items. Equal worlds give the same order.
     */
    List<ItemId> withReferrers(ItemId item) {
        return closure(item, this::addReferrers);
    }

    /**
     * Returns the items that refer to an item, directly or through other items. Equal worlds give
     * the same order.
     */
    List<ItemId> referring(ItemId item) {
        List<ItemId> all = closure(item, this::addReferring);
        return all.subList(1, all.size());
    }

    /** Adds the items that refer to one of the targets or are attached to one of them. */
    private void addReferrers(Collection<ItemId> targets, Set<ItemId> into) {
        for (ItemId target : targets) {
            into.addAll(hierarchy.children(target));
        }
        addReferring(targets, into);
    }

    private void addReferring(Collection<ItemId> targets, Set<ItemId> into) {
        Set<Long> referredTo = new HashSet<>();
        targets.stream().filter(this::isReferredTo).map(ItemId::value).forEach(referredTo::add);
        if (referredTo.isEmpty()) {
            return;
        }
        for (Table table : tables) {
            for (Column column : table.references()) {
                for (int row = 0; row < table.physicsRowCount(); row++) {
                    for (int i = 0; i < column.components(); i++) {
                        if (referredTo.contains(column.getReference(row, i))) {
                            into.add(table.idAt(row));
                        }
                    }
                }
            }
        }
    }

    private static List<ItemId> closure(ItemId item, BiConsumer<Set<ItemId>, Set<ItemId>> add) {
        Set<ItemId> all = new LinkedHashSet<>(List.of(item));
        Set<ItemId> latest = all;
        while (!latest.isEmpty()) {
            Set<ItemId> next = new LinkedHashSet<>();
            add.accept(latest, next);
            next.removeAll(all);
            all.addAll(next);
            latest = next;
        }
        return List.copyOf(all);
    }

    private void count(long target, int change) {
        if (target == 0) {
            return; // the item has no references yet
        }
        int now = referrers.get(target, 0) + change;
        if (now == 0) {
            referrers.remove(target);
        } else {
            referrers.put(target, now);
        }
    }
}
