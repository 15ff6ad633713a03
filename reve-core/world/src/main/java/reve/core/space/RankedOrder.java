// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import java.util.Arrays;

/**
 * An order of points that keeps neighbours in space mostly adjacent: a Z-curve (Morton) through
 * their ranks on each axis. Ranks replace coordinates so that one distant point does not press all
 * others into one cell. Radix sorts, in time proportional to the number of points; allocates only
 * for more points than ever before.
 */
final class RankedOrder {

    private static final int AXES = 3;
    private static final int RANK_BITS = 10;
    private static final int DIGIT_BITS = 11;
    private static final int DIGITS = 1 << DIGIT_BITS;

    /** Smallest number that is infinite as a float. */
    private static final double BEYOND_FLOATS = 0x1p128;

    /**
     * Number of low bits of a double that are dropped, so that the rest fits the non-finite
     * patterns of a float.
     */
    private static final int SPARE_BITS = 39;

    private final int[] counts = new int[DIGITS];
    private int[] keys = {};
    private int[] codes = {};
    private int[] order = {};
    private int[] spare = {};

    /**
     * Returns the order of the points.
     *
     * @param places (count x 3) coordinates, converted by {@link #sortable}
     * @return indices of points; valid until the next call, may be longer than count
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

    /** Sorts by unsigned keys; equal keys keep the order of their indices. */
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
     * Returns bits whose unsigned order is the order of the numbers, at the precision of floats.
     * Larger numbers use the non-finite patterns of floats, at a relative precision of a ten
     * thousandth.
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
