// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import java.util.Arrays;

/**
 * A priority queue of nodes of a {@link BoxIndex} by distance from a point, nearest first. It is a
 * binary heap in arrays. Inner nodes precede boxes at equal distance, because a node may contain a
 * box with a lower key. Boxes at equal distance are ordered by key.
 */
final class Queue {

    /** The key of a node that is not a box. It is lower than all other keys. */
    static final long NODE = Long.MIN_VALUE;

    private double[] distances = new double[64];
    private long[] keys = new long[64];
    private int[] nodes = new int[64];
    private int size;

    void clear() {
        size = 0;
    }

    boolean isEmpty() {
        return size == 0;
    }

    int node() {
        return nodes[0];
    }

    void add(double distance, long key, int node) {
        if (size == nodes.length) {
            distances = Arrays.copyOf(distances, 2 * size);
            keys = Arrays.copyOf(keys, 2 * size);
            nodes = Arrays.copyOf(nodes, 2 * size);
        }
        int at = size++;
        while (at > 0 && isBefore(distance, key, (at - 1) / 2)) {
            move((at - 1) / 2, at);
            at = (at - 1) / 2;
        }
        put(at, distance, key, node);
    }

    /** Removes the nearest node. */
    void remove() {
        size--;
        double distance = distances[size];
        long key = keys[size];
        int at = 0;
        while (2 * at + 1 < size) {
            int child = 2 * at + 1;
            if (child + 1 < size && isBefore(distances[child + 1], keys[child + 1], child)) {
                child++;
            }
            if (!isBefore(distances[child], keys[child], distance, key)) {
                break;
            }
            move(child, at);
            at = child;
        }
        put(at, distance, key, nodes[size]);
    }

    private boolean isBefore(double distance, long key, int at) {
        return isBefore(distance, key, distances[at], keys[at]);
    }

    private static boolean isBefore(double distance, long key, double other, long otherKey) {
        return distance < other || distance == other && key < otherKey;
    }

    private void move(int from, int to) {
        put(to, distances[from], keys[from], nodes[from]);
    }

    private void put(int at, double distance, long key, int node) {
        distances[at] = distance;
        keys[at] = key;
        nodes[at] = node;
    }
}
