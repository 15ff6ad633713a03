// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.util.ArrayList;
import java.util.Collections;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.function.Function;

/**
 * The items of a world by id, by name and by symbol, and all that is symbolic about them as one
 * immutable version. World's thread only.
 */
final class Register {

    private final ItemIndex<ItemId> byId = new ItemIndex<>(Item::id);
    private final ItemIndex<String> byName = new ItemIndex<>(Item::name);
    private final SymbolIndex bySymbol = new SymbolIndex();
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();

    /** Of the item that came last: the next one is often like it. */
    private @Nullable Likeness latest;

    /** How many items of each agent's making there are; no agent has 0. */
    private final Map<String, Integer> made = new HashMap<>();

    private int madeInAll;
    private long lastId;

    /** What is symbolic about a new item, under an id that was never given out before. */
    ItemSymbols symbolsOf(ItemDefinition definition, @Nullable String maker) {
        Likeness likeness = Likeness.of(definition);
        if (likeness.equals(latest)) {
            likeness = latest;
        }
        latest = likeness;
        return new ItemSymbols(new ItemId(++lastId), definition, likeness, maker);
    }

    long lastId() {
        return lastId;
    }

    @Nullable Item find(ItemId id) {
        return byId.find(id);
    }

    @Nullable Item find(String name) {
        return byName.find(name);
    }

    List<Item> withSymbol(String symbol, Object value) {
        return bySymbol.find(symbol, value, this::items);
    }

    /** In the order of their ids; a copy. */
    List<Item> items() {
        List<Item> items = new ArrayList<>(symbols.size());
        for (ItemId id : symbols.keySet()) {
            items.add(Objects.requireNonNull(byId.find(id)));
        }
        return Collections.unmodifiableList(items);
    }

    PMap<ItemId, ItemSymbols> symbols() {
        return symbols;
    }

    /** Takes in items, whose ids are the highest, in their order. */
    void addAll(List<Item> items) {
        byId.makeRoom(items.size());
        byName.makeRoom(items.size());
        for (Item item : items) {
            byId.add(item);
            byName.add(item);
            symbols = symbols.plus(item.id(), item.symbols());
            bySymbol.follow(item, null, item.symbols());
            count(item.symbols(), 1);
        }
    }

    private void count(ItemSymbols item, int more) {
        if (item.maker() != null) {
            madeInAll += more;
            made.merge(item.maker(), more, (known, _) -> known + more == 0 ? null : known + more);
        }
    }

    /** How many items there are that actions of an agent created. */
    int made(String agent) {
        return made.getOrDefault(agent, 0);
    }

    /** How many there are that actions of agents created. */
    int made() {
        return madeInAll;
    }

    void remove(Item item) {
        byId.remove(item);
        byName.remove(item);
        symbols = symbols.minus(item.id());
        bySymbol.follow(item, item.symbols(), null);
        count(item.symbols(), -1);
    }

    /** Changes what is symbolic about an item, its name included. */
    void setSymbols(Item item, ItemSymbols changed) {
        bySymbol.follow(item, item.symbols(), changed);
        if (changed.name().equals(item.name())) {
            item.setSymbols(changed);
        } else {
            byName.remove(item);
            item.setSymbols(changed);
            byName.add(item);
        }
        symbols = symbols.plus(item.id(), changed);
    }

    /**
     * Takes over the items of an image; in no rows yet. Those of the same id and kind stay the same
     * objects, the others count as removed.
     *
     * @param tableOf the table of a kind
     */
    void restore(WorldImage image, Function<String, Table> tableOf) {
        items().forEach(item -> item.row = Item.REMOVED);
        List<Item> restored = new ArrayList<>(image.symbols().size());
        image.symbols()
                .forEach(
                        (id, itemSymbols) -> {
                            Item item = byId.find(id);
                            if (item == null || !item.kind().equals(itemSymbols.kind())) {
                                item = new Item(tableOf.apply(itemSymbols.kind()), itemSymbols);
                            }
                            item.setSymbols(itemSymbols);
                            restored.add(item);
                        });
        byId.clear();
        byName.clear();
        restored.forEach(byId::add);
        restored.forEach(byName::add);
        bySymbol.clear();
        symbols = image.symbols();
        made.clear();
        madeInAll = 0;
        symbols.values().forEach(item -> count(item, 1));
        lastId = image.lastId();
    }
}
