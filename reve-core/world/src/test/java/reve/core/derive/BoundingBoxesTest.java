// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.OffHeapArena;
import reve.core.world.Pose;
import reve.core.world.Shape;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.Random;

class BoundingBoxesTest {

    private static World world(String prototype) {
        return new World("test", WorldPrototype.standard(prototype), new OffHeapArena());
    }

    @ParameterizedTest
    @CsvSource({"si-f64, 1e-12", "si-f32, 1e-5"})
    void holdExactlyTheTurnedCornersOfEachShape(String prototype, double tolerance) {
        long seed = Seed.of("turned shapes in " + prototype);
        var random = new Random(seed);
        World world = world(prototype);
        for (int i = 0; i < 300; i++) {
            world.add(
                    ItemDefinition.named("b" + i)
                            .shape(shape(random, i % 4))
                            .at(number(random), number(random), number(random))
                            .orientation(number(random), number(random), number(random), 0.1)
                            .build());
        }
        new BoundingBoxes().update(world);
        for (Item item : world.items()) {
            if (!item.physical().isEmpty()) {
                double[][] expected = turnedCorners(item);
                assertThat(item.physical().boundsMin())
                        .as("seed %d %s", seed, item)
                        .containsExactly(expected[0], within(tolerance));
                assertThat(item.physical().boundsMax())
                        .as("seed %d %s", seed, item)
                        .containsExactly(expected[1], within(tolerance));
            }
        }
    }

    /**
     * The bounds enclose the rotated box of the mesh. After quarter turns, these are the smallest
     * possible bounds.
     */
    @ParameterizedTest
    @CsvSource({"si-f64, 1e-12", "si-f32, 1e-5"})
    void holdEveryVertexOfATurnedMeshAndTouchThemAfterQuarterTurns(
            String prototype, double tolerance) {
        long seed = Seed.of("turned meshes in " + prototype);
        var random = new Random(seed);
        World world = world(prototype);
        for (int i = 0; i < 100; i++) {
            boolean quarters = i % 2 == 0;
            double[] q =
                    quarters
                            ? quarterTurns(random)
                            : new double[] {
                                number(random), number(random), number(random), number(random)
                            };
            Item item =
                    world.add(
                            ItemDefinition.named("mesh" + i)
                                    .shape(mesh(random))
                                    .at(number(random), number(random), number(random))
                                    .orientation(q[0], q[1], q[2], q[3])
                                    .build());
            new BoundingBoxes().update(world);
            double[][] vertices = verticesInWorld(item);
            double[] low = item.physical().boundsMin();
            double[] high = item.physical().boundsMax();
            for (int axis = 0; axis < 3; axis++) {
                String what = "seed " + seed + " " + item + " axis " + axis;
                assertThat(low[axis]).as(what).isLessThanOrEqualTo(vertices[0][axis] + tolerance);
                assertThat(vertices[1][axis]).as(what).isLessThanOrEqualTo(high[axis] + tolerance);
                if (quarters) {
                    assertThat(low[axis]).as(what).isCloseTo(vertices[0][axis], within(tolerance));
                    assertThat(high[axis]).as(what).isCloseTo(vertices[1][axis], within(tolerance));
                }
            }
        }
    }

    /**
     * Returns the orientation after up to three quarter turns about random axes. {@code (1, 0, 0,
     * 1)} is one about x.
     */
    private static double[] quarterTurns(Random random) {
        double[] q = {0, 0, 0, 1};
        for (int turn = random.nextInt(4); turn > 0; turn--) {
            double[] next = new double[4];
            int x = random.nextInt(3);
            int y = (x + 1) % 3;
            int z = (x + 2) % 3;
            next[x] = q[x] + q[3];
            next[y] = q[y] - q[z];
            next[z] = q[z] + q[y];
            next[3] = q[3] - q[x];
            q = next;
        }
        return q;
    }

    /** Returns a mesh that is not at its centre. Its points are no corners of its own box. */
    private static Shape mesh(Random random) {
        float[] vertices = new float[3 * (3 + random.nextInt(30))];
        for (int i = 0; i < vertices.length; i++) {
            vertices[i] = random.nextFloat() * (1 + i % 3) + 2;
        }
        return Shape.mesh(vertices, new int[] {0, 1, 2});
    }

    /**
     * Returns the lowest and highest coordinates of all vertices. Rotates and moves each vertex
     * separately.
     */
    private static double[][] verticesInWorld(Item item) {
        double[] low = {Double.MAX_VALUE, Double.MAX_VALUE, Double.MAX_VALUE};
        double[] high = {-Double.MAX_VALUE, -Double.MAX_VALUE, -Double.MAX_VALUE};
        double[] at = item.physical().location();
        var vertices = ((Mesh) item.physical().shape()).vertices();
        while (vertices.hasRemaining()) {
            double[] turned =
                    turn(
                            item.physical().orientation(),
                            new double[] {vertices.get(), vertices.get(), vertices.get()});
            for (int axis = 0; axis < 3; axis++) {
                low[axis] = Math.min(low[axis], at[axis] + turned[axis]);
                high[axis] = Math.max(high[axis], at[axis] + turned[axis]);
            }
        }
        return new double[][] {low, high};
    }

    @Test
    void aQuarterTurnSwapsTheSidesOfABox() {
        World world = world("si-f64");
        double half = Math.sqrt(0.5);
        Item box =
                world.add(
                        ItemDefinition.named("box")
                                .shape(Shape.box(2, 4, 6))
                                .at(10, 0, 0)
                                .orientation(0, 0, half, half)
                                .build());
        new BoundingBoxes().update(world);
        assertThat(box.physical().boundsMin())
                .containsExactly(new double[] {8, -1, -3}, within(1e-12));
        assertThat(box.physical().boundsMax())
                .containsExactly(new double[] {12, 1, 3}, within(1e-12));
    }

