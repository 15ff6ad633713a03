// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Table;
import reve.pe.PhysicsEngine;

import java.util.Arrays;
import java.util.HashMap;
import java.util.Map;

/** The items in the engine's rows of a table at the last update. For the world's thread only. */
final class BoundRows {
    private final Table table;
    private long[] items = {};

    /** Moves of rows. Each move consists of two numbers: the old row and the new row. */
    private long[] moves = {};

    private int moved;

    BoundRows(Table table) {
        this.table = table;
    }

    /**
     * Notifies the engine of items that moved to other rows since the last call, so that the state
     * of laws follows them. Called before the engine receives the new number of rows.
     */
    void follow(PhysicsEngine engine) {
        moved = 0;
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
        // The loop begins at the front. An item that has left a row has therefore already been
        // moved to an earlier row when the loop reaches its old row.
        for (int row = 0; row < Math.min(now.length, items.length); row++) {
            if (now[row] != items[row]) {
                int from = left.getOrDefault(now[row], -1);
                move(from > row ? from : row, row);
            }
        }
        for (int row = now.length; row < items.length; row++) {
            move(row, row); // the item was removed; another item may get this row later
        }
        items = now;
        if (moved > 0) {
            engine.moveRows(table.kind(), Arrays.copyOf(moves, moved));
        }
    }

    private void move(int from, int to) {
        if (moved == moves.length) {
            moves = Arrays.copyOf(moves, Math.max(16, 2 * moved));
        }
        moves[moved++] = from;
        moves[moved++] = to;
    }
}
