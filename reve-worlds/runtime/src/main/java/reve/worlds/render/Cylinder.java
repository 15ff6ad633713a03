// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import reve.core.world.Mesh;

/** The mesh of a cylinder with diameter 1 and height 1 along its Y axis, with smooth sides. */
final class Cylinder {
    private static final int SIDES = 32;

    /** The mesh. Instances scale it to their size. */
    static final Mesh MESH = make();

    private Cylinder() {}

    private static Mesh make() {
        float[] vertices = new float[3 * 4 * SIDES];
        float[] normals = new float[vertices.length];
        int[] triangles = new int[3 * (2 * SIDES + 2 * (SIDES - 2))];
        int next = 0;
        for (int side = 0; side < SIDES; side++) {
            double angle = 2 * Math.PI * side / SIDES;
            float x = (float) Math.cos(angle);
            float z = (float) Math.sin(angle);
            // The corners form rings: first the lower and upper edge of the side, then the edges of
            // the two caps.
            for (int ring = 0; ring < 4; ring++) {
                int at = 3 * (ring * SIDES + side);
                boolean upper = ring % 2 == 1;
                vertices[at] = x / 2;
                vertices[at + 1] = upper ? 0.5f : -0.5f;
                vertices[at + 2] = z / 2;
                normals[at] = ring < 2 ? x : 0;
                normals[at + 1] = ring < 2 ? 0 : upper ? 1 : -1;
                normals[at + 2] = ring < 2 ? z : 0;
            }
            int other = (side + 1) % SIDES;
            next = add(triangles, next, side, SIDES + side, SIDES + other);
            next = add(triangles, next, side, SIDES + other, other);
        }
        for (int side = 1; side < SIDES - 1; side++) {
            int low = 2 * SIDES;
            int high = 3 * SIDES;
            next = add(triangles, next, low, low + side, low + side + 1);
            next = add(triangles, next, high, high + side + 1, high + side);
        }
        return Mesh.builder(vertices, triangles).normals(normals).build();
    }

    private static int add(int[] triangles, int at, int a, int b, int c) {
        triangles[at] = a;
        triangles[at + 1] = b;
        triangles[at + 2] = c;
        return at + 3;
    }
}