    @Test
    void aShapelessItemIsAPointAndATurnedSphereStaysASphere() {
        World world = world("si-f64");
        Item point = world.add(ItemDefinition.named("point").at(1, 2, 3).build());
        Item ball =
                world.add(
                        ItemDefinition.named("ball")
                                .shape(Shape.sphere(2))
                                .at(1, 2, 3)
                                .orientation(1, 2, 3, 4)
                                .build());
        new BoundingBoxes().update(world);
        assertThat(point.physical().boundsMin()).containsExactly(1, 2, 3);
        assertThat(point.physical().boundsMax()).containsExactly(1, 2, 3);
        assertThat(ball.physical().boundsMin()).containsExactly(-1, 0, 1);
        assertThat(ball.physical().boundsMax()).containsExactly(3, 4, 5);
    }

    /** No point of the surface is outside, and one of many random points is near each side. */
    @Test
    void encloseATurnedEllipsoidTightly() {
        var random = new Random(5);
        World world = world("si-f64");
        Item egg =
                world.add(
                        ItemDefinition.named("egg")
                                .shape(Shape.ellipsoid(2, 1, 4))
                                .at(1, 2, 3)
                                .orientation(0.3, -0.5, 0.2, 0.7)
                                .build());
        new BoundingBoxes().update(world);
        double[] low = {9, 9, 9};
        double[] high = {-9, -9, -9};
        Pose pose = Pose.of(egg.physical().location(), egg.physical().orientation());
        for (int i = 0; i < 100_000; i++) {
            double[] at = {random.nextGaussian(), random.nextGaussian(), random.nextGaussian()};
            double length = Math.sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
            double[] point =
                    new Pose(at[0] / length, at[1] / length / 2, 2 * at[2] / length, 0, 0, 0, 1)
                            .within(pose)
                            .location();
            for (int axis = 0; axis < 3; axis++) {
                low[axis] = Math.min(low[axis], point[axis]);
                high[axis] = Math.max(high[axis], point[axis]);
            }
        }
        for (int axis = 0; axis < 3; axis++) {
            double min = egg.physical().boundsMin()[axis];
            double max = egg.physical().boundsMax()[axis];
            assertThat(low[axis]).isBetween(min - 1e-9, min + 2e-3);
            assertThat(high[axis]).isBetween(max - 2e-3, max + 1e-9);
        }
    }

    @Test
    void areKeptInEveryFrameFromFrameZeroOn() {
        World world = world("si-f64");
        Item ball = world.add(ItemDefinition.named("ball").shape(Shape.sphere(1)).build());
        var bus = new FrameBus();
        DerivedColumns.subscribeTo(bus);
        var loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
        loop.run(0);
        assertThat(ball.physical().boundsMax()).containsExactly(1, 1, 1);
        ball.physical().setLocation(5, 5, 5);
        assertThat(ball.physical().boundsMax()).containsExactly(1, 1, 1);
        loop.step();
        assertThat(ball.physical().boundsMax()).containsExactly(6, 6, 6);
    }

    private static Shape shape(Random random, int which) {
        return switch (which) {
            case 0 -> Shape.sphere(0.1 + random.nextDouble());
            case 1 -> Shape.box(0.1 + random.nextDouble(), 2, 0.1 + random.nextDouble());
            case 2 -> Shape.plane(0.1 + random.nextDouble(), 3);
            default ->
                    Shape.mesh(
                            new float[] {
                                1, 1, 1, 2, random.nextFloat(), 1, 1, 5, 3 + random.nextFloat()
                            },
                            new int[] {0, 1, 2});
        };
    }

    private static double number(Random random) {
        return random.nextDouble(-1, 1);
    }

    /**
     * Returns the lowest and highest coordinates of the eight rotated corners. The corners of a
     * sphere are not rotated.
     */
    private static double[][] turnedCorners(Item item) {
        double[] at = item.physical().location();
        Shape shape = item.physical().shape();
        double[] low = {Double.MAX_VALUE, Double.MAX_VALUE, Double.MAX_VALUE};
        double[] high = {-Double.MAX_VALUE, -Double.MAX_VALUE, -Double.MAX_VALUE};
        for (int corner = 0; corner < 8; corner++) {
            double[] own = new double[3];
            for (int axis = 0; axis < 3; axis++) {
                boolean upper = (corner >> axis & 1) == 1;
                double half = shape.size(axis) / 2;
                own[axis] =
                        shape instanceof Mesh mesh
                                ? (upper ? mesh.max(axis) : mesh.min(axis))
                                : upper ? half : -half;
            }
            double[] turned =
                    shape instanceof Shape.Sphere ? own : turn(item.physical().orientation(), own);
            for (int axis = 0; axis < 3; axis++) {
                low[axis] = Math.min(low[axis], at[axis] + turned[axis]);
                high[axis] = Math.max(high[axis], at[axis] + turned[axis]);
            }
        }
        return new double[][] {low, high};
    }

    /** v + 2 u x (u x v + w v), the definition of the rotation by a unit quaternion (u, w). */
    private static double[] turn(double[] q, double[] v) {
        double[] u = {q[0], q[1], q[2]};
        double[] inner = cross(u, v);
        for (int i = 0; i < 3; i++) {
            inner[i] += q[3] * v[i];
        }
        double[] outer = cross(u, inner);
        return new double[] {v[0] + 2 * outer[0], v[1] + 2 * outer[1], v[2] + 2 * outer[2]};
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }
}
