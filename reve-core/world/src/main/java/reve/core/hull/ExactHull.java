// SPDX-License-Identifier: Apache-2.0
package reve.core.hull;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.PriorityQueue;

/**
 * The convex hull of points with integer coordinates. Uses the quickhull algorithm (C. B. Barber,
 * D. P. Dobkin, H. Huhdanpaa, The quickhull algorithm for convex hulls, ACM Trans. Math. Software
 * 22, 1996, 469).
 *
 * <p>The integers are so small that all comparisons are exact. Degenerate point sets therefore need
 * no tolerance, and every machine finds the same hull.
 */
final class ExactHull {
    /**
     * Maximum coordinate. The limit ensures that the height of a point above a triangle fits in a
     * {@code long}.
     */
    static final long LARGEST = 1 << 20;

    private static final int[] NO_POINTS = {};

    private final long[] points;
    private final List<Facet> created = new ArrayList<>();
    private final PriorityQueue<Facet> queue =
            new PriorityQueue<>(
                    Comparator.comparingDouble((Facet facet) -> -facet.distance)
                            .thenComparingInt(facet -> facet.number));

    /** A triangle of the hull, counter-clockwise as seen from outside. */
    private final class Facet {
        final int number = created.size();
        final int[] corners;

        /** The facet at the other side of the edge from corner i to corner i + 1. */
        final Facet[] beside = new Facet[3];

        final long[] normal = new long[3];
        final double length;
        boolean removed;
        boolean visible;

        /** The points above this facet that belong to no other facet's list. */
        int[] above = NO_POINTS;

        int aboveCount;
        int farthest = -1;
        double distance;
        private double spread;

        Facet(int a, int b, int c) {
            corners = new int[] {a, b, c};
            long ux = at(b, 0) - at(a, 0);
            long uy = at(b, 1) - at(a, 1);
            long uz = at(b, 2) - at(a, 2);
            long vx = at(c, 0) - at(a, 0);
            long vy = at(c, 1) - at(a, 1);
            long vz = at(c, 2) - at(a, 2);
            normal[0] = uy * vz - uz * vy;
            normal[1] = uz * vx - ux * vz;
            normal[2] = ux * vy - uy * vx;
            double x = normal[0];
            double y = normal[1];
            double z = normal[2];
            length = Math.sqrt(x * x + y * y + z * z);
            created.add(this);
        }

        /**
         * Returns the height of a point above the facet, multiplied by the length of the normal.
         * The result is exact.
         */
        long height(int point) {
            int a = corners[0];
            return normal[0] * (at(point, 0) - at(a, 0))
                    + normal[1] * (at(point, 1) - at(a, 1))
                    + normal[2] * (at(point, 2) - at(a, 2));
        }

        /**
         * Adds a point to the list of points above this facet if the point is above the facet.
         * Returns whether the point was added.
         */
        boolean take(int point) {
            long height = height(point);
            if (height <= 0) {
                return false;
            }
            if (aboveCount == above.length) {
                above = Arrays.copyOf(above, Math.max(4, 2 * aboveCount));
            }
            above[aboveCount++] = point;
            double far = height / length;
            // Several points may be equally high. The point that is farthest from the first corner
            // is chosen, because it cannot be in the middle of a face.
            double wide = squareOfDistance(point, corners[0]);
            if (far > distance || far == distance && wide > spread) {
                distance = far;
                spread = wide;
                farthest = point;
            }
            return true;
        }
    }

    private ExactHull(long[] points) {
        this.points = points;
    }

    private long at(int point, int axis) {
        return points[3 * point + axis];
    }

    private double squareOfDistance(int a, int b) {
        long x = at(a, 0) - at(b, 0);
        long y = at(a, 1) - at(b, 1);
        long z = at(a, 2) - at(b, 2);
        return x * x + y * y + z * z;
    }

