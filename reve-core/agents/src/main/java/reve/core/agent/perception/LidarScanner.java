// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.space.BoxIndex;
import reve.core.space.BoxWalk;
import reve.core.space.Effort;
import reve.core.space.LocalRay;
import reve.core.space.TriangleIndex;
import reve.core.world.Instrument;
import reve.core.world.ItemId;
import reve.core.world.Mesh;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.TableView;

import java.lang.foreign.MemorySegment;
import java.util.Arrays;
import java.util.HashMap;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.function.BooleanSupplier;
import java.util.function.IntFunction;

/**
 * The rays of lidars in one frame. A ray meets the shapes of all bodies except the lidar's own
 * body. For one thread.
 *
 * <p>A scan walks through the tree of boxes once for all rays, from near to far. It tests each
 * shape with the rays that may meet the ball around the shape, and skips what lies behind the
 * shapes that these rays have met. Long shapes and meshes are tested last, ray by ray, because the
 * balls around them are much larger than the shapes. This order does not affect the measured
 * distances: each of them is the minimum of the exact distances to the shapes on the ray.
 */
final class LidarScanner {

    /** Number of rays below which a scan searches ray by ray only. */
    static final int FEW_RAYS = 8;

    /** Number of boxes per ray above which a scan searches ray by ray only. */
    static final int BOXES_PER_RAY = 256;

    /** Maximum number of rays that are cast between two checks of the clock. */
    private static final int RAYS = 32;

    /** Number of tests of a node, or of a ray with a shape, between two checks of the clock. */
    private static final int TESTS = 128;

    /**
     * Number of boxes and triangles that are examined between two checks of the clock; the ray that
     * exceeds the number is completed.
     */
    private static final int EXAMINED = 4_000;

    /**
     * Maximum number of boxes and triangles that one ray examines in a search ray by ray, which
     * takes a few milliseconds. A ray that would have to examine more, because very many shapes
     * overlap, measures nothing.
     */
    static final int MOST_OF_RAY = 100_000;

    /** Distance in messages for a ray that has met no shape. */
    private static final double NOTHING = -1;

    /**
     * Bound on the deviation of a squared quaternion from 1. The walk assumes that orientations are
     * rotations. Bodies with other orientations are tested ray by ray.
     */
    private static final double UNIT = 1e-6;

    /** Bound on the relative error of a distance to a node, with orientations in f32. */
    private static final double ROUNDING = 1e-5;

    /**
     * Maximum number of rays for which the walk checks whether a node is behind the shapes that the
     * rays have met.
     */
    private static final int HIDDEN = 64;

    /** A shape is long if its longest edge is this many times as long as the next one. */
    private static final double LONG = 4;

    private final SensedWorld bodies;
    private final IntFunction<Shape> shapes;
    private final LocalRay ray = new LocalRay();
    private final double[] own = new double[7];
    private final double[] place = new double[7];
    private final double[] direction = new double[3];
    private final BoxIndex.RayTest test = this::distance;
    private final Effort effort = new Effort();

    /** The triangles of the meshes that rays have met; only meshes of existing items. */
    private Map<Mesh, TriangleIndex> meshes = new IdentityHashMap<>();

    private final Map<Instrument.Lidar, RayGrid> grids = new HashMap<>();

    private double[] size = {};

    // Boxes of the bodies that are tested ray by ray.
    private double[] corners = {};
    private double[] otherCorners = {};
    private long[] keys = {};

    private boolean wanted;
    private int looker;

    /** Number of triangles for which the current ray had to build an index. */
    private long indexed;

    /**
     * @param shapes returns the shape of the body in a row
     */
    LidarScanner(SensedWorld bodies, IntFunction<Shape> shapes) {
        this.bodies = bodies;
        this.shapes = shapes;
    }

    /**
     * Records whether one of the sensors is a lidar. If so, the shapes of each later frame are
     * copied.
     */
    void expect(List<Sensor> sensors) {
        for (int i = 0; i < sensors.size(); i++) {
            wanted |= sensors.get(i).instrument().orElse(null) instanceof Instrument.Lidar;
        }
    }

