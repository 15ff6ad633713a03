// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import reve.core.world.Colour;
import reve.core.world.ColumnView;
import reve.core.world.ConnectionLook;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.List;
import java.util.Optional;

/**
 * Builder of a scene from the state of a world at the end of a frame. Bodies are drawn by shape and
 * material, springs as lines or, if they have a width, as cylinders. Surfaces are drawn as
 * triangles in their own colour, or in the colours of the bodies at their corners. Items whose size
 * or distance from the origin exceeds {@link #FARTHEST} are omitted, so that one item cannot
 * prevent all pictures. The number of a drawn item is the value of its {@link ItemId}. An item
 * whose colour has alpha 0 is hidden. A surface without a colour of its own is hidden if all its
 * corners are hidden bodies. Planes have a grid. A faint ground that fades with distance is added
 * to a world without planes, so that depth and motion are visible.
 *
 * @param image size and quality
 * @param environment background and light
 * @param camera viewpoint; if empty, all bodies except planes are fitted into the picture. This
 *     needs their bounding boxes, which are computed in DERIVE (the frame's phase for derived
 *     properties).
 * @param without a body that is not drawn, for example the body that carries the camera
 */
public record SceneBuilder(
        ImageFormat image,
        Environment environment,
        Optional<Camera> camera,
        Optional<ItemId> without) {

    /** Creates a builder that shows all bodies. */
    public SceneBuilder(ImageFormat image, Environment environment, Optional<Camera> camera) {
        this(image, environment, camera, Optional.empty());
    }

    private static final ValueLayout.OfDouble DOUBLE = ValueLayout.JAVA_DOUBLE;
    private static final ValueLayout.OfFloat FLOAT = ValueLayout.JAVA_FLOAT;
    private static final ValueLayout.OfInt INT = ValueLayout.JAVA_INT;

    private static final int GROUND_RGBA = 0xfff1eeec;

    /** Width of a spring's line as a fraction of the picture's height. */
    private static final float SPRING_WIDTH = 1 / 200f;

    /**
     * Side of the added ground as a multiple of the longest side of the world's bounds. The ground
     * fades out before its edge.
     */
    private static final double GROUND_SIDE = 60;

    /**
     * Largest coordinate or size of a drawn item [m]. The renderer refuses scenes with numbers
     * larger than twice this value.
     */
    private static final double FARTHEST = 5e14;

    private static final double INFINITY = Double.POSITIVE_INFINITY;
    private static final Point ORIGIN = new Point(0, 0, 0);

    /**
     * A column of real numbers. The precision of the world decides whether they are float or
     * double.
     */
    private record Reals(MemorySegment segment, boolean single) {
        Reals(TableSnapshot table, String property) {
            this(table.column(property).segment(), table.column(property).type() == ScalarType.F32);
        }

        double at(long index) {
            return single ? segment.getAtIndex(FLOAT, index) : segment.getAtIndex(DOUBLE, index);
        }

        Point point(long index) {
            return new Point(at(index), at(index + 1), at(index + 2));
        }

        /** Returns whether the three numbers from an index on can be drawn. */
        boolean isDrawable(long index) {
            return Math.abs(at(index)) <= FARTHEST
                    && Math.abs(at(index + 1)) <= FARTHEST
                    && Math.abs(at(index + 2)) <= FARTHEST;
        }
    }

    /**
     * Builds the scene of a snapshot, which may be closed afterwards. For any thread.
     *
     * @throws RenderException if the snapshot was overwritten during the build; the caller may
     *     retry with a newer snapshot
     */
    public Scene build(WorldSnapshot snapshot) {
        try {
            Scene scene = read(snapshot);
            if (!snapshot.lost()) {
                return scene;
            }
        } catch (RuntimeException nonsense) {
            if (!snapshot.lost()) {
                throw nonsense;
            }
        }
        throw new RenderException(
                "the snapshot of frame "
                        + snapshot.frame()
                        + " was overwritten while it was read; take a newer one");
    }

    /**
     * Returns the camera at a body's origin that looks along the body's +Z axis, with its +Y axis
     * up.
     *
     * @param verticalFovRadians see {@link Camera#extent()}
     * @return empty if the body does not exist
     */
    public static Optional<Camera> viewOf(
            WorldSnapshot snapshot, ItemId body, double verticalFovRadians) {
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        int row = bodies.rowOf(body);
        if (row < 0) {
            return Optional.empty();
        }
        var position = new Reals(bodies, "position");
        var orientation = new Reals(bodies, "orientation");
        var eye =
                new Point(
                        position.at(3L * row),
                        position.at(3L * row + 1),
                        position.at(3L * row + 2));
        double x = orientation.at(4L * row);
        double y = orientation.at(4L * row + 1);
        double z = orientation.at(4L * row + 2);
        double w = orientation.at(4L * row + 3);
        // Columns 2 and 3 of the rotation matrix: the body's +Y and +Z axes in the world.
        var up = new Point(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x));
        var ahead = new Point(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
        return Optional.of(Camera.perspective(eye, eye.plus(1, ahead), up, verticalFovRadians));
    }

    /**
     * Returns the box around all visible bodies except planes, and around surfaces. Returns the box
     * around the planes if there are no such bodies and surfaces.
     */
    public static Optional<Bounds> bounds(WorldSnapshot snapshot) {
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        var box = new Box();
        addBodies(box, bodies, false);
        addSurfaces(box, snapshot, bodies);
        if (box.isEmpty()) {
            addBodies(box, bodies, true);
        }
        return box.bounds();
    }

    /** A box that grows to contain points. */
    private static final class Box {
        private final double[] low = {INFINITY, INFINITY, INFINITY};
        private final double[] high = {-INFINITY, -INFINITY, -INFINITY};

        void add(Reals lows, Reals highs, long at) {
            for (int i = 0; i < 3; i++) {
                low[i] = Math.min(low[i], lows.at(at + i));
                high[i] = Math.max(high[i], highs.at(at + i));
            }
        }

        boolean isEmpty() {
            return low[0] == INFINITY;
        }

        Optional<Bounds> bounds() {
            return isEmpty() ? Optional.empty() : Optional.of(new Bounds(point(low), point(high)));
        }
    }

    private static void addBodies(Box box, TableSnapshot bodies, boolean planes) {
        var lows = new Reals(bodies, "boundsMin");
        var highs = new Reals(bodies, "boundsMax");
        MemorySegment shape = bodies.column("shape").segment();
        MemorySegment colour = bodies.column("colour").segment();
        for (int row = 0; row < bodies.rowCount(); row++) {
            int code = shape.getAtIndex(INT, row);
            if (code != Shape.NONE
                    && (code == Shape.PLANE) == planes
                    && !isHidden(colour.getAtIndex(INT, row))
                    && lows.isDrawable(row * 3L)
                    && highs.isDrawable(row * 3L)) {
                box.add(lows, highs, row * 3L);
            }
        }
    }

    private static void addSurfaces(Box box, WorldSnapshot snapshot, TableSnapshot bodies) {
        var position = new Reals(bodies, "position");
        forEachSurface(
                snapshot,
                bodies,
                (surface, own, corners) -> {
                    for (int row : corners) {
                        box.add(position, position, row * 3L);
                    }
                });
    }

    /**
     * A function that is called for each visible surface, with its own colour and the rows of the
     * bodies at its corners.
     */
    private interface SurfaceVisitor {
        void visit(ItemId surface, Optional<Colour> colour, int[] corners);
    }

    private static void forEachSurface(
            WorldSnapshot snapshot, TableSnapshot bodies, SurfaceVisitor visitor) {
        var position = new Reals(bodies, "position");
        MemorySegment colour = bodies.column("colour").segment();
        for (TableSnapshot surfaces : snapshot.tables()) {
            if (!surfaces.kind().equals(WorldPrototype.SURFACE)) {
                continue;
            }
            ColumnView vertices = surfaces.column("vertices");
            int[] rows = new int[3];
            for (int row = 0; row < surfaces.rowCount(); row++) {
                ConnectionLook look = look(snapshot, surfaces, row);
                boolean seen = look.colour().isPresent();
                boolean complete = true;
                for (int corner = 0; corner < 3; corner++) {
                    rows[corner] = rowOf(bodies, vertices, row, corner);
                    complete &= rows[corner] >= 0 && position.isDrawable(3L * rows[corner]);
                    seen |= rows[corner] >= 0 && !isHidden(colour.getAtIndex(INT, rows[corner]));
                }
                if (seen && complete && !look.isHidden()) {
                    visitor.visit(surfaces.idAt(row), look.colour(), rows);
                }
            }
        }
    }

    private static ConnectionLook look(WorldSnapshot snapshot, TableSnapshot table, int row) {
        return snapshot.symbols().get(table.idAt(row)).look();
    }

    private static boolean isHidden(int rgba) {
        return rgba >>> 24 == 0;
    }

    private Scene read(WorldSnapshot snapshot) {
        Bounds bounds = bounds(snapshot).orElse(new Bounds(ORIGIN, ORIGIN));
        Camera from = camera.orElseGet(() -> Camera.fit(bounds, image.aspect()));
        var scene = new Scene(image, from, environment);
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        boolean hasPlane = addBodies(scene, bodies, snapshot);
        if (!hasPlane) {
            addGround(scene, bounds);
        }
        addSurfaces(scene, snapshot, bodies);
        for (TableSnapshot table : snapshot.tables()) {
            if (table.kind().equals(WorldPrototype.SPRING)) {
                addSprings(scene, snapshot, table, bodies);
            }
        }
        return scene;
    }

    /** Adds the visible bodies. Returns whether one of them is a plane. */
    private boolean addBodies(Scene scene, TableSnapshot bodies, WorldSnapshot snapshot) {
        int hidden = without.map(bodies::rowOf).orElse(-1);
        var position = new Reals(bodies, "position");
        var orientation = new Reals(bodies, "orientation");
        var size = new Reals(bodies, "size");
        MemorySegment shape = bodies.column("shape").segment();
        MemorySegment colour = bodies.column("colour").segment();
        boolean hasPlane = false;
        for (int row = 0; row < bodies.rowCount(); row++) {
            int code = shape.getAtIndex(INT, row);
            int rgba = colour.getAtIndex(INT, row);
            long at = row * 3L;
            if (code == Shape.NONE
                    || isHidden(rgba)
                    || row == hidden
                    || !position.isDrawable(at)
                    || !size.isDrawable(at)) {
                continue;
            }
            if (code == Shape.CAPSULE || code == Shape.CYLINDER) {
                var place = new Point(position.at(at), position.at(at + 1), position.at(at + 2));
                addRound(scene, bodies, row, place, snapshot.symbols().get(bodies.idAt(row)));
                continue;
            }
            for (Instances instances : looks(scene, snapshot.symbols().get(bodies.idAt(row)))) {
                instances.position(position.at(at), position.at(at + 1), position.at(at + 2));
                addOrientation(instances, orientation, row * 4L);
                if (code == Shape.MESH) {
                    instances.size(1, 1, 1);
                } else {
                    instances.size(size.at(at), size.at(at + 1), size.at(at + 2));
                }
                instances.colour(rgba);
                instances.flags(code == Shape.PLANE ? Instances.GRID : 0);
                instances.item(bodies.idAt(row).value());
            }
            hasPlane |= code == Shape.PLANE;
        }
        return hasPlane;
    }

    /** Adds a cylinder. A capsule is drawn as a cylinder and two balls. */
    private static void addRound(
            Scene scene, TableSnapshot bodies, int row, Point place, ItemSymbols item) {
        Material material = item.material().orElse(Material.DEFAULT);
        var orientation = new Reals(bodies, "orientation");
        var size = new Reals(bodies, "size");
        double across = size.at(row * 3L);
        double height = size.at(row * 3L + 1);
        int rgba = bodies.column("colour").segment().getAtIndex(INT, row);
        long id = bodies.idAt(row).value();
        boolean capsule = item.shape() instanceof Shape.Capsule;
        double middle = capsule ? Math.max(0, height - across) : height;
        Instances tube = scene.instances(Cylinder.MESH, material);
        tube.position(place.x(), place.y(), place.z());
        addOrientation(tube, orientation, row * 4L);
        tube.size(across, middle, across).colour(rgba).flags(0).item(id);
        if (!capsule) {
            return;
        }
        double x = orientation.at(row * 4L);
        double y = orientation.at(row * 4L + 1);
        double z = orientation.at(row * 4L + 2);
        double w = orientation.at(row * 4L + 3);
        // Column 2 of the rotation matrix: the body's +Y axis in the world.
        var axis = new Point(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x));
        for (double end : new double[] {-middle / 2, middle / 2}) {
            Point centre = place.plus(end, axis);
            Instances ball = scene.instances(Shape.SPHERE, material);
            ball.position(centre.x(), centre.y(), centre.z());
            addOrientation(ball, orientation, row * 4L);
            ball.size(across, across, across).colour(rgba).flags(0).item(id);
        }
    }

    /**
     * Returns the instances to which an item is added. A mesh with materials of its own has one
     * element for each part of the mesh. Any other item has one element.
     */
    private static List<Instances> looks(Scene scene, ItemSymbols item) {
        Material material = item.material().orElse(Material.DEFAULT);
        if (!(item.shape() instanceof Mesh mesh)) {
            // an ellipsoid is a sphere with three diameters
            boolean round = item.shape() instanceof Shape.Ellipsoid;
            int code = round ? Shape.SPHERE : item.shape().code();
            return List.of(scene.instances(code, material));
        }
        if (item.material().isPresent() || mesh.parts().isEmpty()) {
            return List.of(scene.instances(mesh, material));
        }
        return mesh.parts().stream().map(part -> scene.instances(mesh, part)).toList();
    }

    /**
     * Adds a normalized orientation, because rounding errors in laws may change the length of a
     * quaternion.
     */
    private static void addOrientation(Instances instances, Reals orientation, long at) {
        double x = orientation.at(at);
        double y = orientation.at(at + 1);
        double z = orientation.at(at + 2);
        double w = orientation.at(at + 3);
        double length = Math.sqrt(x * x + y * y + z * z + w * w);
        if (length > 0) {
            instances.orientation(x / length, y / length, z / length, w / length);
        } else {
            instances.orientation(0, 0, 0, 1);
        }
    }

    /**
     * Adds a ground below all items. The height of the ground is rounded, so that it does not move
     * when items move slightly.
     */
    private static void addGround(Scene scene, Bounds bounds) {
        double side = Math.max(bounds.longestSide(), 1e-3);
        if (GROUND_SIDE * side > FARTHEST) {
            return;
        }
        double low = bounds.low().y();
        double step = Math.pow(10, Math.floor(Math.log10(side)));
        double level = low >= 0 && low <= 2 * side ? 0 : Math.floor(low / step) * step;
        Point centre = bounds.centre();
        scene.instances(Shape.PLANE, Material.DEFAULT)
                .position(centre.x(), level, centre.z())
                .orientation(0, 0, 0, 1)
                .size(GROUND_SIDE * side, 0, GROUND_SIDE * side)
                .colour(GROUND_RGBA)
                .flags(Instances.GRID | Instances.FADE)
                .item(0);
    }

    private static void addSurfaces(Scene scene, WorldSnapshot snapshot, TableSnapshot bodies) {
        var position = new Reals(bodies, "position");
        MemorySegment colour = bodies.column("colour").segment();
        forEachSurface(
                snapshot,
                bodies,
                (surface, own, corners) -> {
                    scene.triangles().item(surface.value());
                    for (int row : corners) {
                        long at = 3L * row;
                        scene.triangles()
                                .corner(
                                        position.at(at),
                                        position.at(at + 1),
                                        position.at(at + 2),
                                        own.map(Colour::rgba)
                                                .orElseGet(() -> colour.getAtIndex(INT, row)));
                    }
                });
    }

    private void addSprings(
            Scene scene, WorldSnapshot snapshot, TableSnapshot springs, TableSnapshot bodies) {
        var position = new Reals(bodies, "position");
        ColumnView end1 = springs.column("end1");
        ColumnView end2 = springs.column("end2");
        float width = Math.clamp(image.height() * SPRING_WIDTH, 1.5f, 16f);
        for (int row = 0; row < springs.rowCount(); row++) {
            long from = 3L * rowOf(bodies, end1, row, 0);
            long to = 3L * rowOf(bodies, end2, row, 0);
            ConnectionLook look = look(snapshot, springs, row);
            if (from < 0
                    || to < 0
                    || look.isHidden()
                    || !(look.width() <= FARTHEST)
                    || !position.isDrawable(from)
                    || !position.isDrawable(to)) {
                continue;
            }
            long item = springs.idAt(row).value();
            int rgba = look.colour().orElse(ConnectionLook.SPRING_COLOUR).rgba();
            if (look.width() > 0) {
                addRod(scene, position.point(from), position.point(to), look.width())
                        .colour(rgba)
                        .flags(0)
                        .item(item);
                continue;
            }
            scene.segments(width)
                    .colour(rgba)
                    .item(item)
                    .from(position.at(from), position.at(from + 1), position.at(from + 2))
                    .to(position.at(to), position.at(to + 1), position.at(to + 2));
        }
    }

    /** Adds a cylinder between two points, without colour, flags and item. */
    private static Instances addRod(Scene scene, Point from, Point to, double width) {
        Point along = to.plus(-1, from);
        double length = Math.sqrt(along.dot(along));
        Point axis = length > 0 ? along.normalized() : new Point(0, 1, 0);
        Point middle = from.plus(0.5, along);
        Instances rod =
                scene.instances(Cylinder.MESH, Material.DEFAULT)
                        .position(middle.x(), middle.y(), middle.z())
                        .size(width, length, width);
        // The shortest rotation from +Y to the axis: half is the cosine of half its angle.
        double half = Math.sqrt((1 + axis.y()) / 2);
        return half > 1e-6
                ? rod.orientation(axis.z() / (2 * half), 0, -axis.x() / (2 * half), half)
                : rod.orientation(1, 0, 0, 0);
    }

    /** Returns the row of the referenced body; negative if there is none. */
    private static int rowOf(TableSnapshot bodies, ColumnView references, int row, int which) {
        long id = references.getReference(row, which);
        return id > 0 ? bodies.rowOf(new ItemId(id)) : -1;
    }

    private static Point point(double[] values) {
        return new Point(values[0], values[1], values[2]);
    }
}
