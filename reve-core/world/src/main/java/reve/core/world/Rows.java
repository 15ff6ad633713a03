// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** The number of rows of a table, and the row of each item. Only the table changes these data. */
final class Rows {

    private static final int NONE = -1;

    private final IdMap rowById = new IdMap();
    private int count;
    private int physicsCount;

    int count() {
        return count;
    }

    /** Returns the number of rows with a physics aspect. These rows are the first ones. */
    int physicsCount() {
        return physicsCount;
    }

    void setCounts(int rows, int physicsRows) {
        count = rows;
        physicsCount = physicsRows;
    }

    /** Returns the row of an item, -1 if it has none. */
    int rowOf(long id) {
        return rowById.get(id, NONE);
    }

    void put(long id, int row) {
        rowById.put(id, row);
    }

    void remove(long id) {
        rowById.remove(id);
    }

    /** Removes all items. */
    void clear() {
        rowById.clear();
    }
}
