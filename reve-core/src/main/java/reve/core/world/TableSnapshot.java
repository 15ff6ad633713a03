package reve.core.world;

import java.util.HashMap;
import java.util.List;
import java.util.Map;

/** A table as it was when a frame was published. One reading thread, read only. */
public final class TableSnapshot implements TableView {

    private final String kind;
    private final int rowCount;
    private final int physicsRowCount;
    private final ColumnSnapshot ids;
    private final List<ColumnSnapshot> columns;
    private final Map<Long, Integer> rowById = new HashMap<>();

    TableSnapshot(String kind, int rowCount, int physicsRowCount, ColumnSnapshot ids,
            List<ColumnSnapshot> columns) {
        this.kind = kind;
        this.rowCount = rowCount;
        this.physicsRowCount = physicsRowCount;
        this.ids = ids;
        this.columns = columns;
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

    /** (rows) ids of the items. */
    public ColumnSnapshot ids() {
        return ids;
    }

    /** @throws IllegalArgumentException at times when the snapshot was lost */
    @Override
    public ItemId idAt(int row) {
        return new ItemId(ids.getReference(row, 0));
    }

    /** The first call looks through all rows, later ones are quick. */
    @Override
    public int rowOf(ItemId id) {
        if (rowById.isEmpty()) {
            for (int row = 0; row < rowCount; row++) {
                rowById.put(ids.getReference(row, 0), row);
            }
        }
        return rowById.getOrDefault(id.value(), -1);
    }

    @Override
    public ColumnSnapshot column(String name) {
        for (ColumnSnapshot column : columns) {
            if (column.name().equals(name)) {
                return column;
            }
        }
        throw new IllegalArgumentException("kind " + kind + " has no property " + name
                + "; it has " + columns.stream().map(ColumnView::name).toList());
    }

    @Override
    public List<ColumnSnapshot> columns() {
        return columns;
    }
}
