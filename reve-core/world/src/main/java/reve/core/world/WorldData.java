// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * The data of a world by item id: columns, symbols, attachments, references, and the record of the
 * frame's changes. The aspects of an {@link Item} change the item's data through this class. For
 * the world's thread only.
 */
final class WorldData {

    private static final int NAMED_IN_MESSAGES = 5;

    final String name;
    final WorldPrototype prototype;
    final WorldGuard guard;
    final FrameRecord record = new FrameRecord();
    final Activity activity = new Activity();
    final ProviderFaults providerFaults;
    final Layout layout;
    final List<Table> tables;
    final Symbols symbols;
    final Hierarchy hierarchy;
    final References references;
    final Space space;
    final Relations relations;
    private final Map<String, Table> tableByKind = new HashMap<>();

    /** Number of simulated frames so far. */
    long age;

    /** Numbers that the providers of sensors measured in this frame, by item and sensor. */
    Map<ItemId, Map<String, double[]>> readings = Map.of();

    private long boundsVersion;

    WorldData(String name, WorldPrototype prototype, ColumnArena arena) {
        this.name = name;
        this.prototype = prototype;
        guard = new WorldGuard(name);
        providerFaults = new ProviderFaults(name, guard, record);
        symbols = new Symbols(prototype.classes());
        layout = new Layout(arena);
        tables =
                prototype.kinds().stream()
                        .map(kind -> new Table(kind, prototype, layout, guard, record))
                        .toList();
        tables.forEach(table -> tableByKind.put(table.kind(), table));
        Table bodies = table(WorldPrototype.BODY);
        hierarchy = new Hierarchy(bodies, layout, activity);
        references = new References(tables, hierarchy);
        space =
                new Space(
                        bodies.ids(),
                        bodies.column("boundsMin"),
                        bodies.column("boundsMax"),
                        () -> {
                            guard.checkOwner();
                            return boundsVersion;
                        },
                        symbols::removals,
                        id -> bodies.rowOf(id) >= 0);
        relations = new Relations(bodies, space, symbols::name);
    }

    /**
     * Returns the table of a kind.
     *
     * @throws IllegalArgumentException if the prototype has no such kind
     */
    Table table(String kind) {
        Table table = tableByKind.get(kind);
        if (table == null) {
            throw new IllegalArgumentException(
                    "kind \"" + kind + "\" does not exist; kinds are " + prototype.kinds());
        }
        return table;
    }

    /**
     * Returns the symbolic data of an item.
     *
     * @throws IllegalArgumentException if the item is not in the world
     */
    ItemSymbols require(ItemId id) {
        ItemSymbols symbolsOf = symbols.all().get(id);
        if (symbolsOf == null) {
            throw new IllegalArgumentException("world " + name + " has no item " + id);
        }
        return symbolsOf;
    }

    /** Makes spatial searches use the bounding boxes that have just been computed. */
    void boundsChanged() {
        boundsVersion++;
    }

    void note(WorldChange change) {
        record.note(change);
    }

    void setSymbols(ItemSymbols before, ItemSymbols after) {
        guard.requireEditable();
        symbols.replace(before, after);
    }

    void giveFirstPhysics(ItemSymbols item) {
        guard.requireUnlocked("give " + item.label() + " its first physics property");
        Table table = table(item.kind());
        List<Column> needed = table.references();
        if (!needed.isEmpty()) {
            throw new IllegalArgumentException(
                    item.label()
                            + " is scenery without "
                            + needed.getFirst().name()
                            + ": add it with its references instead");
        }
        table.promote(item.id());
    }

    void takePhysics(ItemSymbols item) {
        guard.requireUnlocked("take " + item.label() + " out of physics");
        requireNotConstants(item, "laws need them");
        if (references.isReferredTo(item.id())) {
            throw new IllegalArgumentException(
                    item.label()
                            + " cannot become scenery: "
                            + describeReferrers(item.id())
                            + " refers to it");
        }
        Table table = table(item.kind());
        references.release(table, item.id());
        table.demote(item.id());
    }

    /**
     * Sets the references of an item.
     *
     * @throws IllegalArgumentException naming item and property if a target is not allowed
     */
    void setReferences(ItemSymbols item, Column column, List<ItemId> targets) {
        guard.requireUnlocked("change " + column.name() + " of " + item.label());
        String where = item.label() + ": " + column.name();
        List<ItemSymbols> found = targets.stream().map(this::require).toList();
        if (column.type() != ScalarType.REF || found.size() != column.components()) {
            throw new IllegalArgumentException(
                    where
                            + " takes "
                            + column.components()
                            + " "
                            + column.type()
                            + ", found "
                            + found.size()
                            + " references");
        }
        for (ItemSymbols target : found) {
            References.requireTarget(
                    where,
                    column.descriptor(),
                    target.name(),
                    target.kind(),
                    table(target.kind()).hasPhysics(target.id()));
        }
        int row = table(item.kind()).rowOf(item.id());
        for (int i = 0; i < targets.size(); i++) {
            references.set(column, row, i, targets.get(i));
        }
    }

    /** Returns the items that refer to an item or are attached to it, for messages. */
    String describeReferrers(ItemId item) {
        Set<ItemId> referring = references.referrers(item);
        List<String> named = new ArrayList<>();
        referring.stream().limit(NAMED_IN_MESSAGES).forEach(id -> named.add(require(id).label()));
        return String.join(", ", named) + (referring.size() > NAMED_IN_MESSAGES ? ", ..." : "");
    }

    static void requireNotConstants(ItemSymbols item, String therefore) {
        if (item.kind().equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException(
                    item.label() + " holds the world's constants; " + therefore);
        }
    }
}
