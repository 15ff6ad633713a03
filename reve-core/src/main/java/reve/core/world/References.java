// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Collection;
import java.util.HashSet;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Set;
import java.util.function.BiConsumer;

/** Columns of references between items, and how many point at each. World's thread only. */
final class References {

    private static final int NAMED_IN_MESSAGES = 5;

    private final List<Table> tables;
    private final Register register;

    References(List<Table> tables, Register register) {
        this.tables = tables;
        this.register = register;
    }

    /** Points an added item, checked before, at those that its definition names. */
    void resolve(Item item, ItemDefinition definition) {
        if (!definition.hasReferences()) {
            return;
        }
        World world = item.world();
        definition
                .references()
                .forEach(
                        (property, names) -> {
                            Column column = item.table().physicsColumn(property);
                            for (int i = 0; i < names.size(); i++) {
                                point(item, column, i, world.find(names.get(i)).orElseThrow());
                            }
                        });
    }

    /**
     * @throws IllegalArgumentException naming item and property if a target does not fit
     */
    void set(Item item, Column column, List<Item> targets) {
        String where = item + ": " + column.name();
        if (column.type() != ScalarType.REF || targets.size() != column.components()) {
            throw new IllegalArgumentException(
                    where
                            + " takes "
                            + column.components()
                            + " "
                            + column.type()
                            + ", found "
                            + targets.size()
                            + " references");
        }
        for (Item target : targets) {
            DefinitionCheck.requireTarget(
                    where,
                    column.descriptor(),
                    target.name(),
                    target.kind(),
                    !target.physics().isEmpty());
        }
        for (int i = 0; i < targets.size(); i++) {
            count(column.getReference(item.row, i), -1);
            point(item, column, i, targets.get(i));
        }
    }

    /** An item refers to nothing any more, as it goes. */
    void release(Item item) {
        if (item.physics().isEmpty()) {
            return;
        }
        for (Column column : item.table().references()) {
            for (int i = 0; i < column.components(); i++) {
                count(column.getReference(item.row, i), -1);
            }
        }
    }

    /** Counts anew how many references point at each item. */
    void countAll() {
        register.items().forEach(item -> item.referrers = 0);
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

    /** Adds those that refer to any of the targets or are attached to one. */
    private void addReferrers(Collection<Item> targets, Set<Item> into) {
        for (Item target : targets) {
            into.addAll(target.children());
        }
        addReferring(targets, into);
    }

    private void addReferring(Collection<Item> targets, Set<Item> into) {
        Set<Item> referredTo = new HashSet<>();
        targets.stream().filter(target -> target.referrers > 0).forEach(referredTo::add);
        if (referredTo.isEmpty()) {
            return;
        }
        for (Table table : tables) {
            for (Column column : table.references()) {
                for (int row = 0; row < table.physicsRowCount(); row++) {
                    for (int i = 0; i < column.components(); i++) {
                        var target = new ItemId(column.getReference(row, i));
                        if (referredTo.contains(register.find(target))) {
                            into.add(table.itemAt(row));
                        }
                    }
                }
            }
        }
    }

    /**
     * An item, then all that refer to it or are attached to it, directly or not; in an order that
     * equal worlds share.
     */
    List<Item> withReferrers(Item item) {
        return closure(item, this::addReferrers);
    }

    /** All that refer to an item, directly or not, in the order of {@link #withReferrers}. */
    List<Item> referring(Item item) {
        List<Item> all = closure(item, this::addReferring);
        return all.subList(1, all.size());
    }

    private static List<Item> closure(Item item, BiConsumer<Set<Item>, Set<Item>> add) {
        Set<Item> all = new LinkedHashSet<>(List.of(item));
        Set<Item> latest = all;
        while (!latest.isEmpty()) {
            Set<Item> next = new LinkedHashSet<>();
            add.accept(latest, next);
            next.removeAll(all);
            all.addAll(next);
            latest = next;
        }
        return List.copyOf(all);
    }

    /** Who refers to an item or is attached to it, for messages. */
    String describeReferrers(Item item) {
        Set<Item> referring = new LinkedHashSet<>();
        addReferrers(Set.of(item), referring);
        return String.join(
                        ", ",
                        referring.stream().map(Item::toString).limit(NAMED_IN_MESSAGES).toList())
                + (referring.size() > NAMED_IN_MESSAGES ? ", ..." : "");
    }

    private void point(Item item, Column column, int component, Item target) {
        column.setReference(item.row, component, target.id().value());
        target.referrers++;
    }

    private void count(long target, int change) {
        Item item = register.find(new ItemId(target));
        if (item != null) {
            item.referrers += change;
        }
    }
}
