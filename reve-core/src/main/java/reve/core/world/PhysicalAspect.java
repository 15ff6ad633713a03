package reve.core.world;

/**
 * Where a body is and what it looks like: a view of its row. Only the kind {@code body} has one;
 * for other kinds it is empty and everything else here throws. World's thread only.
 */
public final class PhysicalAspect {

    private final Item item;

    PhysicalAspect(Item item) {
        this.item = item;
    }

    public boolean isEmpty() {
        return !item.kind().equals(WorldPrototype.BODY);
    }

    /** Place of the origin in the world frame (3) [m]. */
    public double[] location() {
        return read("position");
    }

    /** @throws IllegalArgumentException naming item and value if a number is not finite */
    public void setLocation(double x, double y, double z) {
        write("position", x, y, z);
    }

    /** Rotation as a unit quaternion xyzw (4). */
    public double[] orientation() {
        return read("orientation");
    }

    /** Any quaternion but 0; it is normalised. */
    public void setOrientation(double x, double y, double z, double w) {
        write("orientation", Values.requireRotation(item.name(), x, y, z, w));
    }

    /** Extent of the shape along the item's own axes (3) [m]. */
    public double[] size() {
        return read("size");
    }

    public Shape shape() {
        requirePlace();
        return item.symbols().shape();
    }

    public void setShape(Shape shape) {
        requirePlace();
        item.world().setSymbols(item, item.symbols().with(shape));
        writeShape(shape);
    }

    public Colour colour() {
        int row = requirePlace();
        return new Colour(item.table().column("colour").getInt(row, 0));
    }

    public void setColour(Colour colour) {
        int row = requirePlace();
        item.table().column("colour").setInt(row, 0, colour.rgba());
    }

    /** Lower corner of the box around the item as of the last DERIVE (3) [m]. */
    public double[] boundsMin() {
        return read("boundsMin");
    }

    /** Upper corner of the box around the item as of the last DERIVE (3) [m]. */
    public double[] boundsMax() {
        return read("boundsMax");
    }

    void place(ItemDefinition definition) {
        double[] at = definition.location();
        setLocation(at[0], at[1], at[2]);
        write("orientation", definition.orientation());
        setColour(definition.colour());
        writeShape(definition.shape());
    }

    private void writeShape(Shape shape) {
        write("size", shape.size(0), shape.size(1), shape.size(2));
        item.table().column("shape").setInt(item.checkedRow(), 0, shape.code());
    }

    private double[] read(String property) {
        int row = requirePlace();
        Column column = item.table().column(property);
        double[] values = new double[column.components()];
        for (int i = 0; i < values.length; i++) {
            values[i] = column.getDouble(row, i);
        }
        return values;
    }

    private void write(String property, double... values) {
        int row = requirePlace();
        Column column = item.table().column(property);
        Values.requireFits(item.name(), column.descriptor(), values);
        for (int i = 0; i < values.length; i++) {
            column.setDouble(row, i, values[i]);
        }
    }

    private int requirePlace() {
        if (isEmpty()) {
            throw new IllegalStateException(
                    item + " has no place: only items of kind body have a physical aspect");
        }
        return item.checkedRow();
    }
}
