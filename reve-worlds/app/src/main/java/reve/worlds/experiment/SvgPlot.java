// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.text.Rounded;

import java.math.BigDecimal;
import java.util.List;
import java.util.stream.DoubleStream;
import java.util.stream.IntStream;

/**
 * A plot as an SVG picture inside a page. Colours come from the classes {@code s0} to {@code s11}
 * of the page's style.
 */
final class SvgPlot {
    private static final int WIDTH = 640;
    private static final int HEIGHT = 360;
    private static final int LEFT = 76;
    private static final int RIGHT = 14;
    private static final int TOP = 12;
    private static final int BOTTOM = 46;
    private static final int X_STEPS = 6;
    private static final int Y_STEPS = 5;
    private static final double RADIUS = 3.5;

    /** Maximum number of points of a line in a page. */
    private static final int MAX_POINTS = 400;

    private final Plot plot;
    private final Ticks x;
    private final Ticks y;
    private final StringBuilder out;

    private SvgPlot(Plot plot, StringBuilder out) {
        this.plot = plot;
        this.out = out;
        this.x = ticks(plot.lines().stream().flatMapToDouble(SvgPlot::xs), X_STEPS);
        this.y = ticks(plot.lines().stream().flatMapToDouble(SvgPlot::ys), Y_STEPS);
    }

    private static Ticks ticks(DoubleStream values, int steps) {
        var range = values.filter(Double::isFinite).summaryStatistics();
        return range.getCount() == 0
                ? Ticks.of(0, 1, steps)
                : Ticks.of(range.getMin(), range.getMax(), steps);
    }

    private static DoubleStream xs(Plot.Line line) {
        return line.x().stream().mapToDouble(Double::doubleValue);
    }

    /** Returns the values of a line, and the ends of its bars of deviations. */
    private static DoubleStream ys(Plot.Line line) {
        return IntStream.range(0, line.y().size())
                .mapToObj(i -> i)
                .flatMapToDouble(
                        i -> {
                            double deviation = deviation(line, i);
                            return DoubleStream.of(
                                    line.y().get(i) - deviation, line.y().get(i) + deviation);
                        });
    }

    private static double deviation(Plot.Line line, int point) {
        return line.deviation().isEmpty() ? 0 : line.deviation().get(point);
    }

    /**
     * Appends a plot.
     *
     * @param id prefix of ids, which is unique in the page
     */
    static void append(Plot plot, String id, StringBuilder out) {
        new SvgPlot(plot, out).append(id);
    }

    private void append(String id) {
        out.append("<svg role=\"img\" viewBox=\"0 0 ")
                .append(WIDTH)
                .append(' ')
                .append(HEIGHT)
                .append("\" aria-labelledby=\"")
                .append(id)
                .append("-t ")
                .append(id)
                .append("-d\"><title id=\"")
                .append(id)
                .append("-t\">")
                .append(Html.text(plot.y() + " over " + plot.x()))
                .append("</title><desc id=\"")
                .append(id)
                .append("-d\">")
                .append(Html.text(description()))
                .append("</desc>\n");
        axes();
        plot.lines().forEach(this::line);
        out.append("</svg>\n");
    }

    /** Returns the text alternative of the picture, for example for screen readers. */
    private String description() {
        var text = new StringBuilder();
        for (Plot.Line line : plot.lines()) {
            int last = line.x().size() - 1;
            text.append(text.isEmpty() ? "" : " ")
                    .append(line.label())
                    .append(": ")
                    .append(last + 1)
                    .append(last == 0 ? " point, " : " points, from ")
                    .append(point(line, 0))
                    .append(last == 0 ? "" : " to " + point(line, last))
                    .append('.');
        }
        return text.toString();
    }

    private static String point(Plot.Line line, int point) {
        return "(" + Rounded.of(line.x().get(point)) + ", " + Rounded.of(line.y().get(point)) + ")";
    }

    private double left(double number) {
        return LEFT + x.place(number) * (WIDTH - LEFT - RIGHT);
    }

