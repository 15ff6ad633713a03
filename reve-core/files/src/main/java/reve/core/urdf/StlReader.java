// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.world.Mesh;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;

/**
 * Reader of STL files, binary or text. Equal corners of triangles become one vertex. Triangles with
 * two equal corners are omitted.
 */
final class StlReader {
    private static final int HEADER = 80;
    private static final int TRIANGLE = 50;
    private static final int NORMAL = 12;

    private final Map<List<Float>, Integer> known = new HashMap<>();
    private final List<float[]> vertices = new ArrayList<>();
    private final List<int[]> triangles = new ArrayList<>();

    private StlReader() {}

    /**
     * Reads a mesh.
     *
     * @throws IllegalArgumentException with the reason if the bytes are no STL file
     */
    static Mesh read(byte[] bytes) {
        StlReader reader = new StlReader();
        ByteBuffer buffer = ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN);
        long count = bytes.length < HEADER + 4 ? -1 : buffer.getInt(HEADER) & 0xffffffffL;
        if (count >= 0 && HEADER + 4 + count * TRIANGLE == bytes.length) {
            reader.binary(buffer, (int) count);
        } else {
            reader.text(new String(bytes, StandardCharsets.ISO_8859_1));
        }
        return reader.mesh();
    }

    private void binary(ByteBuffer buffer, int count) {
        require(count);
        for (int i = 0; i < count; i++) {
            float[] corners = new float[9];
            for (int j = 0; j < corners.length; j++) {
                corners[j] = buffer.getFloat(HEADER + 4 + i * TRIANGLE + NORMAL + 4 * j);
            }
            add(corners);
        }
    }

    private void text(String text) {
        if (!text.stripLeading().startsWith("solid")) {
            throw new IllegalArgumentException(
                    "the file is not STL: expected the word solid, or a number of triangles that"
                            + " fits its length");
        }
        float[] corners = new float[9];
        int found = 0;
        for (String line : (Iterable<String>) text.lines()::iterator) {
            String[] words = line.strip().split("\\s+");
            if (words.length != 4 || !words[0].equals("vertex")) {
                continue;
            }
            for (int j = 0; j < 3; j++) {
                try {
                    corners[found++] = Float.parseFloat(words[j + 1]);
                } catch (NumberFormatException wrong) {
                    throw new IllegalArgumentException(
                            "'" + words[j + 1] + "' is no number", wrong);
                }
            }
            if (found == corners.length) {
                add(corners);
                require(triangles.size());
                found = 0;
            }
        }
    }

    private static void require(int count) {
        if (count > Mesh.MAX_COUNT) {
            throw new IllegalArgumentException(
                    "the file has more than " + Mesh.MAX_COUNT + " triangles");
        }
    }

    private void add(float[] corners) {
        int[] triangle = new int[3];
        for (int i = 0; i < 3; i++) {
            float[] corner = Arrays.copyOfRange(corners, 3 * i, 3 * i + 3);
            for (float value : corner) {
                if (!Float.isFinite(value)) {
                    throw new IllegalArgumentException("a coordinate is " + value);
                }
            }
            triangle[i] =
                    known.computeIfAbsent(
                            // The addition of 0 converts -0 to 0, so that equal corners have equal
                            // keys.
                            List.of(corner[0] + 0f, corner[1] + 0f, corner[2] + 0f),
                            _ -> {
                                vertices.add(corner);
                                return vertices.size() - 1;
                            });
        }
        if (triangle[0] != triangle[1]
                && triangle[1] != triangle[2]
                && triangle[2] != triangle[0]) {
            triangles.add(triangle);
        }
    }

    private Mesh mesh() {
        if (triangles.isEmpty()) {
            throw new IllegalArgumentException("the file has no triangle");
        }
        float[] points = new float[3 * vertices.size()];
        for (int i = 0; i < vertices.size(); i++) {
            System.arraycopy(vertices.get(i), 0, points, 3 * i, 3);
        }
        return new Mesh(points, triangles.stream().flatMapToInt(Arrays::stream).toArray());
    }
}
