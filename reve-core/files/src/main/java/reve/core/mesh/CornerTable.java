// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import java.util.Arrays;

/**
 * A hash table (open addressing) of the vertices of a mesh. The key of a vertex consists of the
 * three indices of a corner: position, texture coordinates, normal. For one thread.
 */
final class CornerTable {
    private static final int MIN_SLOTS = 16;

    /** Number of the vertex plus 1 in each slot; 0 for a free slot. */
    private int[] slots;

    /** Key of each vertex, in the order of the calls of {@link #add} (vertices x 3). */
    private int[] keys = new int[3 * MIN_SLOTS];

    /** Number of each vertex, in the same order. */
    private int[] vertices = new int[MIN_SLOTS];

    private int count;

    /**
     * @param expected estimate of the number of vertices
     */
    CornerTable(int expected) {
        int wanted = Math.clamp(2L * expected, MIN_SLOTS, 1 << 22);
        slots = new int[Integer.highestOneBit(wanted - 1) << 1];
    }

    /**
     * Returns the vertex of a corner; -1 if no earlier corner has the same three indices.
     *
     * @param corners contains the three indices
     * @param at index of the first one
     */
    int find(int[] corners, int at) {
        int entry = slots[slot(corners, at)];
        return entry == 0 ? -1 : vertices[entry - 1];
    }

    /** Adds the vertex of a corner that {@link #find} did not find. */
    void add(int[] corners, int at, int vertex) {
        if (4 * (count + 1) >= 3 * slots.length) {
            rehash();
        }
        if (count == vertices.length) {
            vertices = Arrays.copyOf(vertices, 2 * count);
            keys = Arrays.copyOf(keys, 6 * count);
        }
        slots[slot(corners, at)] = count + 1;
        System.arraycopy(corners, at, keys, 3 * count, 3);
        vertices[count++] = vertex;
    }

    /** Returns the slot of a corner, or the free slot for it. */
    private int slot(int[] from, int at) {
        int hash = 31 * (31 * from[at] + from[at + 1]) + from[at + 2];
        int slot = (hash * 0x9e3779b9 >>> 8) & slots.length - 1;
        while (slots[slot] > 0
                && !Arrays.equals(from, at, at + 3, keys, 3 * slots[slot] - 3, 3 * slots[slot])) {
            slot = slot + 1 & slots.length - 1;
        }
        return slot;
    }

    private void rehash() {
        slots = new int[2 * slots.length];
        for (int entry = 0; entry < count; entry++) {
            slots[slot(keys, 3 * entry)] = entry + 1;
        }
    }
}
