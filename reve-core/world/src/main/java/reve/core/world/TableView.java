// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * All items of one kind as columns with densely packed rows. The table belongs to a live world
 * ({@link Table}) or to a snapshot ({@link TableSnapshot}). Rows [0, physicsRowCount) are the items
 * with a physics aspect. The other rows are scenery, which laws do not move.
 */
public sealed interface TableView permits Table, TableSnapshot {

    /** Returns the kind of the items. */
    String kind();

    /** Returns the number of items of the kind. */
    int rowCount();

    /** Returns the number of items with a physics aspect. Their rows are the first ones. */
    int physicsRowCount();

    /** Returns the item in a row. */
    ItemId idAt(int row);

    /** Returns the row of an item, -1 if it is not in this table. */
    int rowOf(ItemId id);

    /**
     * Returns the column of a property.
     *
     * @throws IllegalArgumentException if the kind has no such property
     */
    ColumnView column(String name);

    /** Returns the columns in a fixed order. */
    List<? extends ColumnView> columns();
}
