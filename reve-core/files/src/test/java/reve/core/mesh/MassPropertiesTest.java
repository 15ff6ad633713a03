// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.world.Mesh;
import reve.core.world.Shape;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;

class MassPropertiesTest {

    private static final int[] CUBE = {
        0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1,
        3, 7, 1, 7, 5
    };

    /**
     * Returns a box with this corner. Bits 0, 1 and 2 of a vertex's number select the end of x, y
     * and z.
     */
    private static Mesh box(double x, double y, double z, double... size) {
        float[] vertices = new float[24];
        for (int i = 0; i < 8; i++) {
            vertices[3 * i] = (float) (x + (i & 1) * size[0]);
            vertices[3 * i + 1] = (float) (y + (i >> 1 & 1) * size[1]);
            vertices[3 * i + 2] = (float) (z + (i >> 2) * size[2]);
        }
        return new Mesh(vertices, CUBE);
    }

    private static void assertClose(double[] found, double... expected) {
        for (int i = 0; i < expected.length; i++) {
            assertThat(found[i]).isCloseTo(expected[i], within(1e-6 * Math.max(1, expected[i])));
        }
    }

    @Test
    void solidsOfClosedForm() {
        MassProperties ball = MassProperties.of(Shape.sphere(0.5), 1000);
        assertThat(ball.mass()).isCloseTo(523.5987755982989, within(1e-9));
        assertClose(ball.moments(), 52.35987755982989, 52.35987755982989, 52.35987755982989);
        MassProperties brick = MassProperties.of(Shape.box(1, 2, 3), 10);
        assertThat(brick.volume()).isEqualTo(6);
        assertClose(brick.moments(), 65, 50, 25);
        MassProperties drum = MassProperties.of(Shape.cylinder(2, 3), 1 / (12 * Math.PI));
        assertThat(drum.mass()).isCloseTo(1, within(1e-12));
        assertClose(drum.moments(), 21 / 12.0, 2, 21 / 12.0);
    }

    /** A capsule of length 0 equals a ball, and a long thin capsule nearly equals a rod. */
    @Test
    void aCapsuleIsBetweenABallAndARod() {
        MassProperties ball = MassProperties.of(Shape.sphere(0.5), 1000);
        MassProperties capsule = MassProperties.of(Shape.capsule(0.5, 1), 1000);
        assertThat(capsule.mass()).isCloseTo(ball.mass(), within(1e-9));
        assertClose(capsule.moments(), ball.moments());
        MassProperties rod = MassProperties.of(Shape.cylinder(0.01, 10), 1000);
        MassProperties lens = MassProperties.of(Shape.capsule(0.01, 10), 1000);
        assertThat(lens.moments()[0] / rod.moments()[0]).isCloseTo(1, within(5e-3));
    }

    /** The expected moments of a capsule are sums over thin discs. */
    @Test
    void aCapsuleHasTheMomentsOfItsDiscs() {
        double radius = 0.3;
        double height = 1.4;
        int discs = 20_000;
        double across = 0;
        double along = 0;
        for (int i = 0; i < discs; i++) {
            double y = height * ((i + 0.5) / discs - 0.5);
            double past = Math.max(0, Math.abs(y) - (height / 2 - radius));
            double square = radius * radius - past * past;
            double mass = Math.PI * square * height / discs;
            across += mass * (square / 4 + y * y);
            along += mass * square / 2;
        }
        double[] moments = MassProperties.of(Shape.capsule(radius, height), 1).moments();
        assertThat(moments[0] / across).isCloseTo(1, within(1e-6));
        assertThat(moments[1] / along).isCloseTo(1, within(1e-6));
    }

    /** An ellipsoid of equal axes is a ball. The expected moments of others are sums over discs. */
    @Test
    void anEllipsoidHasTheMomentsOfItsDiscs() {
        MassProperties ball = MassProperties.of(Shape.sphere(0.5), 1000);
        MassProperties round = MassProperties.of(Shape.ellipsoid(1, 1, 1), 1000);
        assertThat(round.mass()).isCloseTo(ball.mass(), within(1e-9));
        assertClose(round.moments(), ball.moments());
        double[] half = {0.3, 0.7, 0.45};
        int discs = 20_000;
        double mass = 0;
        double[] moments = new double[3];
        for (int i = 0; i < discs; i++) {
            double y = half[1] * (2 * (i + 0.5) / discs - 1);
            double part = Math.sqrt(1 - y * y / (half[1] * half[1]));
            double a = half[0] * part;
            double c = half[2] * part;
            double disc = Math.PI * a * c * 2 * half[1] / discs;
            mass += disc;
            moments[0] += disc * (c * c / 4 + y * y);
            moments[1] += disc * (a * a + c * c) / 4;
            moments[2] += disc * (a * a / 4 + y * y);
        }
        MassProperties solid = MassProperties.of(Shape.ellipsoid(0.6, 1.4, 0.9), 1);
        assertThat(solid.volume() / mass).isCloseTo(1, within(1e-6));
        for (int axis = 0; axis < 3; axis++) {
            assertThat(solid.moments()[axis] / moments[axis]).isCloseTo(1, within(1e-6));
        }
    }

