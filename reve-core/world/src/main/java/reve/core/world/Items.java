// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.Collection;
import java.util.Collections;
import java.util.List;
import java.util.Objects;
import java.util.function.Function;

/** The items of a world by id and by name. For the world's thread only. */
final class Items {

    private final ItemIndex<ItemId> byId = new ItemIndex<>(Item::id);
    private final ItemIndex<String> byName = new ItemIndex<>(Item::name);

    @Nullable Item find(ItemId id) {
        return byId.find(id);
    }

    @Nullable Item find(String name) {
        return byName.find(name);
    }

    /** Returns the items with these ids, in the same order. All of them must be in the world. */
    List<Item> of(Collection<ItemId> ids) {
        List<Item> items = new ArrayList<>(ids.size());
        for (ItemId id : ids) {
            items.add(Objects.requireNonNull(byId.find(id)));
        }
        return Collections.unmodifiableList(items);
    }

    void addAll(List<Item> items) {
        byId.makeRoom(items.size());
        byName.makeRoom(items.size());
        for (Item item : items) {
            byId.add(item);
            byName.add(item);
        }
    }

    void remove(Item item) {
        byId.remove(item);
        byName.remove(item);
    }

    /** Replaces the symbolic data of an item by data with another name. */
    void rename(Item item, ItemSymbols changed) {
        byName.remove(item);
        item.change(changed);
        byName.add(item);
    }

    /**
     * Replaces all items by those of an image. An {@link Item} object stays valid if the image
     * contains an item of its id and kind. Other objects count as removed items.
     *
     * @param create creates an item of the image that is not in the world
     */
    void restore(Collection<ItemSymbols> image, Function<ItemSymbols, Item> create) {
        List<Item> restored = new ArrayList<>(image.size());
        for (ItemSymbols symbols : image) {
            Item item = byId.find(symbols.id());
            if (item != null && item.kind().equals(symbols.kind())) {
                item.restore(symbols);
            } else {
                item = create.apply(symbols);
            }
            restored.add(item);
        }
        byId.clear();
        byName.clear();
        restored.forEach(byId::add);
        restored.forEach(byName::add);
    }
}
