// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import java.awt.image.IndexColorModel;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.List;

/**
 * The colours that best represent all colours of a video. They are found by median cuts: the box of
 * colours with the largest spread is divided until there are enough boxes. The index after the last
 * colour stands for transparent pixels. An ordered dither with a fixed pattern hides the steps
 * between the colours.
 */
final class Palette {
    /** Number of colours. */
    static final int SIZE = 255;

    private static final int BITS = 5;
    private static final int SIDE = 1 << BITS;
    private static final int CELLS = SIDE * SIDE * SIDE;
    private static final int PATTERN = 4;
    private static final int DITHER = 8;

    /**
     * Bayer's matrix. It contains the thresholds 0 to 15 in an order that makes no visible lines.
     */
    private static final int[] BAYER = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};

    private final int[] colours = new int[SIZE];

    /**
     * Numbers of the nearest colours, by cell. The value is -1 if no colour was searched for the
     * cell.
     */
    private final int[] nearest = new int[CELLS];

    /**
     * Counts and sums of the colours of all pictures, by cell. A cell is a set of similar colours.
     */
    static final class Histogram {
        private final long[] counts = new long[CELLS];
        private final long[] sums = new long[3 * CELLS];

        void add(int rgb) {
            int cell = cell(rgb >> 16 & 0xff, rgb >> 8 & 0xff, rgb & 0xff);
            counts[cell]++;
            sums[3 * cell] += rgb >> 16 & 0xff;
            sums[3 * cell + 1] += rgb >> 8 & 0xff;
            sums[3 * cell + 2] += rgb & 0xff;
        }

        private double mean(int cell, int channel) {
            return (double) sums[3 * cell + channel] / counts[cell];
        }
    }

    /** A set of cells. */
    private static final class Box {
        private final List<Integer> cells;
        private final int axis;
        private final double spread;

        Box(Histogram histogram, List<Integer> cells) {
            this.cells = cells;
            int widest = 0;
            double most = -1;
            for (int channel = 0; channel < 3; channel++) {
                double spread = spread(histogram, cells, channel);
                if (spread > most) {
                    most = spread;
                    widest = channel;
                }
            }
            axis = widest;
            spread = cells.size() > 1 ? most : -1;
        }

        /** Returns the sum of squared distances from the mean. Rare colours are included. */
        private static double spread(Histogram histogram, List<Integer> cells, int channel) {
            double weights = 0;
            double sum = 0;
            double squares = 0;
            for (int cell : cells) {
                double weight = Math.sqrt(histogram.counts[cell]);
                double mean = histogram.mean(cell, channel);
                weights += weight;
                sum += weight * mean;
                squares += weight * mean * mean;
            }
            return squares - sum * sum / weights;
        }

        List<Box> halves(Histogram histogram) {
            List<Integer> sorted = new ArrayList<>(cells);
            sorted.sort(
                    Comparator.<Integer>comparingDouble(cell -> histogram.mean(cell, axis))
                            .thenComparing(Comparator.naturalOrder()));
            double all = 0;
            for (int cell : sorted) {
                all += Math.sqrt(histogram.counts[cell]);
            }
            double half = 0;
            int cut = 0;
            while (cut < sorted.size() - 1 && (cut == 0 || half < all / 2)) {
                half += Math.sqrt(histogram.counts[sorted.get(cut)]);
                cut++;
            }
            return List.of(
                    new Box(histogram, sorted.subList(0, cut)),
                    new Box(histogram, sorted.subList(cut, sorted.size())));
        }

        int colour(Histogram histogram) {
            long count = 0;
            long[] sums = new long[3];
            for (int cell : cells) {
                count += histogram.counts[cell];
                for (int channel = 0; channel < 3; channel++) {
                    sums[channel] += histogram.sums[3 * cell + channel];
                }
            }
            int rgb = 0;
            for (long sum : sums) {
                rgb = rgb << 8 | (int) ((sum + count / 2) / count);
            }
            return rgb;
        }
    }

    Palette(Histogram histogram) {
        List<Integer> used = new ArrayList<>();
        for (int cell = 0; cell < CELLS; cell++) {
            if (histogram.counts[cell] > 0) {
                used.add(cell);
            }
        }
        List<Box> boxes = new ArrayList<>();
        if (!used.isEmpty()) {
            boxes.add(new Box(histogram, used));
        }
        while (!boxes.isEmpty() && boxes.size() < SIZE) {
            Box widest = boxes.getFirst();
            for (Box box : boxes) {
                widest = box.spread > widest.spread ? box : widest;
            }
            if (widest.spread < 0) {
                break;
            }
            boxes.remove(widest);
            boxes.addAll(widest.halves(histogram));
        }
        for (int i = 0; i < boxes.size(); i++) {
            colours[i] = boxes.get(i).colour(histogram);
        }
        Arrays.fill(nearest, -1);
    }

    private static int cell(int red, int green, int blue) {
        int shift = 8 - BITS;
        return (red >> shift) << 2 * BITS | (green >> shift) << BITS | blue >> shift;
    }

    /**
     * Returns a colour model with the colours of the palette and the transparent colour after them.
     */
    IndexColorModel colours() {
        int[] all = new int[SIZE + 1];
        for (int i = 0; i < SIZE; i++) {
            all[i] = 0xff000000 | colours[i];
        }
        return new IndexColorModel(8, all.length, all, 0, true, SIZE, 0);
    }

    /** Returns the number of a colour for each pixel of a picture, given as r, g, b. */
    byte[] indices(byte[] rgb, int width) {
        byte[] indices = new byte[rgb.length / 3];
        for (int i = 0; i < indices.length; i++) {
            int x = i % width % PATTERN;
            int y = i / width % PATTERN;
            int shift = (2 * BAYER[y * PATTERN + x] - 15) * DITHER / 32;
            indices[i] =
                    (byte)
                            nearest(
                                    Math.clamp((rgb[3 * i] & 0xff) + shift, 0, 255),
                                    Math.clamp((rgb[3 * i + 1] & 0xff) + shift, 0, 255),
                                    Math.clamp((rgb[3 * i + 2] & 0xff) + shift, 0, 255));
        }
        return indices;
    }

    private int nearest(int red, int green, int blue) {
        int cell = cell(red, green, blue);
        if (nearest[cell] < 0) {
            int half = 1 << 7 - BITS;
            int r = (red >> 8 - BITS << 8 - BITS) + half;
            int g = (green >> 8 - BITS << 8 - BITS) + half;
            int b = (blue >> 8 - BITS << 8 - BITS) + half;
            int best = 0;
            long least = Long.MAX_VALUE;
            for (int i = 0; i < SIZE; i++) {
                long dr = r - (colours[i] >> 16 & 0xff);
                long dg = g - (colours[i] >> 8 & 0xff);
                long db = b - (colours[i] & 0xff);
                long distance = 3 * dr * dr + 6 * dg * dg + db * db;
                if (distance < least) {
                    least = distance;
                    best = i;
                }
            }
            nearest[cell] = best;
        }
        return nearest[cell];
    }
}
