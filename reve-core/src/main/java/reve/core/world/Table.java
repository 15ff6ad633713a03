// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

import java.lang.foreign.MemorySegment;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.function.LongFunction;
import java.util.stream.Stream;

/**
 * The live rows of one kind. World's thread only; rows come and go through {@link World}. Memory
 * behind the last row is always zero.
 */
public final class Table implements TableView {

    private static final int INITIAL_CAPACITY = 64;

    private final World world;
    private final String kind;
    private final Layout layout;
    private final Column ids;
    private final List<Column> columns;
    private final List<Column> allColumns;
    private final List<Column> references;
    private final Map<String, Column> byName = new LinkedHashMap<>();
    private final Map<String, Column> physicsByName = new LinkedHashMap<>();
    private Item[] items;
    private int rowCount;
    private int physicsRowCount;

    Table(World world, String kind, Layout layout) {
        this.world = world;
        this.kind = kind;
        this.layout = layout;
        items = new Item[kind.equals(WorldPrototype.WORLD) ? 1 : INITIAL_CAPACITY];
        ids =
                create(
                        new PropertyDescriptor(
                                "id",
                                kind,
                                ScalarType.REF,
                                1,
                                Unit.parse("1"),
                                Optional.of(kind),
                                "The item in each row."));
        for (PropertyDescriptor property : world.prototype().physicalProperties()) {
            if (property.kind().equals(kind)) {
                byName.put(property.name(), create(property));
            }
        }
        for (PropertyDescriptor property : world.prototype().properties()) {
            if (property.kind().equals(kind)) {
                physicsByName.put(property.name(), create(property));
            }
        }
        byName.putAll(physicsByName);
        columns = List.copyOf(byName.values());
        allColumns = Stream.concat(Stream.of(ids), columns.stream()).toList();
        references = columns.stream().filter(column -> column.type() == ScalarType.REF).toList();
    }

    @Override
    public String kind() {
        return kind;
    }

    @Override
    public int rowCount() {
        return rowCount;
    }

    @Override
    public int physicsRowCount() {
        return physicsRowCount;
    }

    @Override
    public ItemId idAt(int row) {
        return new ItemId(ids.getReference(row, 0));
    }

    @Override
    public int rowOf(ItemId id) {
        Item item = world.findItem(id);
        return item != null && item.table() == this ? item.row : -1;
    }

    @Override
    public Column column(String name) {
        return required(byName, "property", name);
    }

    @Override
    public List<Column> columns() {
        return columns;
    }

    /** The form of the item in a row. */
    public Shape shapeAt(int row) {
        return items[row].symbols().shape();
    }

    /** The ids of the items, then {@link #columns()}. */
    List<Column> allColumns() {
        return allColumns;
    }

    Column ids() {
        return ids;
    }

    World world() {
        return world;
    }

    Column physicsColumn(String name) {
        return required(physicsByName, "physics property", name);
    }

    /** Columns of references, in a fixed order. */
    List<Column> references() {
        return references;
    }

    /** The item in a row. */
    public Item itemAt(int row) {
        return items[row];
    }

    /** Gives an item a zeroed row at the end of its part. */
    void insert(Item item, boolean physics) {
        makeRoom(rowCount + 1);
        int row = rowCount++;
        if (physics) {
            if (physicsRowCount < row) {
                move(physicsRowCount, row);
                clear(physicsRowCount, 1);
            }
            row = physicsRowCount++;
        }
        items[row] = item;
        item.row = row;
        ids.setReference(row, 0, item.id().value());
        layout.rowsMoved();
    }

    /** Takes an item's row away; the last row of each part moves into the gap. */
    void remove(Item item) {
        int gap = item.row;
        if (gap < physicsRowCount) {
            move(--physicsRowCount, gap);
            gap = physicsRowCount;
        }
        move(--rowCount, gap);
        items[rowCount] = null;
        item.row = Item.REMOVED;
        clear(rowCount, 1);
        layout.rowsMoved();
    }

    /** Moves a scenery row to the end of the physics part, values included. */
    void promote(Item item) {
        makeRoom(rowCount + 1);
        int from = item.row;
        int to = physicsRowCount++;
        if (from != to) {
            int spare = rowCount;
            copy(to, spare);
            Item displaced = items[to];
            move(from, to);
            copy(spare, from);
            items[from] = displaced;
            displaced.row = from;
            clear(spare, 1);
        }
        layout.rowsMoved();
    }

    /** Moves a physics row to the scenery part and zeroes its physics properties. */
    void demote(Item item) {
        makeRoom(rowCount + 1);
        int from = item.row;
        int to = --physicsRowCount;
        if (from != to) {
            int spare = rowCount;
            copy(from, spare);
            move(to, from);
            copy(spare, to);
            items[to] = item;
            item.row = to;
            clear(spare, 1);
        }
        physicsByName.values().forEach(column -> column.clearRows(to, 1));
        layout.rowsMoved();
    }

    /** Makes room for that many rows, at least doubling when more memory is needed. */
    void makeRoom(int rows) {
        if (rows <= items.length) {
            return;
        }
        int capacity = Math.max(rows, Math.multiplyExact(items.length, 2));
        grow(ids, capacity);
        columns.forEach(column -> grow(column, capacity));
        items = Arrays.copyOf(items, capacity);
    }

    /** Takes over all rows of a copy; the items are told where they are. */
    void restore(TableCopy copy, LongFunction<Item> itemById) {
        makeRoom(copy.rowCount());
        clear(copy.rowCount(), Math.max(0, rowCount - copy.rowCount()));
        rowCount = copy.rowCount();
        physicsRowCount = copy.physicsRowCount();
        for (int i = 0; i < allColumns.size(); i++) {
            allColumns.get(i).restore(copy.column(i));
        }
        Arrays.fill(items, null);
        for (int row = 0; row < rowCount; row++) {
            items[row] = itemById.apply(ids.getReference(row, 0));
            items[row].row = row;
        }
        layout.rowsMoved();
    }

    private void grow(Column column, int capacity) {
        layout.replace(column.moveTo(reserve(column.descriptor(), capacity)));
    }

    private void move(int from, int to) {
        if (from == to || items[from] == null) {
            return;
        }
        copy(from, to);
        items[to] = items[from];
        items[to].row = to;
    }

    private void copy(int from, int to) {
        ids.copyRow(from, to);
        for (Column column : columns) {
            column.copyRow(from, to);
        }
    }

    private void clear(int first, int count) {
        for (Column column : allColumns) {
            column.clearRows(first, count);
        }
    }

    private Column required(Map<String, Column> among, String what, String name) {
        Column column = among.get(name);
        if (column == null) {
            throw new IllegalArgumentException(
                    "kind " + kind + " has no " + what + " " + name + "; it has " + among.keySet());
        }
        return column;
    }

    private Column create(PropertyDescriptor property) {
        return new Column(this, property, reserve(property, items.length));
    }

    private MemorySegment reserve(PropertyDescriptor property, int rows) {
        return layout.reserve(kind + "." + property.name(), (long) rows * property.rowBytes());
    }
}
