// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Table;
import reve.pe.PhysicsEngine;

import java.util.HashMap;
import java.util.Map;

/** Which item stood in which of the engine's rows of a table. World's thread only. */
final class LentRows {
    private final Table table;
    private long[] items = {};

    LentRows(Table table) {
        this.table = table;
    }

    /**
     * Tells the engine where the items of its rows went since the last call, so that what laws
     * remember of an item stays with it. Called before the engine learns the new number of rows.
     */
    void follow(PhysicsEngine engine) {
        long[] now = new long[table.physicsRowCount()];
        for (int row = 0; row < now.length; row++) {
            now[row] = table.idAt(row).value();
        }
        Map<Long, Integer> left = new HashMap<>();
        for (int row = 0; row < items.length; row++) {
            if (row >= now.length || now[row] != items[row]) {
                left.put(items[row], row);
            }
        }
        // From the front: the item of a row has then left it already, for a row before.
        for (int row = 0; row < Math.min(now.length, items.length); row++) {
            if (now[row] != items[row]) {
                int from = left.getOrDefault(now[row], -1);
                engine.moveRow(table.kind(), from > row ? from : row, row);
            }
        }
        items = now;
    }
}
