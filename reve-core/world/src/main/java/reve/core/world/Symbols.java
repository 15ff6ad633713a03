// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.util.Collections;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.SortedSet;
import java.util.TreeSet;

/**
 * The symbolic data of all items of a world as one immutable map. An index finds items by their
 * symbols. The class also counts the items that each agent's actions created. For the world's
 * thread only.
 */
final class Symbols {

    private final ClassHierarchy classes;
    private final SymbolIndex bySymbol = new SymbolIndex();
    private PMap<ItemId, ItemSymbols> all = TreePMap.empty();

    /**
     * The {@link Likeness} of the last added item, which the next item shares if its own is equal.
     */
    private @Nullable Likeness latest;

    /** Ids of the items with an {@link Instrument.Imu}, in ascending order. */
    private final TreeSet<ItemId> withImu = new TreeSet<>();

    /** Ids of the items whose levels have conditions, in ascending order. */
    private final TreeSet<ItemId> withConditions = new TreeSet<>();

    private final SortedSet<ItemId> withConditionsView =
            Collections.unmodifiableSortedSet(withConditions);

    /** Ids of the items with an {@link Instrument.Provided}, in ascending order. */
    private final TreeSet<ItemId> withProvided = new TreeSet<>();

    /** Number of items that each agent's actions created; contains no entry for 0 items. */
    private final Map<String, Integer> made = new HashMap<>();

    private int madeInAll;

    /** See {@link SymbolBytes}. */
    private long bytes;

    /** The last measured symbols, which many items share, and their size. */
    private PMap<String, Object> measured = TreePMap.empty();

    private long measuredBytes;

    private long lastId;
    private long removals;

    Symbols(ClassHierarchy classes) {
        this.classes = classes;
    }

    /** Creates the symbolic data of a new item, with a new id. */
    ItemSymbols create(ItemDefinition definition, @Nullable String maker) {
        Likeness likeness = Likeness.of(definition);
        if (likeness.equals(latest)) {
            likeness = latest;
        }
        latest = likeness;
        return new ItemSymbols(new ItemId(++lastId), definition, likeness, maker, classes);
    }

    /** Returns the highest id that was ever assigned. */
    long lastId() {
        return lastId;
    }

    /** Returns the symbolic data of all items, in the order of their ids. */
    PMap<ItemId, ItemSymbols> all() {
        return all;
    }

    /** Returns the name of an item that is in the world. */
    String name(ItemId id) {
        return all.get(id).name();
    }

    /** Returns a copy of the ids of the items whose symbol has a value, in ascending order. */
    List<ItemId> with(String symbol, Object value) {
        return bySymbol.find(symbol, value, all.values());
    }

    /**
     * Returns a view of the ids of the items with an {@link Instrument.Imu}, in ascending order.
     */
    SortedSet<ItemId> withImu() {
        return Collections.unmodifiableSortedSet(withImu);
    }

    /** Returns a view of the ids of the items whose levels have conditions, in ascending order. */
    SortedSet<ItemId> withConditions() {
        return withConditionsView;
    }

    /**
     * Returns a view of the ids of the items with an {@link Instrument.Provided}, in ascending
     * order.
     */
    SortedSet<ItemId> withProvided() {
        return Collections.unmodifiableSortedSet(withProvided);
    }

    /** Returns the number of existing items that actions of this agent created. */
    int made(String agent) {
        return made.getOrDefault(agent, 0);
    }

    /** Returns the number of existing items that actions of all agents created. */
    int made() {
        return madeInAll;
    }

    /** Returns the size of the designer's symbols of all items, see {@link SymbolBytes}. */
    long bytes() {
        return bytes;
    }

    void add(ItemSymbols item) {
        bytes += size(item);
        all = all.plus(item.id(), item);
        bySymbol.add(item);
        count(item, 1);
        noteAspects(item);
    }

    /** Returns the number of removals so far, including those by restoring an image. */
    long removals() {
        return removals;
    }

    void remove(ItemSymbols item) {
        removals++;
        bytes -= size(item);
        all = all.minus(item.id());
        bySymbol.remove(item);
        count(item, -1);
        withImu.remove(item.id());
        withConditions.remove(item.id());
        withProvided.remove(item.id());
    }

    /** Replaces the symbolic data of one item. */
    void replace(ItemSymbols before, ItemSymbols after) {
        if (before.given() != after.given()) {
            bytes += size(after) - size(before);
        }
        bySymbol.remove(before);
        bySymbol.add(after);
        all = all.plus(after.id(), after);
    }

    /** Replaces all symbolic data by that of an image. */
    void restore(PMap<ItemId, ItemSymbols> other, long otherLastId) {
        removals++;
        bySymbol.clear();
        all = other;
        made.clear();
        madeInAll = 0;
        bytes = 0;
        withImu.clear();
        withConditions.clear();
        withProvided.clear();
        for (ItemSymbols item : all.values()) {
            count(item, 1);
            bytes += size(item);
            noteAspects(item);
        }
        lastId = otherLastId;
    }

    /**
     * Records an item with an instrument that the world computes, or with conditions of levels. The
     * sensors and levels of an item never change.
     */
    private void noteAspects(ItemSymbols item) {
        for (Sensor sensor : item.sensors()) {
            if (sensor.instrument().orElse(null) instanceof Instrument.Imu) {
                withImu.add(item.id());
            } else if (sensor.instrument().orElse(null) instanceof Instrument.Provided) {
                withProvided.add(item.id());
            }
        }
        if (item.levels().stream().anyMatch(level -> level.when().isPresent())) {
            withConditions.add(item.id());
        }
    }

    private long size(ItemSymbols item) {
        if (item.given() != measured) {
            measured = item.given();
            measuredBytes = SymbolSizes.of(measured);
        }
        return measuredBytes + classes.symbolBytes(item.itemClass());
    }

    private void count(ItemSymbols item, int more) {
        if (item.maker() != null) {
            madeInAll += more;
            made.merge(item.maker(), more, (known, _) -> known + more == 0 ? null : known + more);
        }
    }
}
