package reve.core.world;

import java.util.Collection;
import java.util.Collections;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.function.Function;
import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

/**
 * The items of a world by id, by name and by symbol, and all that is symbolic about them as one
 * immutable version. World's thread only.
 */
final class Register {

    private final Map<ItemId, Item> byId = new LinkedHashMap<>();
    private final Map<String, Item> byName = new HashMap<>();
    private final SymbolIndex bySymbol = new SymbolIndex();
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();
    private long lastId;

    /** An id that was never given out before. */
    ItemId nextId() {
        return new ItemId(++lastId);
    }

    long lastId() {
        return lastId;
    }

    @Nullable Item find(ItemId id) {
        return byId.get(id);
    }

    @Nullable Item find(String name) {
        return byName.get(name);
    }

    List<Item> withSymbol(String symbol, Object value) {
        return bySymbol.find(symbol, value, byId.values());
    }

    /** In the order of their ids, as they come and go. */
    Map<ItemId, Item> byId() {
        return Collections.unmodifiableMap(byId);
    }

    Collection<Item> items() {
        return byId().values();
    }

    PMap<ItemId, ItemSymbols> symbols() {
        return symbols;
    }

    void add(Item item) {
        byId.put(item.id(), item);
        byName.put(item.name(), item);
        symbols = symbols.plus(item.id(), item.symbols());
        bySymbol.follow(item, null, item.symbols());
    }

    void remove(Item item) {
        byId.remove(item.id());
        byName.remove(item.name());
        symbols = symbols.minus(item.id());
        bySymbol.follow(item, item.symbols(), null);
    }

    /** Changes what is symbolic about an item, its name included. */
    void setSymbols(Item item, ItemSymbols changed) {
        if (!changed.name().equals(item.name())) {
            byName.remove(item.name());
            byName.put(changed.name(), item);
        }
        bySymbol.follow(item, item.symbols(), changed);
        item.setSymbols(changed);
        symbols = symbols.plus(item.id(), changed);
    }

    /**
     * Takes over the items of an image; in no rows yet. Those of the same id and kind stay the same
     * objects, the others count as removed.
     *
     * @param tableOf the table of a kind
     */
    void restore(WorldImage image, Function<String, Table> tableOf) {
        byId.values().forEach(item -> item.row = Item.REMOVED);
        Map<ItemId, Item> restored = new LinkedHashMap<>();
        image.symbols().forEach((id, itemSymbols) -> {
            Item item = byId.get(id);
            if (item == null || !item.kind().equals(itemSymbols.kind())) {
                item = new Item(tableOf.apply(itemSymbols.kind()), itemSymbols);
            }
            item.setSymbols(itemSymbols);
            restored.put(id, item);
        });
        byId.clear();
        byId.putAll(restored);
        byName.clear();
        byId.values().forEach(item -> byName.put(item.name(), item));
        bySymbol.clear();
        symbols = image.symbols();
        lastId = image.lastId();
    }
}