    @Test
    void aMeshOfABoxWeighsWhatTheBoxDoesWhereverItIs() {
        MassProperties brick = MassProperties.of(box(10, -7, 4, 1, 2, 3), 10);
        assertThat(brick.mass()).isCloseTo(60, within(1e-9));
        assertClose(brick.centre(), 10.5, -6, 5.5);
        assertClose(brick.moments(), 65, 50, 25);
        assertClose(brick.products(), 0, 0, 0);
    }

    /**
     * The corners are the origin and the points at 1, 2 and 3 m on the axes. Such a tetrahedron has
     * products of inertia; the expected values were integrated by hand.
     */
    @Test
    void aTetrahedronHasTheProductsOfItsIntegrals() {
        Mesh corner =
                new Mesh(
                        new float[] {0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3},
                        new int[] {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3});
        MassProperties solid = MassProperties.of(corner, 8);
        assertThat(solid.volume()).isCloseTo(1, within(1e-12));
        assertClose(solid.centre(), 0.25, 0.5, 0.75);
        // About the origin: m/10 (b^2 + c^2) and -m/20 b c; then moved by the parallel axis
        // theorem.
        assertClose(
                solid.moments(),
                0.8 * 13 - 8 * (0.25 + 0.5625),
                0.8 * 10 - 8 * (0.5625 + 0.0625),
                0.8 * 5 - 8 * (0.0625 + 0.25));
        assertClose(
                solid.products(),
                -0.4 * 6 + 8 * 0.375,
                -0.4 * 3 + 8 * 0.1875,
                -0.4 * 2 + 8 * 0.125);
    }

    @Test
    void randomConvexSolidsHaveTheIntegralsOfTheirSlices() {
        long seed = Seed.of("solids");
        var random = new Random(seed);
        for (int n = 0; n < 200; n++) {
            String what = "solid " + n + " of seed " + seed;
            var solid = new ConvexSolid(random, 4 + random.nextInt(9));
            MassProperties found = MassProperties.of(solid.mesh(), 700);
            double[] i = solid.integrals(found.centre());
            double volume = i[0];
            double size = Math.cbrt(volume);
            assertThat(found.volume()).as(what).isCloseTo(volume, within(1e-8 * volume));
            assertThat(found.mass()).as(what).isCloseTo(700 * volume, within(7e-6 * volume));
            assertThat(new double[] {i[1] / volume, i[2] / volume, i[3] / volume})
                    .as("centre from that found, " + what)
                    .containsExactly(new double[3], within(1e-8 * size));
            var tolerance = within(1e-7 * 700 * (i[4] + i[5] + i[6]));
            assertThat(found.moments())
                    .as(what)
                    .containsExactly(
                            new double[] {
                                700 * (i[5] + i[6]), 700 * (i[6] + i[4]), 700 * (i[4] + i[5])
                            },
                            tolerance);
            assertThat(found.products())
                    .as(what)
                    .containsExactly(
                            new double[] {-700 * i[7], -700 * i[8], -700 * i[9]}, tolerance);
        }
    }

    @Test
    void theInertiaOfATurnedMeshIsTheTurnedInertia() {
        long seed = Seed.of("turns");
        double angle = new Random(seed).nextDouble();
        double c = Math.cos(angle);
        double s = Math.sin(angle);
        Mesh brick = box(-0.5, -1, -1.5, 1, 2, 3);
        float[] turned = new float[24];
        for (int i = 0; i < 24; i += 3) {
            float x = brick.vertices().get(i);
            float y = brick.vertices().get(i + 1);
            turned[i] = (float) (c * x - s * y);
            turned[i + 1] = (float) (s * x + c * y);
            turned[i + 2] = brick.vertices().get(i + 2);
        }
        MassProperties solid = MassProperties.of(new Mesh(turned, CUBE), 10);
        assertThat(solid.moments()[0]).isCloseTo(c * c * 65 + s * s * 50, within(1e-4));
        assertThat(solid.moments()[1]).isCloseTo(s * s * 65 + c * c * 50, within(1e-4));
        assertThat(solid.products()[2]).isCloseTo(c * s * (65 - 50), within(1e-4));
    }

