// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Mesh;

import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.Arrays;
import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/**
 * Check that a mesh encloses a volume. Each edge of such a mesh belongs to two triangles, which
 * traverse it in opposite directions. Vertices at the same position count as one vertex, because
 * files duplicate vertices where normals or texture coordinates differ.
 */
final class ClosedSurface {

    private final FloatBuffer vertices;
    private final int[] corners;

    /** A vertex position. The coordinates -0 and 0 are equal. */
    private record Place(float x, float y, float z) {}

    private ClosedSurface(Mesh mesh) {
        vertices = mesh.vertices();
        IntBuffer triangles = mesh.triangles();
        Map<Place, Integer> firstAt = new HashMap<>();
        corners = new int[triangles.remaining()];
        for (int i = 0; i < corners.length; i++) {
            int vertex = triangles.get(i);
            Integer first = firstAt.putIfAbsent(place(vertex), vertex);
            corners[i] = first == null ? vertex : first;
        }
    }

    /**
     * Checks a mesh.
     *
     * @throws IllegalArgumentException naming an edge that does not belong to two triangles, or
     *     that two triangles traverse in the same direction
     */
    static void require(Mesh mesh) {
        new ClosedSurface(mesh)
                .fault()
                .ifPresent(
                        fault -> {
                            throw new IllegalArgumentException(fault);
                        });
    }

    private Optional<String> fault() {
        long[] edges = sortedEdges();
        for (int i = 1; i < edges.length; i++) {
            if (edges[i] == edges[i - 1]) {
                return Optional.of(
                        "the mesh is not a surface around a space: two triangles run "
                                + "the same way along the edge "
                                + describe(edges[i])
                                + "; they face opposite sides, or more than two meet there");
            }
        }
        for (long edge : edges) {
            if (Arrays.binarySearch(edges, Long.rotateLeft(edge, 32)) < 0) {
                return Optional.of(
                        "the mesh is open at the edge "
                                + describe(edge)
                                + ", which belongs to one triangle only");
            }
        }
        return Optional.empty();
    }

    /**
     * Returns the sorted edges of all triangles, except degenerate triangles. Each edge is a pair
     * of its first and second vertex.
     */
    private long[] sortedEdges() {
        long[] edges = new long[corners.length];
        int count = 0;
        for (int i = 0; i < corners.length; i += 3) {
            int a = corners[i];
            int b = corners[i + 1];
            int c = corners[i + 2];
            if (a != b && b != c && c != a) {
                edges[count++] = (long) a << 32 | b;
                edges[count++] = (long) b << 32 | c;
                edges[count++] = (long) c << 32 | a;
            }
        }
        long[] sorted = Arrays.copyOf(edges, count);
        Arrays.sort(sorted);
        return sorted;
    }

    private String describe(long edge) {
        return "from " + text(place((int) (edge >>> 32))) + " to " + text(place((int) edge));
    }

    private Place place(int vertex) {
        return new Place(
                vertices.get(3 * vertex) + 0f,
                vertices.get(3 * vertex + 1) + 0f,
                vertices.get(3 * vertex + 2) + 0f);
    }

    private static String text(Place place) {
        return "(" + place.x + " " + place.y + " " + place.z + ")";
    }
}