    /**
     * Returns four times the square of the area of a triangle. The result is exactly 0 if the
     * triangle is degenerate.
     */
    private double squareOfArea(int a, int b, int c) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            int u = (axis + 1) % 3;
            int v = (axis + 2) % 3;
            double part =
                    (at(b, u) - at(a, u)) * (at(c, v) - at(a, v))
                            - (at(b, v) - at(a, v)) * (at(c, u) - at(a, u));
            sum += part * part;
        }
        return sum;
    }

    /**
     * Returns the triangles of the hull as three indices of points each, counter-clockwise as seen
     * from outside.
     *
     * @param points (count x 3) coordinates from 0 to {@link #LARGEST}
     * @param most maximum number of points that are joined to the hull; the points that are
     *     farthest outside come first
     * @throws IllegalArgumentException if all points coincide, or lie on a line or in a plane
     */
    static List<int[]> of(long[] points, int most) {
        ExactHull hull = new ExactHull(points);
        hull.begin();
        for (int joined = 4; joined < most && hull.join(); joined++) {
            // The loop body is empty, because each call in the condition joins one point.
        }
        return hull.created.stream()
                .filter(facet -> !facet.removed)
                .map(facet -> facet.corners)
                .toList();
    }

    private void begin() {
        int count = points.length / 3;
        int first = 0;
        int second = farthest(count, point -> squareOfDistance(point, first));
        if (squareOfDistance(second, first) == 0) {
            throw new IllegalArgumentException("coincide");
        }
        int third = farthest(count, point -> squareOfArea(first, second, point));
        Facet base = new Facet(first, second, third);
        if (base.length == 0) {
            throw new IllegalArgumentException("lie on a line");
        }
        int fourth = farthest(count, point -> Math.abs(base.height(point)));
        long height = base.height(fourth);
        if (height == 0) {
            throw new IllegalArgumentException("lie in a plane");
        }
        created.clear();
        int b = height < 0 ? second : third;
        int c = height < 0 ? third : second;
        Facet[] facets = {
            new Facet(first, b, c),
            new Facet(first, c, fourth),
            new Facet(c, b, fourth),
            new Facet(b, first, fourth)
        };
        for (Facet facet : facets) {
            for (int i = 0; i < 3; i++) {
                facet.beside[i] = sharing(facets, facet.corners[(i + 1) % 3], facet.corners[i]);
            }
        }
        for (int point = 0; point < count; point++) {
            give(point, List.of(facets));
        }
        for (Facet facet : facets) {
            enqueue(facet);
        }
    }

    private interface Measure {
        double of(int point);
    }

    private static int farthest(int count, Measure measure) {
        int found = 0;
        double most = -1;
        for (int point = 0; point < count; point++) {
            double size = measure.of(point);
            if (size > most) {
                most = size;
                found = point;
            }
        }
        return found;
    }

    /** Returns the facet that has the edge between two corners in this direction. */
    private static Facet sharing(Facet[] facets, int from, int to) {
        for (Facet facet : facets) {
            for (int i = 0; i < 3; i++) {
                if (facet.corners[i] == from && facet.corners[(i + 1) % 3] == to) {
                    return facet;
                }
            }
        }
        throw new IllegalStateException("no facet has the edge " + from + " to " + to);
    }

    private static void give(int point, List<Facet> facets) {
        for (Facet facet : facets) {
            if (facet.take(point)) {
                return;
            }
        }
    }

    private void enqueue(Facet facet) {
        if (facet.farthest >= 0) {
            queue.add(facet);
        }
    }

    /**
     * Joins the point that is farthest outside to the hull. Returns false if no point is outside.
     */
    private boolean join() {
        Facet start = queue.poll();
        while (start != null && start.removed) {
            start = queue.poll();
        }
        if (start == null) {
            return false;
        }
        int point = start.farthest;
        List<Facet> seen = visible(start, point);
        List<Facet> cone = new ArrayList<>();
        Map<Integer, Facet> byFirst = new HashMap<>();
        for (Facet facet : seen) {
            for (int i = 0; i < 3; i++) {
                Facet outer = facet.beside[i];
                if (outer.visible) {
                    continue;
                }
                int from = facet.corners[i];
                int to = facet.corners[(i + 1) % 3];
                Facet side = new Facet(from, to, point);
                side.beside[0] = outer;
                outer.beside[edge(outer, to)] = side;
                byFirst.put(from, side);
                cone.add(side);
            }
        }
        for (Facet side : cone) {
            Facet next = byFirst.get(side.corners[1]);
            side.beside[1] = next;
            next.beside[2] = side;
        }
        for (Facet facet : seen) {
            facet.removed = true;
            for (int i = 0; i < facet.aboveCount; i++) {
                if (facet.above[i] != point) {
                    give(facet.above[i], cone);
                }
            }
            facet.above = NO_POINTS;
        }
        cone.forEach(this::enqueue);
        return true;
    }

    private static int edge(Facet facet, int from) {
        return facet.corners[0] == from ? 0 : facet.corners[1] == from ? 1 : 2;
    }

    /**
     * Returns the facets that are visible from a point outside of the hull. These facets are
     * connected, so the search starts at one of them.
     */
    private static List<Facet> visible(Facet start, int point) {
        List<Facet> found = new ArrayList<>(List.of(start));
        start.visible = true;
        for (int i = 0; i < found.size(); i++) {
            for (Facet beside : found.get(i).beside) {
                if (!beside.visible && beside.height(point) > 0) {
                    beside.visible = true;
                    found.add(beside);
                }
            }
        }
        return found;
    }
}