    /**
     * Discards the meshes of items that do not exist.
     *
     * @param present the existing items
     */
    void keep(List<EncodedItem> present) {
        if (!meshes.isEmpty()) {
            Map<Mesh, TriangleIndex> kept = new IdentityHashMap<>();
            for (EncodedItem item : present) {
                Shape shape = item.source().shape();
                TriangleIndex known = shape instanceof Mesh mesh ? meshes.get(mesh) : null;
                if (known != null) {
                    kept.put((Mesh) shape, known);
                }
            }
            meshes = kept;
        }
    }

    /** Copies the sizes of the shapes of a frame, if a lidar exists. */
    void read(TableView table) {
        if (wanted) {
            int numbers = 3 * table.rowCount();
            if (size.length < numbers) {
                size = new double[numbers + numbers / 2];
            }
            SensedWorld.read(table.column("size"), size, 0, numbers);
        }
    }

    /**
     * Casts the rays of a lidar from the body in a row.
     *
     * @param scan the progress of the scan, which the caller keeps between calls
     * @return false if the time was too short; the next call in this frame continues
     */
    boolean scan(Instrument.Lidar lidar, int row, Scan scan, BooleanSupplier isTimeLeft) {
        RayGrid grid = grids.computeIfAbsent(lidar, RayGrid::new);
        scan.begin(bodies.moment(), lidar.rays());
        bodies.copyPlace(row, own);
        looker = row;
        if (scan.phase == Scan.Phase.BEGIN) {
            begin(grid, scan);
        }
        if (scan.phase == Scan.Phase.SHAPES) {
            if (!testShapes(lidar, grid, scan, isTimeLeft)) {
                return false;
            }
            scan.phase = scan.leftCount == 0 ? Scan.Phase.END : Scan.Phase.RAYS;
            if (scan.leftCount > 0) {
                indexRest(scan);
            }
        }
        if (scan.phase != Scan.Phase.END && !castRays(lidar, scan, isTimeLeft)) {
            return false;
        }
        scan.phase = Scan.Phase.END;
        return true;
    }

    private void begin(RayGrid grid, Scan scan) {
        double[] rays = grid.directions();
        for (int at = 0; at < rays.length; at += 3) {
            turn(rays, at, scan.directions);
        }
        int rayCount = scan.distances.length;
        if (rayCount < FEW_RAYS
                || bodies.index().size() > BOXES_PER_RAY * rayCount
                || !isRotation(own)) {
            scan.phase = Scan.Phase.ALL;
            return;
        }
        BoxWalk walk = scan.walk;
        if (walk == null) {
            walk = new BoxWalk();
            scan.walk = walk;
        }
        walk.begin(bodies.index(), own);
        scan.phase = Scan.Phase.SHAPES;
    }

    private static boolean isRotation(double[] place) {
        double square =
                place[3] * place[3]
                        + place[4] * place[4]
                        + place[5] * place[5]
                        + place[6] * place[6];
        return Math.abs(square - 1) <= UNIT && Math.abs(place[0] + place[1] + place[2]) < 1e100;
    }

    private boolean testShapes(
            Instrument.Lidar lidar, RayGrid grid, Scan scan, BooleanSupplier isTimeLeft) {
        BoxIndex index = bodies.index();
        BoxWalk walk = Objects.requireNonNull(scan.walk);
        int tests = 0;
        while (walk.next(index)) {
            tests++;
            if (walk.distance() * (1 - ROUNDING) <= lidar.range()) {
                if (walk.isBox(index)) {
                    tests += testShape((int) walk.key(index), lidar.range(), grid, scan);
                } else if (isWorthEntering(walk, grid, scan)) {
                    walk.enter(index);
                }
            }
            if (tests >= TESTS) {
                if (!isTimeLeft.getAsBoolean()) {
                    return false;
                }
                tests = 0;
            }
        }
        return true;
    }

    /**
     * Returns whether a ray may meet a shape in a node, nearer than the shapes that the ray has
     * met.
     */
    private boolean isWorthEntering(BoxWalk walk, RayGrid grid, Scan scan) {
        if (!find(grid, walk.centreX(), walk.centreY(), walk.centreZ(), walk.radius())) {
            return false;
        }
        if (grid.found() > HIDDEN) {
            return true;
        }
        double nearest = walk.distance() * (1 - ROUNDING);
        for (int row = grid.firstRow(); row <= grid.lastRow(); row++) {
            for (int part = 0; part < grid.parts(); part++) {
                int last = grid.lastRay(row, part);
                for (int i = grid.firstRay(row, part); i <= last; i++) {
                    if (scan.distances[i] >= nearest) {
                        return true;
                    }
                }
            }
        }
        return false;
    }

