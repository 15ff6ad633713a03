// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import org.jspecify.annotations.Nullable;

import reve.core.world.Column;
import reve.core.world.FrameControl;
import reve.core.world.Mesh;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;

/**
 * Updater of the columns {@code boundsMin} and {@code boundsMax} of all bodies. They contain the
 * axis-aligned box, in the world's reference frame, around the item's rotated and translated shape.
 * Only this class writes these columns. For the world's thread only.
 *
 * <p>Copies a few hundred rows at a time between the columns and plain arrays, because compilers
 * optimize loops over arrays reliably.
 */
public final class BoundingBoxes {

    private static final int CHUNK_ROWS = 512;

    private final float[] singles = new float[4 * CHUNK_ROWS];
    private final double[] position = new double[3 * CHUNK_ROWS];
    private final double[] orientation = new double[4 * CHUNK_ROWS];
    private final double[] half = new double[3 * CHUNK_ROWS];
    private final int[] shape = new int[CHUNK_ROWS];
    private final double[] low = new double[3 * CHUNK_ROWS];
    private final double[] high = new double[3 * CHUNK_ROWS];

    /** Computes all boxes. Allocates no memory. */
    public void update(World world) {
        Table table = world.table(WorldPrototype.BODY);
        Column positions = table.column("position");
        Column orientations = table.column("orientation");
        MemorySegment sizes = table.column("size").segment();
        MemorySegment shapes = table.column("shape").segment();
        MemorySegment lows = table.column("boundsMin").segment();
        MemorySegment highs = table.column("boundsMax").segment();
        for (int first = 0; first < table.rowCount(); first += CHUNK_ROWS) {
            int rows = Math.min(CHUNK_ROWS, table.rowCount() - first);
            read(positions, 3 * first, position, 3 * rows);
            read(orientations, 4 * first, orientation, 4 * rows);
            MemorySegment.copy(sizes, ValueLayout.JAVA_DOUBLE, 24L * first, half, 0, 3 * rows);
            MemorySegment.copy(shapes, ValueLayout.JAVA_INT, 4L * first, shape, 0, rows);
            for (int i = 0; i < 3 * rows; i++) {
                half[i] *= 0.5;
            }
            for (int row = 0; row < rows; row++) {
                if (shape[row] == Shape.ELLIPSOID) {
                    turnEllipsoid(row);
                } else if (shape[row] != Shape.SPHERE && shape[row] != Shape.NONE) {
                    turn(row, shape[row] == Shape.MESH ? (Mesh) table.shapeAt(first + row) : null);
                }
            }
            for (int i = 0; i < 3 * rows; i++) {
                low[i] = position[i] - half[i];
                high[i] = position[i] + half[i];
            }
            MemorySegment.copy(low, 0, lows, ValueLayout.JAVA_DOUBLE, 24L * first, 3 * rows);
            MemorySegment.copy(high, 0, highs, ValueLayout.JAVA_DOUBLE, 24L * first, 3 * rows);
        }
        FrameControl.of(world).boundsDerived();
    }

    /** Reads numbers of a column of the prototype's real type, and converts them to doubles. */
    private void read(Column column, int first, double[] into, int count) {
        if (column.type() == ScalarType.F64) {
            MemorySegment.copy(
                    column.segment(), ValueLayout.JAVA_DOUBLE, 8L * first, into, 0, count);
            return;
        }
        MemorySegment.copy(column.segment(), ValueLayout.JAVA_FLOAT, 4L * first, singles, 0, count);
        for (int i = 0; i < count; i++) {
            into[i] = singles[i];
        }
    }

    /**
     * Turns an item's half extents into those of the axis-aligned box around it. Moves the position
     * of a mesh to the centre of its box.
     */
    private void turn(int row, @Nullable Mesh mesh) {
        double x = orientation[4 * row];
        double y = orientation[4 * row + 1];
        double z = orientation[4 * row + 2];
        double w = orientation[4 * row + 3];
        int at = 3 * row;
        double a = half[at];
        double b = half[at + 1];
        double c = half[at + 2];
        turn(at, 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), a, b, c, mesh);
        turn(
                at + 1,
                2 * (x * y + z * w),
                1 - 2 * (x * x + z * z),
                2 * (y * z - x * w),
                a,
                b,
                c,
                mesh);
        turn(
                at + 2,
                2 * (x * z - y * w),
                2 * (y * z + x * w),
                1 - 2 * (x * x + y * y),
                a,
                b,
                c,
                mesh);
    }

    /**
     * Computes the half extent along one world axis. The numbers x, y and z are the row of the
     * rotation matrix for this axis. The numbers a, b and c are the half extents along the item's
     * own axes.
     */
    private void turn(
            int at,
            double x,
            double y,
            double z,
            double a,
            double b,
            double c,
            @Nullable Mesh mesh) {
        half[at] = Math.abs(x) * a + Math.abs(y) * b + Math.abs(z) * c;
        if (mesh != null) {
            position[at] += x * centre(mesh, 0) + y * centre(mesh, 1) + z * centre(mesh, 2);
        }
    }

    /** Turns the half extents of an ellipsoid into those of the axis-aligned box around it. */
    private void turnEllipsoid(int row) {
        double x = orientation[4 * row];
        double y = orientation[4 * row + 1];
        double z = orientation[4 * row + 2];
        double w = orientation[4 * row + 3];
        int at = 3 * row;
        double a = half[at];
        double b = half[at + 1];
        double c = half[at + 2];
        half[at] =
                length(
                        a * (1 - 2 * (y * y + z * z)),
                        b * 2 * (x * y - z * w),
                        c * 2 * (x * z + y * w));
        half[at + 1] =
                length(
                        a * 2 * (x * y + z * w),
                        b * (1 - 2 * (x * x + z * z)),
                        c * 2 * (y * z - x * w));
        half[at + 2] =
                length(
                        a * 2 * (x * z - y * w),
                        b * 2 * (y * z + x * w),
                        c * (1 - 2 * (x * x + y * y)));
    }

    private static double length(double x, double y, double z) {
        return Math.sqrt(x * x + y * y + z * z);
    }

    private static double centre(Mesh mesh, int axis) {
        return 0.5 * (mesh.min(axis) + mesh.max(axis));
    }
}
