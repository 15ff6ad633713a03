// SPDX-License-Identifier: Apache-2.0
package reve.core.hull;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import java.util.Arrays;
import java.util.HashSet;
import java.util.Random;
import java.util.Set;
import java.util.TreeSet;

class ConvexHullTest {
    private static double[] cube(double x, double y, double z) {
        double[] points = new double[24];
        for (int i = 0; i < 8; i++) {
            points[3 * i] = (i & 1) == 0 ? -x / 2 : x / 2;
            points[3 * i + 1] = (i & 2) == 0 ? -y / 2 : y / 2;
            points[3 * i + 2] = (i & 4) == 0 ? -z / 2 : z / 2;
        }
        return points;
    }

    private static double[] random(Random random, int count, boolean onSphere) {
        double[] points = new double[3 * count];
        for (int i = 0; i < count; i++) {
            double x = random.nextGaussian();
            double y = random.nextGaussian();
            double z = random.nextGaussian();
            double scale = onSphere ? 1 / Math.sqrt(x * x + y * y + z * z) : 1;
            points[3 * i] = (float) (x * scale);
            points[3 * i + 1] = (float) (y * scale);
            points[3 * i + 2] = (float) (z * scale);
        }
        return points;
    }

    private static double along(ConvexHull hull, int face, double[] points, int point) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            sum += hull.normal(face, axis) * points[3 * point + axis];
        }
        return sum;
    }

    /** Requires a closed convex surface that contains the points. */
    private static void requireHull(ConvexHull hull, double[] points, double tolerance) {
        Set<Long> edges = new HashSet<>();
        for (int f = 0; f < hull.faces().length; f++) {
            int[] face = hull.faces()[f];
            for (int i = 0; i < face.length; i++) {
                long from = face[i];
                long to = face[(i + 1) % face.length];
                assertThat(edges.add(from << 32 | to)).as("edge used twice").isTrue();
                assertThat(along(hull, f, hull.corners(), face[i]))
                        .isCloseTo(hull.offset(f), within(tolerance));
            }
            for (int i = 0; i < points.length / 3; i++) {
                assertThat(along(hull, f, points, i)).isLessThan(hull.offset(f) + tolerance);
            }
        }
        for (long edge : edges) {
            assertThat(edges).contains(Long.rotateLeft(edge, 32));
        }
        assertThat(hull.corners().length / 3 - edges.size() / 2 + hull.faces().length)
                .as("Euler's formula")
                .isEqualTo(2);
    }

    /**
     * Requires that the core touches the plane of each face after this plane was moved inwards by
     * the rounding.
     */
    private static void requireCore(ConvexHull hull, double tolerance) {
        double rounding = ConvexHull.ROUNDING * hull.thickness();
        for (int f = 0; f < hull.faces().length; f++) {
            double most = Double.NEGATIVE_INFINITY;
            for (int i = 0; i < hull.core().length / 3; i++) {
                most = Math.max(most, along(hull, f, hull.core(), i));
            }
            assertThat(most).isLessThan(hull.offset(f) - rounding + tolerance);
        }
    }

    @Test
    void aDividedCubeHasEightCornersAndSixFaces() {
        int side = 9;
        double[] points = new double[3 * side * side * side];
        int next = 0;
        for (int i = 0; i < side * side * side; i++) {
            points[next++] = i % side - 4;
            points[next++] = i / side % side - 4;
            points[next++] = i / side / side - 4;
        }
        ConvexHull hull = ConvexHull.of(points);
        assertThat(hull.corners()).hasSize(24);
        assertThat(hull.faces()).hasNumberOfRows(6);
        assertThat(hull.volume()).isCloseTo(512, within(1e-9));
        assertThat(hull.thickness()).isEqualTo(8);
        requireHull(hull, points, 1e-9);
        double[] core = hull.core();
        assertThat(core).hasSize(24);
        for (double coordinate : core) {
            assertThat(Math.abs(coordinate)).isCloseTo(4 - 0.05 * 8, within(1e-9));
        }
    }

    @Test
    void aRotatedBoxHasSixFacesDespiteRounding() {
        double[] box = cube(1, 0.03, 2);
        Random random = new Random(3);
        for (int round = 0; round < 20; round++) {
            double a = random.nextDouble() * 6;
            double b = random.nextDouble() * 6;
            double[] turned = new double[24];
            for (int i = 0; i < 24; i += 3) {
                double x = Math.cos(a) * box[i] - Math.sin(a) * box[i + 1];
                double y = Math.sin(a) * box[i] + Math.cos(a) * box[i + 1];
                turned[i] = (float) (x + 5);
                turned[i + 1] = (float) (Math.cos(b) * y - Math.sin(b) * box[i + 2] - 3);
                turned[i + 2] = (float) (Math.sin(b) * y + Math.cos(b) * box[i + 2]);
            }
            ConvexHull hull = ConvexHull.of(turned);
            assertThat(hull.faces()).as("angles %s %s", a, b).hasNumberOfRows(6);
            assertThat(hull.volume()).isCloseTo(0.06, within(1e-6));
            assertThat(hull.centre()[0]).isCloseTo(5, within(1e-6));
            requireCore(hull, 1e-5);
        }
    }

    /**
     * The search tries all triples of points. If all other points are on one side of the plane of a
     * triple, its points are corners.
     */
    @Test
    void theCornersAreThoseOfAnIndependentSearch() {
        Random random = new Random(7);
        for (int round = 0; round < 200; round++) {
            int count = 4 + random.nextInt(12);
            double[] points = random(random, count, false);
            Set<Integer> expected = new TreeSet<>();
            for (int a = 0; a < count; a++) {
                for (int b = a + 1; b < count; b++) {
                    for (int c = b + 1; c < count; c++) {
                        addIfOutside(points, a, b, c, expected);
                    }
                }
            }
            ConvexHull hull = ConvexHull.of(points);
            double[] corners =
                    expected.stream()
                            .flatMapToDouble(i -> Arrays.stream(points, 3 * i, 3 * i + 3))
                            .toArray();
            assertThat(hull.corners()).containsExactly(corners);
            requireHull(hull, points, 1e-4);
            requireCore(hull, 1e-4);
        }
    }

    private static void addIfOutside(double[] p, int a, int b, int c, Set<Integer> corners) {
        double[] normal = ConvexHull.normalOf(p, new int[] {a, b, c});
        int above = 0;
        int below = 0;
        for (int i = 0; i < p.length / 3; i++) {
            double height = 0;
            for (int axis = 0; axis < 3; axis++) {
                height += normal[axis] * (p[3 * i + axis] - p[3 * a + axis]);
            }
            above += height > 1e-9 ? 1 : 0;
            below += height < -1e-9 ? 1 : 0;
        }
        if (above == 0 || below == 0) {
            corners.addAll(Set.of(a, b, c));
        }
    }

    @Test
    void aFineSphereIsReducedToItsFarthestPoints() {
        double[] points = random(new Random(1), 5000, true);
        ConvexHull hull = ConvexHull.of(points);
        assertThat(hull.corners().length / 3).isBetween(100, ConvexHull.MAX_CORNERS);
        for (int f = 0; f < hull.faces().length; f++) {
            assertThat(hull.offset(f)).isGreaterThan(0.93);
        }
        assertThat(hull.volume()).isCloseTo(4 * Math.PI / 3, within(0.3));
        requireCore(hull, 1e-6);
    }

    @Test
    void pointsWithoutAVolumeAreRefusedWithTheReason() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ConvexHull.of(new double[12]))
                .withMessage("its 4 vertices coincide");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ConvexHull.of(new double[] {0, 0, 0, 1, 2, 3, 2, 4, 6, 3, 6, 9}))
                .withMessage("its 4 vertices lie on a line");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ConvexHull.of(cube(1, 0, 1)))
                .withMessage("its 8 vertices lie in a plane");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ConvexHull.of(cube(1, 1e-4, 1)))
                .withMessageContaining("0.000100 m thick and 1.00 m long");
    }

    /** Points on lines, planes and grids. Some are copies, and some have small errors. */
    @Test
    void degeneratePointsGiveAHullOrAReason() {
        Random random = new Random(11);
        int hulls = 0;
        for (int round = 0; round < 3000; round++) {
            int count = 1 + random.nextInt(30);
            double[] points = new double[3 * count];
            double[] scale = new double[3];
            for (int axis = 0; axis < 3; axis++) {
                scale[axis] = random.nextInt(3) == 0 ? 0 : Math.pow(10, random.nextInt(13) - 6);
            }
            int grid = 1 + random.nextInt(4);
            double error = random.nextBoolean() ? 0 : Math.pow(10, -random.nextInt(12));
            for (int i = 0; i < points.length; i++) {
                double whole = random.nextInt(grid + 1) + error * random.nextGaussian();
                points[i] = (float) (whole * scale[i % 3]);
            }
            try {
                ConvexHull hull = ConvexHull.of(points);
                double extent = Math.cbrt(hull.volume()) + hull.thickness();
                requireHull(hull, points, 1e3 * extent);
                assertThat(hull.volume()).isPositive().isFinite();
                assertThat(hull.core()).hasSizeGreaterThanOrEqualTo(12);
                hulls++;
            } catch (IllegalArgumentException refused) {
                assertThat(refused.getMessage()).startsWith("its ");
            }
        }
        assertThat(hulls).isGreaterThan(100);
    }
}