    /** Finds the rays that may meet a ball, see {@link RayGrid#find}. */
    private boolean find(RayGrid grid, double x, double y, double z, double radius) {
        double a = x - own[0];
        double b = y - own[1];
        double c = z - own[2];
        double ux = -own[3];
        double uy = -own[4];
        double uz = -own[5];
        double w = own[6];
        double cx = 2 * (uy * c - uz * b);
        double cy = 2 * (uz * a - ux * c);
        double cz = 2 * (ux * b - uy * a);
        // Centre and radius of a node have errors that are proportional to its coordinates.
        double error = 1e-12 * (Math.abs(x) + Math.abs(y) + Math.abs(z));
        return grid.find(
                a + w * cx + (uy * cz - uz * cy),
                b + w * cy + (uz * cx - ux * cz),
                c + w * cz + (ux * cy - uy * cx),
                radius + error);
    }

    /** Tests a shape with the rays that may meet it. Returns the number of tests. */
    private int testShape(int row, double range, RayGrid grid, Scan scan) {
        int shape = bodies.shape(row);
        if (row == looker || shape == Shape.NONE) {
            return 0;
        }
        bodies.copyPlace(row, place);
        double x = 0.5 * size[3 * row];
        double y = 0.5 * size[3 * row + 1];
        double z = 0.5 * size[3 * row + 2];
        if (shape == Shape.MESH || !isRotation(place)) {
            scan.leave(row);
            return 0;
        }
        double radius = shape == Shape.SPHERE ? x : Math.sqrt(x * x + y * y + z * z);
        if (!find(grid, place[0], place[1], place[2], radius)) {
            return 0;
        }
        if (isLong(shape, x, y, z) && grid.found() > RAYS) {
            scan.leave(row);
            return 0;
        }
        double toX = place[0] - own[0];
        double toY = place[1] - own[1];
        double toZ = place[2] - own[2];
        double r = grid.foundRadius();
        double square = r * r;
        double nearest = Math.sqrt(toX * toX + toY * toY + toZ * toZ) - r;
        double[] distances = scan.distances;
        double[] directions = scan.directions;
        ray.setOrigin(own, place);
        for (int line = grid.firstRow(); line <= grid.lastRow(); line++) {
            for (int part = 0; part < grid.parts(); part++) {
                int last = grid.lastRay(line, part);
                for (int i = grid.firstRay(line, part); i <= last; i++) {
                    double dx = directions[3 * i];
                    double dy = directions[3 * i + 1];
                    double dz = directions[3 * i + 2];
                    double px = toY * dz - toZ * dy;
                    double py = toZ * dx - toX * dz;
                    double pz = toX * dy - toY * dx;
                    if (distances[i] < nearest || px * px + py * py + pz * pz > square) {
                        continue;
                    }
                    ray.setDirection(directions, 3 * i, place);
                    double distance = simple(shape, x, y, z);
                    if (distance <= range && distance < distances[i]) {
                        distances[i] = distance;
                    }
                }
            }
        }
        return grid.found();
    }

    private static boolean isLong(int shape, double x, double y, double z) {
        if (shape == Shape.SPHERE) {
            return false;
        }
        double most = Math.max(x, Math.max(y, z));
        double least = Math.min(x, Math.min(y, z));
        return most > LONG * (x + y + z - most - least);
    }

    /** Builds the index of the bodies that remain to be tested with the rays. */
    private void indexRest(Scan scan) {
        int count = scan.leftCount;
        if (corners.length < 3 * count) {
            corners = new double[6 * count];
            otherCorners = new double[6 * count];
            keys = new long[2 * count];
        }
        for (int i = 0; i < count; i++) {
            keys[i] = scan.left[i];
            bodies.copyBox(scan.left[i], corners, otherCorners, 3 * i);
        }
        BoxIndex rest = scan.rest;
        if (rest == null) {
            rest = new BoxIndex();
            scan.rest = rest;
        }
        rest.build(
                MemorySegment.ofArray(keys),
                MemorySegment.ofArray(corners),
                MemorySegment.ofArray(otherCorners),
                count);
    }