    private double top(double number) {
        return HEIGHT - BOTTOM - y.place(number) * (HEIGHT - TOP - BOTTOM);
    }

    private static String pixels(double value) {
        return Double.toString(Math.round(value * 10) / 10.0);
    }

    private void axes() {
        for (BigDecimal number : x.numbers()) {
            String at = pixels(left(number.doubleValue()));
            path("grid", "M" + at + " " + TOP + "V" + (HEIGHT - BOTTOM));
            label("tick x", at, Integer.toString(HEIGHT - BOTTOM + 17), x.text(number));
        }
        for (BigDecimal number : y.numbers()) {
            double at = top(number.doubleValue());
            path("grid", "M" + LEFT + " " + pixels(at) + "H" + (WIDTH - RIGHT));
            label("tick y", Integer.toString(LEFT - 7), pixels(at + 4), y.text(number));
        }
        path("frame", "M" + LEFT + " " + TOP + "V" + (HEIGHT - BOTTOM) + "H" + (WIDTH - RIGHT));
        label(
                "axis x",
                pixels((LEFT + WIDTH - RIGHT) / 2.0),
                Integer.toString(HEIGHT - 8),
                plot.x());
        double middle = (TOP + HEIGHT - BOTTOM) / 2.0;
        out.append("<text class=\"axis x\" transform=\"translate(16 ")
                .append(pixels(middle))
                .append(") rotate(-90)\">")
                .append(Html.text(plot.y()))
                .append("</text>\n");
    }

    private void label(String kind, String left, String top, String text) {
        out.append("<text class=\"")
                .append(kind)
                .append("\" x=\"")
                .append(left)
                .append("\" y=\"")
                .append(top)
                .append("\">")
                .append(Html.text(text))
                .append("</text>\n");
    }

    private void path(String kind, String data) {
        out.append("<path class=\"").append(kind).append("\" d=\"").append(data).append("\"/>\n");
    }

    private void line(Plot.Line line) {
        List<Integer> points = shown(line);
        out.append("<g class=\"s").append(line.colour()).append("\">\n");
        if (line.style() != Plot.Style.POINTS && points.size() > 1) {
            var data = new StringBuilder();
            for (int point : points) {
                data.append(data.isEmpty() ? 'M' : 'L')
                        .append(pixels(left(line.x().get(point))))
                        .append(' ')
                        .append(pixels(top(line.y().get(point))));
            }
            path(line.style() == Plot.Style.DASHED ? "dash" : "line", data.toString());
        }
        // A line of one point would otherwise not be visible.
        if (line.style() == Plot.Style.POINTS
                || line.style() == Plot.Style.JOINED
                || points.size() == 1) {
            points.forEach(point -> mark(line, point));
        }
        out.append("</g>\n");
    }

    /** Returns the points that are drawn: finite, and at most about {@value #MAX_POINTS}. */
    private static List<Integer> shown(Plot.Line line) {
        int size = line.x().size();
        int step = (size + MAX_POINTS - 1) / MAX_POINTS;
        return IntStream.range(0, size)
                .filter(i -> i % step == 0 || i == size - 1)
                .filter(i -> Double.isFinite(line.x().get(i)) && Double.isFinite(line.y().get(i)))
                .boxed()
                .toList();
    }

    private void mark(Plot.Line line, int point) {
        double left = left(line.x().get(point));
        double value = line.y().get(point);
        double deviation = deviation(line, point);
        if (deviation > 0 && Double.isFinite(deviation)) {
            path(
                    "bar",
                    "M"
                            + pixels(left)
                            + " "
                            + pixels(top(value - deviation))
                            + "V"
                            + pixels(top(value + deviation)));
        }
        out.append("<circle cx=\"")
                .append(pixels(left))
                .append("\" cy=\"")
                .append(pixels(top(value)))
                .append("\" r=\"")
                .append(RADIUS)
                .append("\"><title>")
                .append(
                        Html.text(
                                line.label()
                                        + ": "
                                        + point(line, point)
                                        + (deviation > 0 ? " ± " + Rounded.of(deviation) : "")))
                .append("</title></circle>\n");
    }
}
