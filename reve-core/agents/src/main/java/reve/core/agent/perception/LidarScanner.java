// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.space.BoxIndex;
import reve.core.space.LocalRay;
import reve.core.space.TriangleIndex;
import reve.core.world.Instrument;
import reve.core.world.ItemId;
import reve.core.world.Mesh;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.TableView;

import java.util.Arrays;
import java.util.HashMap;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.function.BooleanSupplier;
import java.util.function.IntFunction;

/**
 * The rays of lidars in one frame. A ray meets the shapes of all bodies except the lidar's own
 * body. For one thread.
 */
final class LidarScanner {

    /** Number of rays that are cast between two checks of the clock. */
    private static final int RAYS = 32;

    /** Value that represents a ray that met nothing, in messages. */
    private static final double NOTHING = -1;

    private final SensedWorld bodies;
    private final IntFunction<Shape> shapes;
    private final LocalRay ray = new LocalRay();
    private final double[] own = new double[7];
    private final double[] place = new double[7];
    private final double[] direction = new double[3];
    private final BoxIndex.RayTest test = this::distance;

    /** The triangles of the meshes that rays have met; only meshes of existing items. */
    private Map<Mesh, TriangleIndex> meshes = new IdentityHashMap<>();

    /** Directions of the rays of each lidar in the axes of its body, (rays x 3). */
    private final Map<Instrument.Lidar, double[]> directions = new HashMap<>();

    private double[] size = {};
    private boolean wanted;
    private int looker;

    /**
     * @param shapes returns the shape of the body in a row
     */
    LidarScanner(SensedWorld bodies, IntFunction<Shape> shapes) {
        this.bodies = bodies;
        this.shapes = shapes;
    }

    /** Notes that frames are needed from now on if one of the sensors is a lidar. */
    void expect(List<Sensor> sensors) {
        for (int i = 0; i < sensors.size(); i++) {
            wanted |= sensors.get(i).instrument().orElse(null) instanceof Instrument.Lidar;
        }
    }

    /** Forgets the meshes of items that do not exist any more. */
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
     * @param scan the progress; the caller keeps it from call to call
     * @return false if the time was too short; the next call in this frame continues
     */
    boolean scan(Instrument.Lidar lidar, int row, Scan scan, BooleanSupplier isTimeLeft) {
        scan.begin(bodies.moment(), lidar.rays());
        double[] rays = directions.computeIfAbsent(lidar, LidarScanner::directions);
        bodies.copyPlace(row, own);
        looker = row;
        BoxIndex index = bodies.index();
        for (; scan.cast < lidar.rays(); scan.cast++) {
            if (scan.cast % RAYS == RAYS - 1 && !isTimeLeft.getAsBoolean()) {
                return false;
            }
            turn(rays, 3 * scan.cast);
            scan.distances[scan.cast] = index.nearestOnRay(own, direction, lidar.range(), test);
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

    /** Returns the directions row by row: from below to above, and from -X to +X. */
    private static double[] directions(Instrument.Lidar lidar) {
        double[] all = new double[3 * lidar.rays()];
        for (int i = 0; i < lidar.rays(); i++) {
            double side = lidar.sideways(i % lidar.columns());
            double up = lidar.upwards(i / lidar.columns());
            all[3 * i] = StrictMath.sin(side) * StrictMath.cos(up);
            all[3 * i + 1] = StrictMath.sin(up);
            all[3 * i + 2] = StrictMath.cos(side) * StrictMath.cos(up);
        }
        return all;
    }

    /** Converts a direction from the axes of the lidar's body to those of the world. */
    private void turn(double[] rays, int at) {
        double x = rays[at];
        double y = rays[at + 1];
        double z = rays[at + 2];
        double cx = 2 * (own[4] * z - own[5] * y);
        double cy = 2 * (own[5] * x - own[3] * z);
        double cz = 2 * (own[3] * y - own[4] * x);
        direction[0] = x + own[6] * cx + (own[4] * cz - own[5] * cy);
        direction[1] = y + own[6] * cy + (own[5] * cx - own[3] * cz);
        direction[2] = z + own[6] * cz + (own[3] * cy - own[4] * cx);
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
        return switch (shape) {
            case Shape.SPHERE -> ray.toSphere(x);
            case Shape.BOX -> ray.toBox(x, y, z);
            case Shape.PLANE -> ray.toPlane(x, z);
            case Shape.CAPSULE -> ray.toCapsule(x, y);
            case Shape.CYLINDER -> ray.toCylinder(x, y);
            case Shape.MESH -> triangles((Mesh) shapes.apply(row)).distance(ray, most);
            default -> throw new IllegalStateException("shape " + shape + " is unknown");
        };
    }

    private TriangleIndex triangles(Mesh mesh) {
        return meshes.computeIfAbsent(
                mesh, unknown -> new TriangleIndex(mesh.vertices(), mesh.triangles()));
    }
}