    private boolean castRays(Instrument.Lidar lidar, Scan scan, BooleanSupplier isTimeLeft) {
        BoxIndex index =
                scan.phase == Scan.Phase.ALL ? bodies.index() : Objects.requireNonNull(scan.rest);
        long examined = 0;
        for (; scan.cast < lidar.rays(); scan.cast++) {
            if (examined >= EXAMINED || scan.cast % RAYS == RAYS - 1) {
                if (!isTimeLeft.getAsBoolean()) {
                    return false;
                }
                examined = 0;
            }
            System.arraycopy(scan.directions, 3 * scan.cast, direction, 0, 3);
            effort.begin(MOST_OF_RAY);
            indexed = 0;
            double known = scan.distances[scan.cast];
            double found =
                    index.nearestOnRay(
                            own, direction, Math.min(known, lidar.range()), test, effort);
            scan.distances[scan.cast] =
                    effort.left() < 0 ? Double.POSITIVE_INFINITY : Math.min(known, found);
            examined += MOST_OF_RAY - effort.left() + indexed;
        }
        return true;
    }

    /** Returns the reading of a complete scan, with noise. */
    Reading reading(
            Sensor sensor,
            Instrument.Lidar lidar,
            ItemId body,
            Scan scan,
            long frame,
            double time) {
        var noise = new MeasurementNoise(lidar.seed(), body, sensor.name(), time);
        double[] measured = Arrays.copyOf(scan.distances, lidar.rays());
        for (int i = 0; i < measured.length; i++) {
            double error = lidar.noise() == 0 ? 0 : noise.next(lidar.noise());
            measured[i] = measured[i] <= lidar.range() ? Math.max(0, measured[i] + error) : NOTHING;
        }
        return new Reading(
                sensor.name(),
                frame,
                List.of(new Reading.Quantity("distances", measured)),
                lidar.columns());
    }

    /** Converts a direction from the axes of the lidar's body to those of the world. */
    private void turn(double[] rays, int at, double[] turned) {
        double x = rays[at];
        double y = rays[at + 1];
        double z = rays[at + 2];
        double cx = 2 * (own[4] * z - own[5] * y);
        double cy = 2 * (own[5] * x - own[3] * z);
        double cz = 2 * (own[3] * y - own[4] * x);
        turned[at] = x + own[6] * cx + (own[4] * cz - own[5] * cy);
        turned[at + 1] = y + own[6] * cy + (own[5] * cx - own[3] * cz);
        turned[at + 2] = z + own[6] * cz + (own[3] * cy - own[4] * cx);
    }

    private double distance(long key, double most) {
        int row = (int) key;
        int shape = bodies.shape(row);
        if (row == looker || shape == Shape.NONE) {
            return Double.POSITIVE_INFINITY;
        }
        bodies.copyPlace(row, place);
        ray.set(own, direction, place);
        double x = 0.5 * size[3 * row];
        double y = 0.5 * size[3 * row + 1];
        double z = 0.5 * size[3 * row + 2];
        return shape == Shape.MESH
                ? triangles((Mesh) shapes.apply(row)).distance(ray, most, effort)
                : simple(shape, x, y, z);
    }

    /**
     * Returns the distance along the ray to a shape other than a mesh. Computes it from half
     * extents.
     */
    private double simple(int shape, double x, double y, double z) {
        return switch (shape) {
            case Shape.SPHERE -> ray.toSphere(x);
            case Shape.BOX -> ray.toBox(x, y, z);
            case Shape.PLANE -> ray.toPlane(x, z);
            case Shape.CAPSULE -> ray.toCapsule(x, y);
            case Shape.CYLINDER -> ray.toCylinder(x, y);
            case Shape.ELLIPSOID -> ray.toEllipsoid(x, y, z);
            default -> throw new IllegalStateException("shape " + shape + " is unknown");
        };
    }

    private TriangleIndex triangles(Mesh mesh) {
        TriangleIndex known = meshes.get(mesh);
        if (known == null) {
            known = new TriangleIndex(mesh.vertices(), mesh.triangles());
            meshes.put(mesh, known);
            indexed += mesh.triangles().remaining() / 3;
        }
        return known;
    }
}
