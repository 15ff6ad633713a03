// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;
import reve.core.derive.BoundingBoxes;
import reve.core.space.Effort;
import reve.core.space.LocalRay;
import reve.core.space.TriangleIndex;
import reve.core.world.Column;
import reve.core.world.Instrument;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Random;

/**
 * All distances of lidars are equal, to the bit, to the least distance to any shape on the ray. The
 * test computes this distance for each ray and each shape, without any search.
 */
class LidarScanTest {
    private static final double RANGE = 30;
    private static final double NOTHING = -1;

    private static final Instrument.Lidar[] LIDARS = {
        new Instrument.Lidar(64, 16, Sensor.ALL_ROUND, Math.toRadians(40), RANGE, 0, 0),
        new Instrument.Lidar(31, 17, Sensor.ALL_ROUND, Math.PI, RANGE, 0, 0),
        new Instrument.Lidar(360, 1, Sensor.ALL_ROUND, 0, RANGE, 0, 0),
        new Instrument.Lidar(90, 4, Math.toRadians(359), Math.toRadians(3), RANGE, 0, 0),
        new Instrument.Lidar(24, 24, Math.toRadians(2), Math.toRadians(2), RANGE, 0, 0),
        new Instrument.Lidar(1, 200, 0, Math.PI, RANGE, 0, 0),
        new Instrument.Lidar(40, 12, Math.toRadians(200), Math.toRadians(170), 6, 0, 0),
        new Instrument.Lidar(LidarScanner.FEW_RAYS - 1, 1, 2, 0, RANGE, 0, 0),
    };

    private final Random random;

    LidarScanTest() {
        random = new Random(Seed.of("lidars", 20));
    }

    /**
     * @param spread half the edge of the cube that contains the items [m]
     * @param of size of the items [m]
     */
    @ParameterizedTest
    @CsvSource({
        "si-f64, 200, 13, 2",
        "si-f32, 200, 13, 2",
        "si-f64, 40, 1.5, 2",
        "si-f64, 250, 10, 0.2",
        "si-f32, 250, 10, 0.2",
        "si-f64, 2, 3, 2",
        "si-f64, 60, 10, 20"
    })
    void distancesAreThoseToTheNearestShapes(String reals, int items, double spread, double of) {
        for (Instrument.Lidar lidar : LIDARS) {
            compare(reals, items, spread, of, lidar);
        }
    }

    /** A tower of balls above and below the lidar, whose rows end at the poles. */
    @Test
    void ballsAboveAndBelowAreMet() {
        var lidar = new Instrument.Lidar(16, 33, Sensor.ALL_ROUND, Math.PI, RANGE, 0, 0);
        List<ItemDefinition> items = new ArrayList<>();
        for (int i = 1; i < 9; i++) {
            items.add(item(i, Shape.sphere(0.5)).at(0.1 * i - 0.5, 2 * i, 0.05 * i).build());
            items.add(item(-i, Shape.sphere(0.7)).at(0.3 - 0.1 * i, -2 * i, 0).build());
        }
        var body = ItemDefinition.named("body").sensor(Sensor.measuring("scan", lidar)).build();
        assertThat(compare("si-f64", body, items, lidar)).isGreaterThan(60);
    }

    private void compare(String reals, int items, double spread, double of, Instrument.Lidar ar) {
        List<ItemDefinition> all = new ArrayList<>();
        for (int i = 0; i < items; i++) {
            double[] turn = quaternion();
            all.add(
                    item(i, shape(i, of))
                            .at(within(spread), within(spread), within(spread))
                            .orientation(turn[0], turn[1], turn[2], turn[3])
                            .build());
        }
        double[] turn = random.nextInt(3) == 0 ? new double[] {0, 0, 0, 1} : quaternion();
        var body =
                ItemDefinition.named("body")
                        .shape(Shape.box(1, 1, 1))
                        .at(within(1), within(1), within(1))
                        .orientation(turn[0], turn[1], turn[2], turn[3])
                        .sensor(Sensor.measuring("scan", ar))
                        .build();
        compare(reals, body, all, ar);
    }

