// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.ColumnArena;
import reve.core.world.ItemId;
import reve.core.world.Table;
import reve.core.world.World;

/**
 * For each row the engine's row of the body with physics that the item is attached to, directly or
 * not, and -1 for an item that is attached to nothing or to scenery. Attachments change the layout
 * of the world, so that this property is then bound again.
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
