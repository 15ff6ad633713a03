// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.Arrays;
import java.util.List;
import java.util.Optional;

/**
 * The physical aspect of a body: its place, shape and appearance, as a view of its row. Items of
 * other kinds have an empty aspect, in which every method except {@link #isEmpty} throws an
 * exception. Springs and surfaces nevertheless have the appearance {@link #look}. For the world's
 * thread only.
 */
public final class PhysicalAspect {

    private static final double[] NO_CORNER = {Double.NaN, Double.NaN, Double.NaN};

    private final Item item;

    PhysicalAspect(Item item) {
        this.item = item;
    }

    /** Returns whether the aspect is empty, because the item is not a body. */
    public boolean isEmpty() {
        return !item.kind().equals(WorldPrototype.BODY);
    }

    /**
     * Returns the location of the origin in the world's reference frame (3) [m]; see {@link
     * World#attach}.
     */
    public double[] location() {
        requirePlace();
        return item.symbols().attachment() == null
                ? read("position")
                : Arrays.copyOf(item.world().hierarchy.worldPose(item.id()), 3);
    }

    /**
     * Sets the location. This changes the pose of an attached item relative to its parent.
     *
     * @throws IllegalArgumentException naming item and value if a number is not finite
     */
    public void setLocation(double x, double y, double z) {
        double[] from = location();
        column("position", x, y, z);
        moveWithinParent(new double[] {x, y, z}, orientation());
        write("position", x, y, z);
        note("location", numbers(from), List.of(x, y, z));
    }

    /** Returns the rotation as a unit quaternion xyzw (4). */
    public double[] orientation() {
        requirePlace();
        return item.symbols().attachment() == null
                ? read("orientation")
                : Arrays.copyOfRange(item.world().hierarchy.worldPose(item.id()), 3, Pose.NUMBERS);
    }

    /**
     * Sets the rotation. The quaternion must not be 0, and is normalised. This changes the pose of
     * an attached item relative to its parent.
     */
    public void setOrientation(double x, double y, double z, double w) {
        double[] from = orientation();
        double[] unit = Values.requireRotation(item.name(), x, y, z, w);
        moveWithinParent(location(), unit);
        write("orientation", unit);
        note("orientation", numbers(from), numbers(unit));
    }

    /** Returns the extent of the shape along the item's own axes (3) [m]. */
    public double[] size() {
        return read("size");
    }

    /** Returns the shape, with lengths in metres. */
    public Shape shape() {
        requirePlace();
        return item.symbols().shape();
    }

    /** Sets the shape. */
    public void setShape(Shape shape) {
        Shape from = shape();
        item.change(item.symbols().with(item.symbols().likeness().with(shape)));
        writeShape(shape);
        note("shape", from, shape);
    }

    /**
     * Returns the material of the whole shape. A mesh has its own materials if the result is empty.
     */
    public Optional<Material> material() {
        requirePlace();
        return item.symbols().material();
    }

    /**
     * Sets the material.
     *
     * @param material the material of the whole shape; empty if a mesh has its own materials
     */
    public void setMaterial(Optional<Material> material) {
        Optional<Material> from = material();
        item.change(item.symbols().with(item.symbols().likeness().with(material)));
        note("material", from.orElse(null), material.orElse(null));
    }

    /** Returns the colour of the body. */
    public Colour colour() {
        int row = requirePlace();
        return new Colour(item.table().column("colour").getInt(row, 0));
    }

    /** Returns the appearance of a spring or surface; the default for other kinds. */
    public ConnectionLook look() {
        item.checkedRow();
        return item.symbols().look();
    }

    /**
     * Sets the width of a spring.
     *
     * @param metres diameter [m], 0 or more; 0 for a thin line
     * @throws IllegalArgumentException if the item is no spring, or the width is out of range
     */
    public void setWidth(double metres) {
        ConnectionLook.requireWidth(item.toString(), item.kind());
        double from = look().width();
        setLook(look().with(metres));
        note(ConnectionLook.WIDTH, from, metres);
    }

    /** Sets the colour of a body, a spring or a surface. */
    public void setColour(Colour colour) {
        if (ConnectionLook.KINDS.contains(item.kind())) {
            Optional<Colour> from = look().colour();
            setLook(look().with(colour));
            note("colour", from.orElse(null), colour);
            return;
        }
        Colour from = colour();
        writeColour(colour);
        note("colour", from, colour);
    }

    /**
     * Returns the lower corner (3) [m] of the item's bounding box, which the last DERIVE phase
     * computed; NaN before the first one.
     */
    public double[] boundsMin() {
        return read("boundsMin");
    }

    /**
     * Returns the upper corner (3) [m] of the item's bounding box, which the last DERIVE phase
     * computed; NaN before the first one.
     */
    public double[] boundsMax() {
        return read("boundsMax");
    }

    /**
     * Writes the values of a definition that was already checked. The phase DERIVE computes the
     * bounding box.
     */
    void place(ItemDefinition definition) {
        Table table = item.table();
        int row = item.checkedRow();
        table.column("position").write(row, definition.sharedLocation());
        table.column("orientation").write(row, definition.sharedOrientation());
        writeColour(definition.colour());
        writeShape(definition.shape());
        table.column("boundsMin").write(row, NO_CORNER);
        table.column("boundsMax").write(row, NO_CORNER);
    }

    private void setLook(ConnectionLook look) {
        item.change(item.symbols().with(item.symbols().likeness().with(look)));
    }

    private void writeShape(Shape shape) {
        int row = item.checkedRow();
        Column size = item.table().column("size");
        for (int axis = 0; axis < 3; axis++) {
            size.write(row, axis, shape.size(axis));
        }
        item.table().column("shape").write(row, 0, shape.code());
        item.table().setShape(row, shape);
    }

    private void writeColour(Colour colour) {
        item.table().column("colour").write(item.checkedRow(), 0, colour.rgba());
    }

    private void moveWithinParent(double[] location, double[] orientation) {
        Attachment before = item.symbols().attachment();
        if (before == null) {
            return;
        }
        Hierarchy hierarchy = item.world().hierarchy;
        Pose parent = Pose.of(hierarchy.worldPose(before.parent()));
        var attachment =
                new Attachment(before.parent(), Pose.of(location, orientation).relativeTo(parent));
        item.change(item.symbols().attached(attachment));
        hierarchy.attach(item.id(), attachment);
    }

    private void note(String property, @Nullable Object from, @Nullable Object to) {
        item.world()
                .note(
                        new WorldChange.Edited(
                                item.id(), WorldChange.Aspect.PHYSICAL, property, from, to));
    }

    private static List<Double> numbers(double[] values) {
        return Arrays.stream(values).boxed().toList();
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
        Column column = column(property, values);
        for (int i = 0; i < values.length; i++) {
            column.write(row, i, values[i]);
        }
    }

    /** Returns the column of a property, after checking the values. */
    private Column column(String property, double... values) {
        requirePlace();
        Column column = item.table().column(property);
        Values.requireFits(item.name(), column.descriptor(), values);
        return column;
    }

    private int requirePlace() {
        if (isEmpty()) {
            throw new IllegalStateException(
                    item + " has no place: only items of kind body have a physical aspect");
        }
        return item.checkedRow();
    }
}
