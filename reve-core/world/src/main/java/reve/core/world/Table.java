// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

import java.lang.foreign.MemorySegment;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.function.Function;
import java.util.stream.Stream;

/**
 * The columns and rows of all items of one kind in a live world. Only {@link World} adds and
 * removes rows. Memory after the last row is always zero. For the world's thread only.
 */
public final class Table implements TableView {

    private static final int INITIAL_CAPACITY = 64;

    private final String kind;
    private final Layout layout;
    private final WorldGuard guard;
    private final FrameRecord record;
    private final Rows rows = new Rows();
    private final Column ids;
    private final List<Column> columns;
    private final List<Column> allColumns;
    private final List<Column> references;
    private final Map<String, Column> byName = new LinkedHashMap<>();
    private final Map<String, Column> physicsByName = new LinkedHashMap<>();

    /** The shape of the item in each row. The length of this array is the capacity in rows. */
    private Shape[] shapes;

    /**
     * @param guard called before each change
     * @param record receives direct edits of columns, which no aspect makes
     */
    Table(
            String kind,
            WorldPrototype prototype,
            Layout layout,
            WorldGuard guard,
            FrameRecord record) {
        this.kind = kind;
        this.layout = layout;
        this.guard = guard;
        this.record = record;
        shapes = new Shape[kind.equals(WorldPrototype.WORLD) ? 1 : INITIAL_CAPACITY];
        Arrays.fill(shapes, Shape.none());
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
        for (PropertyDescriptor property : prototype.physicalProperties()) {
            if (property.kind().equals(kind)) {
                byName.put(property.name(), create(property));
            }
        }
        for (PropertyDescriptor property : prototype.properties()) {
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
        return rows.count();
    }

    @Override
    public int physicsRowCount() {
        return rows.physicsCount();
    }

    @Override
    public ItemId idAt(int row) {
        return new ItemId(ids.getReference(row, 0));
    }

    @Override
    public int rowOf(ItemId id) {
        return rows.rowOf(id.value());
    }

    int rowOf(long id) {
        return rows.rowOf(id);
    }

    /** Returns whether the item is in this table and has a physics aspect. */
    boolean hasPhysics(ItemId id) {
        int row = rowOf(id);
        return row >= 0 && row < rows.physicsCount();
    }

    @Override
    public Column column(String name) {
        return required(byName, "property", name);
    }

    @Override
    public List<Column> columns() {
        return columns;
    }

    /** Returns the shape of the item in a row. */
    public Shape shapeAt(int row) {
        return shapes[Objects.checkIndex(row, rows.count())];
    }

    void setShape(int row, Shape shape) {
        shapes[row] = shape;
    }

    /** Returns the column of ids, then {@link #columns()}. */
    List<Column> allColumns() {
        return allColumns;
    }

    Column ids() {
        return ids;
    }

    Column physicsColumn(String name) {
        return required(physicsByName, "physics property", name);
    }

    /** Returns the columns of references, in a fixed order. */
    List<Column> references() {
        return references;
    }

    /**
     * Assigns a zeroed row to an item, after the rows with physics or after the scenery, and
     * returns the row.
     */
    int insert(ItemId id, boolean physics) {
        makeRoom(rowCount() + 1);
        int row = rowCount();
        int end = physicsRowCount();
        rows.setCounts(row + 1, physics ? end + 1 : end);
        if (physics && end < row) {
            move(end, row);
            clear(end, 1);
            row = end;
        }
        ids.setReference(row, 0, id.value());
        rows.put(id.value(), row);
        layout.changed();
        return row;
    }

    /**
     * Removes an item's row. The last row of the same part (physics or scenery) moves into the gap.
     * A removal from the physics rows leaves a gap at their end, which the last row of the scenery
     * fills.
     */
    void remove(ItemId id) {
        int gap = rowOf(id);
        int last = rowCount() - 1;
        int end = physicsRowCount();
        rows.remove(id.value());
        if (gap < end) {
            end--;
            move(end, gap);
            gap = end;
        }
        move(last, gap);
        rows.setCounts(last, end);
        clear(last, 1);
        layout.changed();
    }

    /**
     * Moves the row of a scenery item to the end of the rows with physics. The item keeps its
     * values.
     */
    void promote(ItemId id) {
        makeRoom(rowCount() + 1);
        int to = physicsRowCount();
        swap(rowOf(id), to);
        rows.setCounts(rowCount(), to + 1);
        layout.changed();
    }

    /**
     * Moves the row of an item with physics to the scenery rows, and zeroes its physics properties.
     */
    void demote(ItemId id) {
        makeRoom(rowCount() + 1);
        int to = physicsRowCount() - 1;
        swap(rowOf(id), to);
        rows.setCounts(rowCount(), to);
        physicsByName.values().forEach(column -> column.clearRows(to, 1));
        layout.changed();
    }

    /**
     * Allocates memory for at least this number of rows. Memory grows at least by a factor of two.
     */
    void makeRoom(int wanted) {
        if (wanted <= shapes.length) {
            return;
        }
        int before = shapes.length;
        int capacity = Math.max(wanted, Math.multiplyExact(before, 2));
        allColumns.forEach(column -> grow(column, capacity));
        shapes = Arrays.copyOf(shapes, capacity);
        Arrays.fill(shapes, before, capacity, Shape.none());
    }

    /** Replaces all rows by those of an image. */
    void restore(TableCopy copy, Function<ItemId, Shape> shapeOf) {
        makeRoom(copy.rowCount());
        clear(copy.rowCount(), Math.max(0, rowCount() - copy.rowCount()));
        rows.setCounts(copy.rowCount(), copy.physicsRowCount());
        for (int i = 0; i < allColumns.size(); i++) {
            allColumns.get(i).restore(copy.column(i));
        }
        rows.clear();
        for (int row = 0; row < rowCount(); row++) {
            settle(row);
            shapes[row] = shapeOf.apply(idAt(row));
        }
        layout.changed();
    }

    private void grow(Column column, int capacity) {
        layout.replace(column.moveTo(reserve(column.descriptor(), capacity)));
    }

    private void move(int from, int to) {
        if (from != to) {
            copy(from, to);
            settle(to);
        }
    }

    /** Swaps two rows. Uses the first unused row as temporary memory. */
    private void swap(int one, int other) {
        if (one != other) {
            int spare = rowCount();
            copy(one, spare);
            copy(other, one);
            copy(spare, other);
            settle(one);
            settle(other);
            clear(spare, 1);
        }
    }

    private void copy(int from, int to) {
        for (Column column : allColumns) {
            column.copyRow(from, to);
        }
        shapes[to] = shapes[from];
    }

    /** Records this row as the row of the item whose id it contains. */
    private void settle(int row) {
        rows.put(ids.getReference(row, 0), row);
    }

    private void clear(int first, int count) {
        for (Column column : allColumns) {
            column.clearRows(first, count);
        }
        Arrays.fill(shapes, first, first + count, Shape.none());
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
        return new Column(property, rows, guard, record, reserve(property, shapes.length));
    }

    private MemorySegment reserve(PropertyDescriptor property, int rows) {
        return layout.reserve(kind + "." + property.name(), (long) rows * property.rowBytes());
    }
}
