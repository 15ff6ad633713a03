// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import java.lang.foreign.MemorySegment;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.Random;
import java.util.stream.LongStream;

/** Distances along rays, compared with closed forms, distance functions and other methods. */
class LocalRayTest {
    private static final double[] NOT_MOVED = {0, 0, 0, 0, 0, 0, 1};

    /** The distance of a point to a surface, negative inside. */
    private interface Surface {
        double at(double x, double y, double z);
    }

    private static LocalRay ray(double[] from, double[] direction, double[] place) {
        var ray = new LocalRay();
        ray.set(from, direction, place);
        return ray;
    }

    private static double[] unit(Random random, int components) {
        double[] vector = new double[components];
        double square = 0;
        for (int i = 0; i < components; i++) {
            vector[i] = random.nextGaussian();
            square += vector[i] * vector[i];
        }
        for (int i = 0; i < components; i++) {
            vector[i] /= Math.sqrt(square);
        }
        return vector;
    }

    @Test
    void aSphereIsMetAtTheDistanceOfTheClosedForm() {
        double radius = 2;
        for (double aside = 0; aside < 3; aside += 0.25) {
            double distance =
                    ray(new double[] {aside, 0, -7}, new double[] {0, 0, 1}, NOT_MOVED)
                            .toSphere(radius);
            if (aside < radius) {
                double expected = 7 - Math.sqrt(radius * radius - aside * aside);
                assertThat(distance).isCloseTo(expected, within(1e-12));
            } else if (aside > radius) {
                assertThat(distance).isInfinite();
            }
        }
        assertThat(ray(new double[3], new double[] {1, 0, 0}, NOT_MOVED).toSphere(radius))
                .as("from inside")
                .isEqualTo(radius);
        assertThat(ray(new double[] {5, 0, 0}, new double[] {1, 0, 0}, NOT_MOVED).toSphere(radius))
                .as("behind the ray")
                .isInfinite();
    }

    @Test
    void aTurnedBoxAndAPlaneAreMetAtTheDistanceOfTheClosedForm() {
        double[] place = {1, 2, 3, 0, Math.sin(Math.PI / 8), 0, Math.cos(Math.PI / 8)};
        double[] along = {1, 0, 0};
        assertThat(ray(new double[] {-9, 2, 3}, along, place).toBox(1, 1, 1))
                .as("an edge, turned by 45 degrees")
                .isCloseTo(10 - Math.sqrt(2), within(1e-12));
        double slope = Math.toRadians(30);
        double[] down = {Math.cos(slope), -Math.sin(slope), 0};
        assertThat(ray(new double[] {0, 5, 0}, down, NOT_MOVED).toPlane(20, 20))
                .isCloseTo(5 / Math.sin(slope), within(1e-12));
        assertThat(ray(new double[] {0, 5, 0}, down, NOT_MOVED).toPlane(8, 20))
                .as("beyond the edge")
                .isInfinite();
        assertThat(ray(new double[] {0, -5, 0}, down, NOT_MOVED).toPlane(20, 20)).isInfinite();
        assertThat(ray(new double[] {-3, 0, 0}, along, NOT_MOVED).toPlane(1, 1))
                .as("in the plane")
                .isInfinite();
    }

    /** The points of the rays are on the surface, and a ray misses if no point of it is inside. */
    @Test
    void anEllipsoidIsMetOnItsSurface() {
        var random = new Random(7);
        double[] half = {0.7, 1.6, 0.4};
        int met = 0;
        for (int i = 0; i < 2000; i++) {
            double[] from = unit(random, 3);
            double reach = random.nextInt(4) == 0 ? 0.3 * random.nextDouble() : 3;
            for (int axis = 0; axis < 3; axis++) {
                from[axis] *= reach;
            }
            double[] direction = unit(random, 3);
            double distance =
                    ray(from, direction, NOT_MOVED).toEllipsoid(half[0], half[1], half[2]);
            double nearest = Double.POSITIVE_INFINITY;
            for (double t = 0; t < 5; t += 1e-3) {
                double level = level(from, direction, t, half);
                if (level < 1 == reach > 1) {
                    nearest = t;
                    break;
                }
            }
            if (Double.isInfinite(nearest)) {
                assertThat(distance > 4 || chord(from, direction, distance, half))
                        .as("ray %d", i)
                        .isTrue();
            } else {
                met++;
                assertThat(distance).as("ray %d", i).isBetween(nearest - 1.01e-3, nearest);
                assertThat(level(from, direction, distance, half)).isCloseTo(1, within(1e-9));
            }
        }
        assertThat(met).isGreaterThan(500);
    }

