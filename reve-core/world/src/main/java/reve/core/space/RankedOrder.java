// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import java.util.Arrays;

/**
 * Sorter of points along a Z-order curve (Morton curve). Points that are neighbours in space mostly
 * become neighbours in this order. The curve uses the rank of each point on each axis instead of
 * its coordinate. A single distant point therefore does not move all other points into one cell of
 * the curve.
 *
 * <p>The sorter uses radix sorts, whose time is proportional to the number of points. It allocates
 * memory only for more points than in all earlier calls.
 */
final class RankedOrder {

    private static final int AXES = 3;
    private static final int RANK_BITS = 10;
    private static final int DIGIT_BITS = 11;
    private static final int DIGITS = 1 << DIGIT_BITS;

    /** Smallest power of 2 beyond the range of floats. */
    private static final double BEYOND_FLOATS = 0x1p128;

    /**
     * Number of low bits that are dropped from a double beyond the range of floats. The remaining
     * bits fit into the bit patterns of non-finite floats.
     */
    private static final int SPARE_BITS = 39;

    private final int[] counts = new int[DIGITS];
    private int[] keys = {};
    private int[] codes = {};
    private int[] order = {};
    private int[] spare = {};

    /**
     * Returns the indices of the points in their order along the Z-order curve.
     *
     * @param places (count x 3) coordinates, converted by {@link #sortable}
     * @return indices; only the first {@code count} elements are valid, and only until the next
     *     call
     */
    int[] sort(int[] places, int count) {
        reserve(count);
        Arrays.fill(codes, 0, count, 0);
        for (int axis = 0; axis < AXES; axis++) {
            for (int i = 0; i < count; i++) {
                keys[i] = places[AXES * i + axis];
            }
            sortByKeys(keys, count);
            for (int rank = 0; rank < count; rank++) {
                int cell = (int) (((long) rank << RANK_BITS) / count);
                codes[order[rank]] |= spread(cell) << axis;
            }
        }
        sortByKeys(codes, count);
        return order;
    }

    /**
     * Sets {@link #order} to the indices of the keys in ascending unsigned order of the keys. Equal
     * keys are ordered by index.
     */
    private void sortByKeys(int[] by, int count) {
        for (int i = 0; i < count; i++) {
            order[i] = i;
        }
        for (int shift = 0; shift < Integer.SIZE; shift += DIGIT_BITS) {
            Arrays.fill(counts, 0);
            for (int i = 0; i < count; i++) {
                counts[(by[i] >>> shift) & (DIGITS - 1)]++;
            }
            int before = 0;
            for (int digit = 0; digit < DIGITS; digit++) {
                int ofDigit = counts[digit];
                counts[digit] = before;
                before += ofDigit;
            }
            for (int i = 0; i < count; i++) {
                int index = order[i];
                spare[counts[(by[index] >>> shift) & (DIGITS - 1)]++] = index;
            }
            int[] sorted = spare;
            spare = order;
            order = sorted;
        }
    }

    /**
     * Converts a coordinate into bits whose unsigned order is the order of the coordinates, at the
     * precision of floats. Numbers beyond the range of floats become bit patterns of non-finite
     * floats, and keep a relative precision of a ten thousandth.
     */
    static int sortable(double value) {
        int bits = Float.floatToRawIntBits((float) value);
        if (Math.abs(value) >= BEYOND_FLOATS) {
            long above =
                    Double.doubleToRawLongBits(Math.abs(value))
                            - Double.doubleToRawLongBits(BEYOND_FLOATS);
            bits =
                    Float.floatToRawIntBits(Float.POSITIVE_INFINITY) + (int) (above >>> SPARE_BITS)
                            | (value < 0 ? Integer.MIN_VALUE : 0);
        }
        return bits ^ (bits >> 31 | Integer.MIN_VALUE);
    }

    /** Inserts two zero bits after each of ten bits. */
    private static int spread(int bits) {
        int spread = (bits | bits << 16) & 0x030000FF;
        spread = (spread | spread << 8) & 0x0300F00F;
        spread = (spread | spread << 4) & 0x030C30C3;
        return (spread | spread << 2) & 0x09249249;
    }

    private void reserve(int count) {
        if (keys.length < count) {
            int room = Math.max(count, 2 * keys.length);
            keys = new int[room];
            codes = new int[room];
            order = new int[room];
            spare = new int[room];
        }
    }
}
