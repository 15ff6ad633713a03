// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.List;
import java.util.Objects;
import java.util.Optional;

/**
 * Makes the shapes of bodies follow the column {@code size}, which laws may write. Only bodies with
 * a physics aspect change. For the world's thread only.
 */
final class LawSizes {

    /** Smallest length of a shape [m]; world files, too, refuse smaller lengths. */
    private static final double LEAST_LENGTH = 1e-100;

    /** Largest length of a shape [m], which {@link Shape} checks, too. */
    private static final double MOST_LENGTH = 1e12;

    private final WorldData data;
    private final Items items;

    LawSizes(WorldData data, Items items) {
        this.data = data;
        this.items = items;
    }

    /** Makes the shapes follow, see {@link FrameControl#followSizes}. */
    Optional<RefusedSize> follow() {
        Table bodies = data.table(WorldPrototype.BODY);
        Column size = bodies.column("size");
        RefusedSize refused = null;
        for (int row = 0; row < bodies.physicsRowCount(); row++) {
            Shape shape = bodies.shapeAt(row);
            double x = size.getDouble(row, 0);
            double y = size.getDouble(row, 1);
            double z = size.getDouble(row, 2);
            if (isSame(x, shape.size(0)) && isSame(y, shape.size(1)) && isSame(z, shape.size(2))) {
                continue;
            }
            Shape resized = resized(shape, x, y, z);
            if (resized == null) {
                if (refused == null) {
                    refused = new RefusedSize(item(bodies, row), List.of(x, y, z));
                }
            } else if (!resized.equals(shape)) {
                Item item = item(bodies, row);
                item.change(item.symbols().with(item.symbols().likeness().with(resized)));
                bodies.setShape(row, resized);
            }
            writeBack(size, row, bodies.shapeAt(row));
        }
        return Optional.ofNullable(refused);
    }

    private Item item(Table bodies, int row) {
        return Objects.requireNonNull(items.find(bodies.idAt(row)));
    }

    /** Writes those components that differ from the size of the shape. */
    private static void writeBack(Column size, int row, Shape shape) {
        for (int axis = 0; axis < 3; axis++) {
            if (!isSame(size.getDouble(row, axis), shape.size(axis))) {
                size.write(row, axis, shape.size(axis));
            }
        }
    }

    /** Returns whether two numbers have the same bits, because the state hash covers the bits. */
    private static boolean isSame(double one, double other) {
        return Double.doubleToRawLongBits(one) == Double.doubleToRawLongBits(other);
    }

    /**
     * Returns the shape with another size. Returns the shape itself if laws cannot change its size,
     * and null if it cannot have this size.
     */
    private static @Nullable Shape resized(Shape shape, double x, double y, double z) {
        return switch (shape) {
            case Shape.None none -> none;
            case Mesh mesh -> mesh;
            case Shape.Sphere _ -> isLength(x / 2) ? Shape.sphere(x / 2) : null;
            case Shape.Box _ ->
                    isLength(x) && isLength(y) && isLength(z) ? Shape.box(x, y, z) : null;
            case Shape.Ellipsoid _ ->
                    isLength(x) && isLength(y) && isLength(z) ? Shape.ellipsoid(x, y, z) : null;
            case Shape.Plane _ -> isLength(x) && isLength(z) ? Shape.plane(x, z) : null;
            case Shape.Capsule _ ->
                    isLength(x) && isLength(x / 2) && isLength(y)
                            ? Shape.capsule(x / 2, Math.max(x, y))
                            : null;
            case Shape.Cylinder _ ->
                    isLength(x / 2) && isLength(y) ? Shape.cylinder(x / 2, y) : null;
        };
    }

    private static boolean isLength(double metres) {
        return metres >= LEAST_LENGTH && metres <= MOST_LENGTH;
    }
}
