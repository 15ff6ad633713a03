package reve.core.derive;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import reve.core.frame.FrameBus;
import reve.core.frame.FramePhase;
import reve.core.world.Mesh;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

/**
 * Keeps {@code boundsMin} and {@code boundsMax} of all bodies: the box along the world's axes
 * around the item's own box, turned and placed. The only writer of these columns.
 */
public final class BoundingBoxes {

    private static final ValueLayout.OfDouble DOUBLE = ValueLayout.JAVA_DOUBLE;
    private static final ValueLayout.OfFloat FLOAT = ValueLayout.JAVA_FLOAT;
    private static final ValueLayout.OfInt INT = ValueLayout.JAVA_INT;

    private BoundingBoxes() {}

    /** Works all boxes out in DERIVE of every frame. */
    public static void subscribeTo(FrameBus bus) {
        bus.subscribe(FramePhase.DERIVE, "bounding boxes", event -> update(event.world()));
    }

    /** Works all boxes out now. World's thread; allocates nothing. */
    public static void update(World world) {
        Table table = world.table(WorldPrototype.BODY);
        MemorySegment position = table.column("position").segment();
        MemorySegment orientation = table.column("orientation").segment();
        MemorySegment size = table.column("size").segment();
        MemorySegment shape = table.column("shape").segment();
        MemorySegment low = table.column("boundsMin").segment();
        MemorySegment high = table.column("boundsMax").segment();
        boolean single = world.prototype().realType() == ScalarType.F32;
        for (int row = 0; row < table.rowCount(); row++) {
            long at = row * 3L;
            double x = real(position, single, at);
            double y = real(position, single, at + 1);
            double z = real(position, single, at + 2);
            double halfX = 0.5 * size.getAtIndex(DOUBLE, at);
            double halfY = 0.5 * size.getAtIndex(DOUBLE, at + 1);
            double halfZ = 0.5 * size.getAtIndex(DOUBLE, at + 2);
            int code = shape.getAtIndex(INT, row);
            if (code != Shape.SPHERE && code != Shape.NONE) {
                double qx = real(orientation, single, row * 4L);
                double qy = real(orientation, single, row * 4L + 1);
                double qz = real(orientation, single, row * 4L + 2);
                double qw = real(orientation, single, row * 4L + 3);
                double xx = 1 - 2 * (qy * qy + qz * qz);
                double xy = 2 * (qx * qy - qz * qw);
                double xz = 2 * (qx * qz + qy * qw);
                double yx = 2 * (qx * qy + qz * qw);
                double yy = 1 - 2 * (qx * qx + qz * qz);
                double yz = 2 * (qy * qz - qx * qw);
                double zx = 2 * (qx * qz - qy * qw);
                double zy = 2 * (qy * qz + qx * qw);
                double zz = 1 - 2 * (qx * qx + qy * qy);
                if (code == Shape.MESH) {
                    // A mesh need not be centred on the item's origin.
                    Mesh mesh = (Mesh) table.shapeAt(row);
                    double cx = 0.5 * (mesh.min(0) + mesh.max(0));
                    double cy = 0.5 * (mesh.min(1) + mesh.max(1));
                    double cz = 0.5 * (mesh.min(2) + mesh.max(2));
                    x += xx * cx + xy * cy + xz * cz;
                    y += yx * cx + yy * cy + yz * cz;
                    z += zx * cx + zy * cy + zz * cz;
                }
                double ownX = halfX;
                double ownY = halfY;
                double ownZ = halfZ;
                halfX = Math.abs(xx) * ownX + Math.abs(xy) * ownY + Math.abs(xz) * ownZ;
                halfY = Math.abs(yx) * ownX + Math.abs(yy) * ownY + Math.abs(yz) * ownZ;
                halfZ = Math.abs(zx) * ownX + Math.abs(zy) * ownY + Math.abs(zz) * ownZ;
            }
            low.setAtIndex(DOUBLE, at, x - halfX);
            low.setAtIndex(DOUBLE, at + 1, y - halfY);
            low.setAtIndex(DOUBLE, at + 2, z - halfZ);
            high.setAtIndex(DOUBLE, at, x + halfX);
            high.setAtIndex(DOUBLE, at + 1, y + halfY);
            high.setAtIndex(DOUBLE, at + 2, z + halfZ);
        }
    }

    /** The n-th number of a column whose type is the same for the whole loop. */
    private static double real(MemorySegment column, boolean single, long index) {
        return single ? column.getAtIndex(FLOAT, index) : column.getAtIndex(DOUBLE, index);
    }
}
