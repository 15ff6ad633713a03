// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.ColumnArena;
import reve.core.world.ItemId;
import reve.core.world.Table;
import reve.core.world.World;

/**
 * A property that contains, for each item, the engine's row of the body that carries the item. The
 * carrying body has physics, and the item is attached to it, directly or through other items. The
 * value is -1 for an item that is attached to nothing or to scenery. A change of attachments
 * changes the layout of the world, so the adapter then binds this property again.
 */
final class BoundCarriers extends BoundRowNumbers {
    private final World world;

    BoundCarriers(String name, World world, Table table, boolean scenery, ColumnArena arena) {
        super(name, table, scenery, arena);
        this.world = world;
    }

    @Override
    int numberOf(int tableRow) {
        return carrier(table().idAt(tableRow));
    }

    @Override
    boolean isEdited() {
        return false;
    }

    @Override
    void markSeen() {}

    private int carrier(ItemId item) {
        ItemId root = item;
        for (ItemId next = item; next != null; next = world.item(next).parent().orElse(null)) {
            root = next;
        }
        int row = root.equals(item) ? NONE : table().rowOf(root);
        return row < table().physicsRowCount() ? row : NONE;
    }
}