    /** Returns the number of rays that met a shape. */
    private static int compare(
            String reals, ItemDefinition body, List<ItemDefinition> items, Instrument.Lidar lidar) {
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard(reals), arena);
            Item eye = world.add(body);
            items.forEach(world::add);
            var ring = new SnapshotRing(world, 2);
            new BoundingBoxes().update(world);
            ring.publish(1, 1);
            var observatory = new Observatory();
            try (var snapshot = ring.acquireLatest().orElseThrow()) {
                assertThat(observatory.read(snapshot)).isTrue();
            }
            View view = new Senses(eye.id(), body.sensors()).look(observatory);
            double[] found = view.readings().getFirst().quantities().getFirst().numbers();
            double[] expected = nearest(world.table(WorldPrototype.BODY), eye, lidar);
            assertThat(found).as("%s of %d items", lidar, items.size()).containsExactly(expected);
            int met = 0;
            for (double distance : expected) {
                met += distance == NOTHING ? 0 : 1;
            }
            return met;
        }
    }

    private static double[] nearest(Table bodies, Item eye, Instrument.Lidar lidar) {
        int own = bodies.rowOf(eye.id());
        double[] from = place(bodies, own);
        double[] least = new double[lidar.rays()];
        Arrays.fill(least, NOTHING);
        var ray = new LocalRay();
        for (int row = 0; row < bodies.rowCount(); row++) {
            double[] place = place(bodies, row);
            Shape shape = bodies.shapeAt(row);
            TriangleIndex mesh =
                    shape instanceof Mesh one
                            ? new TriangleIndex(one.vertices(), one.triangles())
                            : null;
            for (int i = 0; i < lidar.rays() && row != own; i++) {
                ray.set(from, direction(lidar, i, from), place);
                double distance = mesh == null ? distance(ray, shape) : distance(ray, mesh);
                if (distance <= lidar.range() && !(least[i] >= 0 && least[i] <= distance)) {
                    least[i] = distance;
                }
            }
        }
        return least;
    }

    private static double distance(LocalRay ray, TriangleIndex mesh) {
        var effort = new Effort();
        effort.begin(1000);
        return mesh.distance(ray, RANGE, effort);
    }

    private static double distance(LocalRay ray, Shape shape) {
        double x = 0.5 * shape.size(0);
        double y = 0.5 * shape.size(1);
        double z = 0.5 * shape.size(2);
        return switch (shape.code()) {
            case Shape.SPHERE -> ray.toSphere(x);
            case Shape.BOX -> ray.toBox(x, y, z);
            case Shape.PLANE -> ray.toPlane(x, z);
            case Shape.CAPSULE -> ray.toCapsule(x, y);
            case Shape.CYLINDER -> ray.toCylinder(x, y);
            case Shape.ELLIPSOID -> ray.toEllipsoid(x, y, z);
            default -> Double.POSITIVE_INFINITY;
        };
    }

    /** Returns the direction of a ray in the axes of the world. */
    private static double[] direction(Instrument.Lidar lidar, int i, double[] own) {
        double side = lidar.sideways(i % lidar.columns());
        double up = lidar.upwards(i / lidar.columns());
        double x = StrictMath.sin(side) * StrictMath.cos(up);
        double y = StrictMath.sin(up);
        double z = StrictMath.cos(side) * StrictMath.cos(up);
        double cx = 2 * (own[4] * z - own[5] * y);
        double cy = 2 * (own[5] * x - own[3] * z);
        double cz = 2 * (own[3] * y - own[4] * x);
        return new double[] {
            x + own[6] * cx + (own[4] * cz - own[5] * cy),
            y + own[6] * cy + (own[5] * cx - own[3] * cz),
            z + own[6] * cz + (own[3] * cy - own[4] * cx)
        };
    }

    private static double[] place(Table bodies, int row) {
        double[] place = new double[7];
        Column position = bodies.column("position");
        Column orientation = bodies.column("orientation");
        for (int i = 0; i < 7; i++) {
            place[i] = i < 3 ? position.getDouble(row, i) : orientation.getDouble(row, i - 3);
        }
        return place;
    }

    private static ItemDefinition.Builder item(int number, Shape shape) {
        return ItemDefinition.named("item " + number).shape(shape);
    }

    private Shape shape(int i, double of) {
        double a = of * (0.1 + random.nextDouble());
        double b = of * (0.1 + random.nextDouble());
        return switch (i % 10) {
            case 0, 1 -> Shape.sphere(0.5 * a);
            case 2 -> Shape.box(a, b, of * random.nextDouble() + 0.01);
            case 3 -> Shape.plane(a, b);
            case 4 -> Shape.capsule(0.3 * a, 0.6 * a + b);
            case 5 -> Shape.cylinder(0.5 * a, b);
            case 6 -> Shape.box(0.05 * of, 8 * a, 0.1 * of); // long
            case 7 -> Shape.none();
            case 8 -> Shape.ellipsoid(a, b, 0.1 * of);
            default -> pyramid((float) a);
        };
    }

    private static Shape pyramid(float of) {
        return Shape.mesh(
                new float[] {0, 0, 0, of, 0, 0, 0, of, 0, 0, 0, of},
                new int[] {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
    }

    private double within(double most) {
        return most * (2 * random.nextDouble() - 1);
    }

    private double[] quaternion() {
        double[] turn = new double[4];
        double square = 0;
        for (int i = 0; i < 4; i++) {
            turn[i] = random.nextGaussian();
            square += turn[i] * turn[i];
        }
        for (int i = 0; i < 4; i++) {
            turn[i] /= Math.sqrt(square);
        }
        return turn;
    }
}