    /** Returns the squared length in axes in which the ellipsoid is a ball of radius 1. */
    private static double level(double[] from, double[] direction, double t, double[] half) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            double at = (from[axis] + t * direction[axis]) / half[axis];
            sum += at * at;
        }
        return sum;
    }

    /** Returns whether a ray is inside for less than the step of the search. */
    private static boolean chord(
            double[] from, double[] direction, double distance, double[] half) {
        return level(from, direction, distance + 1e-3, half) > 1;
    }

    private static double boxed(double x, double y, double z, double a, double b, double c) {
        double dx = Math.abs(x) - a;
        double dy = Math.abs(y) - b;
        double dz = Math.abs(z) - c;
        double outside =
                Math.sqrt(
                        Math.pow(Math.max(dx, 0), 2)
                                + Math.pow(Math.max(dy, 0), 2)
                                + Math.pow(Math.max(dz, 0), 2));
        return outside + Math.min(0, Math.max(dx, Math.max(dy, dz)));
    }

    private static double cylinder(double x, double y, double z, double radius, double half) {
        return boxed(Math.hypot(x, z), y, 0, radius, half, 1);
    }

    private static double capsule(double x, double y, double z, double radius, double half) {
        double above = y - Math.clamp(y, radius - half, half - radius);
        return Math.sqrt(x * x + above * above + z * z) - radius;
    }

    /**
     * The first change of sign of the distance function, by sphere tracing; an independent method.
     */
    private static double traced(Surface surface, double[] from, double[] direction) {
        double sign = Math.signum(surface.at(from[0], from[1], from[2]));
        double distance = 0;
        for (int i = 0; i < 20_000 && distance < 50; i++) {
            double gap =
                    sign
                            * surface.at(
                                    from[0] + distance * direction[0],
                                    from[1] + distance * direction[1],
                                    from[2] + distance * direction[2]);
            if (gap < 1e-10) {
                return distance;
            }
            distance += gap;
        }
        return Double.POSITIVE_INFINITY;
    }

    @Test
    void convexShapesAreMetWhereTheirDistanceFunctionIsZero() {
        Random random = new Random(3);
        int met = 0;
        for (int i = 0; i < 4000; i++) {
            double[] from = unit(random, 3);
            double reach = random.nextInt(4) == 0 ? random.nextDouble() : 6 * random.nextDouble();
            for (int axis = 0; axis < 3; axis++) {
                from[axis] *= reach;
            }
            double[] direction = unit(random, 3);
            if (random.nextInt(5) == 0) {
                direction = new double[] {0, random.nextBoolean() ? 1 : -1, 0};
            }
            LocalRay ray = ray(from, direction, NOT_MOVED);
            double[] found = {
                ray.toBox(0.7, 1.2, 0.4),
                ray.toCylinder(0.8, 1.1),
                ray.toCapsule(0.6, 1.5),
                ray.toCapsule(0.9, 0.9),
                ray.toSphere(1.3)
            };
            Surface[] surfaces = {
                (x, y, z) -> boxed(x, y, z, 0.7, 1.2, 0.4),
                (x, y, z) -> cylinder(x, y, z, 0.8, 1.1),
                (x, y, z) -> capsule(x, y, z, 0.6, 1.5),
                (x, y, z) -> capsule(x, y, z, 0.9, 0.9),
                (x, y, z) -> Math.sqrt(x * x + y * y + z * z) - 1.3
            };
            for (int k = 0; k < surfaces.length; k++) {
                double expected = traced(surfaces[k], from, direction);
                if (Double.isInfinite(expected)) {
                    assertThat(found[k]).as("shape %d, ray %d", k, i).isInfinite();
                } else {
                    met++;
                    // Tracing stops up to 1e-10 before the surface, earlier along a grazing ray.
                    assertThat(found[k])
                            .as("shape %d, ray %d", k, i)
                            .isCloseTo(expected, within(1e-4));
                }
            }
        }
        assertThat(met).isGreaterThan(5000);
    }

    /** A box of twelve triangles. */
    private static TriangleIndex mesh(float a, float b, float c) {
        float[] corners = new float[24];
        for (int i = 0; i < 8; i++) {
            corners[3 * i] = (i & 1) == 0 ? -a : a;
            corners[3 * i + 1] = (i & 2) == 0 ? -b : b;
            corners[3 * i + 2] = (i & 4) == 0 ? -c : c;
        }
        int[] faces = {0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
        int[] triangles = new int[36];
        for (int face = 0; face < 6; face++) {
            for (int k = 0; k < 6; k++) {
                int[] order = {0, 1, 2, 0, 2, 3};
                triangles[6 * face + k] = faces[4 * face + order[k]];
            }
        }
        return new TriangleIndex(FloatBuffer.wrap(corners), IntBuffer.wrap(triangles));
    }

    private static Effort effort(long most) {
        var effort = new Effort();
        effort.begin(most);
        return effort;
    }

    /** A search that examines more triangles than it may has no result, and stops. */
    @Test
    void aSearchEndsWithItsEffort() {
        int count = 10_000;
        float[] corners = new float[3 * (count + 2)];
        corners[0] = -1;
        corners[3] = 1;
        int[] triangles = new int[3 * count];
        for (int i = 0; i < count; i++) {
            corners[3 * (i + 2) + 1] = 2;
            corners[3 * (i + 2) + 2] = 1e-6f * i;
            triangles[3 * i + 1] = 1;
            triangles[3 * i + 2] = i + 2;
        }
        var fan = new TriangleIndex(FloatBuffer.wrap(corners), IntBuffer.wrap(triangles));
        double[] towards = {0, 0.6, 0.8};
        LocalRay ray = ray(new double[] {0, 0.4, -1}, towards, new double[] {0, 0, 0, 0, 0, 0, 1});
        Effort enough = effort(2L * count);
        double found = fan.distance(ray, 100, enough);
        assertThat(found).isCloseTo(1.25, within(0.01));
        long needed = 2L * count - enough.left();
        assertThat(needed).isGreaterThan(count / 2);
        assertThat(fan.distance(ray, 100, effort(needed))).isEqualTo(found);
        Effort tooLittle = effort(needed - 1);
        assertThat(fan.distance(ray, 100, tooLittle)).isInfinite();
        assertThat(tooLittle.left()).isEqualTo(-1);
    }

    @Test
    void aMeshOfABoxIsMetLikeTheBoxInAnyPlace() {
        Random random = new Random(5);
        TriangleIndex mesh = mesh(0.5f, 1.25f, 2);
        int met = 0;
        for (int i = 0; i < 4000; i++) {
            double[] turn = unit(random, 4);
            double[] place = {9, -4, 2 * random.nextDouble(), turn[0], turn[1], turn[2], turn[3]};
            double[] from = unit(random, 3);
            for (int axis = 0; axis < 3; axis++) {
                from[axis] = place[axis] + 3 * random.nextDouble() * from[axis];
            }
            LocalRay ray = ray(from, unit(random, 3), place);
            double expected = ray.toBox(0.5, 1.25, 2);
            double found = mesh.distance(ray, 100, effort(1000));
            if (Double.isInfinite(expected)) {
                assertThat(found).isInfinite();
            } else {
                met++;
                assertThat(found).isCloseTo(expected, within(1e-9));
                assertThat(mesh.distance(ray, expected - 1e-6, effort(1000)))
                        .as("out of range")
                        .isInfinite();
            }
        }
        assertThat(met).isGreaterThan(1000);
    }

    @Test
    void theIndexFindsTheNearestOfManyBoxes() {
        Random random = new Random(9);
        int count = 500;
        double[] low = new double[3 * count];
        double[] high = new double[3 * count];
        for (int i = 0; i < 3 * count; i++) {
            low[i] = 20 * random.nextDouble() - 10;
            high[i] = low[i] + random.nextDouble();
        }
        var index = new BoxIndex();
        index.build(
                MemorySegment.ofArray(LongStream.range(0, count).toArray()),
                MemorySegment.ofArray(low),
                MemorySegment.ofArray(high),
                count);
        int met = 0;
        for (int i = 0; i < 2000; i++) {
            double[] from = unit(random, 3);
            for (int axis = 0; axis < 3; axis++) {
                from[axis] *= 12;
            }
            double[] towards = unit(random, 3);
            double length = 0;
            for (int axis = 0; axis < 3; axis++) {
                towards[axis] = 8 * towards[axis] - from[axis];
                length += towards[axis] * towards[axis];
            }
            for (int axis = 0; axis < 3; axis++) {
                towards[axis] /= Math.sqrt(length);
            }
            if (i % 10 == 0) {
                towards = new double[] {0, 0, from[2] > 0 ? -1 : 1};
            }
            double[] direction = towards;
            double expected = Double.POSITIVE_INFINITY;
            for (int box = 0; box < count; box++) {
                expected = Math.min(expected, distance(box, low, high, from, direction));
            }
            double most = i % 3 == 0 ? 5 : 1e6;
            double found =
                    index.nearestOnRay(
                            from,
                            direction,
                            most,
                            (key, limit) -> distance((int) key, low, high, from, direction),
                            effort(10_000));
            assertThat(found).isEqualTo(expected <= most ? expected : Double.POSITIVE_INFINITY);
            met += Double.isInfinite(found) ? 0 : 1;
        }
        assertThat(met).isGreaterThan(500);
    }

    private static double distance(
            int box, double[] low, double[] high, double[] from, double[] direction) {
        double[] place = new double[7];
        place[6] = 1;
        for (int axis = 0; axis < 3; axis++) {
            place[axis] = 0.5 * (low[3 * box + axis] + high[3 * box + axis]);
        }
        return ray(from, direction, place)
                .toBox(
                        0.5 * (high[3 * box] - low[3 * box]),
                        0.5 * (high[3 * box + 1] - low[3 * box + 1]),
                        0.5 * (high[3 * box + 2] - low[3 * box + 2]));
    }
}
