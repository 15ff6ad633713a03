// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import java.util.List;

/**
 * A plot of results, independent of the format in which it is drawn.
 *
 * @param name name of the plot, without a file extension
 * @param title title for readers
 * @param x title of the horizontal axis
 * @param y title of the vertical axis
 */
record Plot(String name, String title, String x, String y, List<Line> lines) {
    /** Copies the list. */
    Plot {
        lines = List.copyOf(lines);
    }

    /** How a line is drawn. */
    enum Style {
        /** Points, joined by lines. */
        JOINED,
        /** Points only. */
        POINTS,
        /** A line without marks. */
        CURVE,
        /** A dashed line without marks. */
        DASHED
    }

    /**
     * A line of a plot. All numbers of its points are finite.
     *
     * @param colour number of the colour; a line of expected values has the colour of the measured
     *     line
     * @param deviation standard deviation of each y; empty if each y is a single value
     */
    record Line(
            String label,
            int colour,
            Style style,
            List<Double> x,
            List<Double> y,
            List<Double> deviation) {
        /** Copies the lists. */
        Line {
            x = List.copyOf(x);
            y = List.copyOf(y);
            deviation = List.copyOf(deviation);
        }
    }
}