    @Test
    void icospheresApproachTheSphereFourTimesCloserWithEachLevel() {
        double before = Double.NaN;
        for (int level = 0; level < 5; level++) {
            MassProperties solid = MassProperties.of(icosphere(level), 1000);
            double missing = 1 - solid.mass() / MassProperties.of(Shape.sphere(1), 1000).mass();
            assertThat(missing).isPositive();
            if (level > 1) {
                assertThat(before / missing).isBetween(3.5, 4.5);
            }
            before = missing;
            assertThat(solid.moments()[0] / (0.4 * solid.mass())).isCloseTo(1, within(2 * missing));
        }
        assertThat(before).isLessThan(0.002);
    }

    @Test
    void verticesThatFilesPartCountAsOnePlace() {
        Mesh shared = box(0, 0, 0, 1, 1, 1);
        float[] parted = new float[3 * 36];
        int[] triangles = new int[36];
        for (int i = 0; i < 36; i++) {
            for (int axis = 0; axis < 3; axis++) {
                float value = shared.vertices().get(3 * CUBE[i] + axis);
                parted[3 * i + axis] = value == 0 && i % 2 == 0 ? -0f : value;
            }
            triangles[i] = i;
        }
        assertThat(MassProperties.of(new Mesh(parted, triangles), 1).volume())
                .isCloseTo(1, within(1e-12));
    }

    @Test
    void whatEnclosesNoSpaceIsRefused() {
        Mesh cube = box(0, 0, 0, 1, 1, 1);
        assertRefused(
                new Mesh(array(cube), java.util.Arrays.copyOf(CUBE, 33)),
                "the mesh is open at the edge from (1.0 0.0 0.0) to (1.0 0.0 1.0)");
        int[] flipped = CUBE.clone();
        flipped[1] = CUBE[2];
        flipped[2] = CUBE[1];
        assertRefused(new Mesh(array(cube), flipped), "run the same way along the edge from (");
        int[] inward = CUBE.clone();
        for (int i = 0; i < 36; i += 3) {
            inward[i] = CUBE[i + 1];
            inward[i + 1] = CUBE[i];
        }
        assertRefused(new Mesh(array(cube), inward), "face inward");
        assertRefused(Shape.plane(1, 1), "a plane has no volume");
    }

    private static void assertRefused(Shape shape, String reason) {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> MassProperties.of(shape, 1))
                .withMessageContaining(reason);
    }

    private static float[] array(Mesh mesh) {
        float[] vertices = new float[mesh.vertices().remaining()];
        mesh.vertices().get(vertices);
        return vertices;
    }

    /**
     * Returns an octahedron whose triangles are divided into four, {@code level} times. All
     * vertices are at the distance 1.
     */
    private static Mesh icosphere(int level) {
        List<double[]> points =
                new ArrayList<>(
                        List.of(
                                new double[] {1, 0, 0},
                                new double[] {-1, 0, 0},
                                new double[] {0, 1, 0},
                                new double[] {0, -1, 0},
                                new double[] {0, 0, 1},
                                new double[] {0, 0, -1}));
        List<int[]> faces =
                List.of(
                        new int[] {0, 2, 4},
                        new int[] {2, 1, 4},
                        new int[] {1, 3, 4},
                        new int[] {3, 0, 4},
                        new int[] {2, 0, 5},
                        new int[] {1, 2, 5},
                        new int[] {3, 1, 5},
                        new int[] {0, 3, 5});
        for (int i = 0; i < level + 1; i++) {
            Map<Long, Integer> middles = new HashMap<>();
            List<int[]> finer = new ArrayList<>();
            for (int[] f : faces) {
                int ab = middle(points, middles, f[0], f[1]);
                int bc = middle(points, middles, f[1], f[2]);
                int ca = middle(points, middles, f[2], f[0]);
                finer.addAll(
                        List.of(
                                new int[] {f[0], ab, ca},
                                new int[] {ab, f[1], bc},
                                new int[] {ca, bc, f[2]},
                                new int[] {ab, bc, ca}));
            }
            faces = finer;
        }
        float[] vertices = new float[3 * points.size()];
        for (int i = 0; i < vertices.length; i++) {
            vertices[i] = (float) points.get(i / 3)[i % 3];
        }
        return new Mesh(vertices, faces.stream().flatMapToInt(java.util.Arrays::stream).toArray());
    }

    private static int middle(List<double[]> points, Map<Long, Integer> known, int a, int b) {
        return known.computeIfAbsent(
                (long) Math.min(a, b) << 32 | Math.max(a, b),
                key -> {
                    double[] sum = new double[3];
                    for (int axis = 0; axis < 3; axis++) {
                        sum[axis] = points.get(a)[axis] + points.get(b)[axis];
                    }
                    double length = Math.sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
                    points.add(new double[] {sum[0] / length, sum[1] / length, sum[2] / length});
                    return points.size() - 1;
                });
    }
}
