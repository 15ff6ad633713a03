// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * All items of one kind as columns over densely packed rows: live ({@link Table}) or as they were
 * in a snapshot ({@link TableSnapshot}). Rows [0, physicsRowCount) are the items with a physics
 * aspect, the rest is scenery.
 */
public sealed interface TableView permits Table, TableSnapshot {

    /** The kind whose items these are. */
    String kind();

    /** All items of the kind. */
    int rowCount();

    /** Items with a physics aspect, which come first. */
    int physicsRowCount();

    /** The item in a row. */
    ItemId idAt(int row);

    /** The row of an item, -1 if it is not in this table. */
    int rowOf(ItemId id);

    /**
     * @throws IllegalArgumentException if the kind has no such property
     */
    ColumnView column(String name);

    /** In a fixed order. */
    List<? extends ColumnView> columns();
}
