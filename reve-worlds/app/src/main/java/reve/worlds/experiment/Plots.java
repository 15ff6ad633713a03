// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import org.knowm.xchart.XYChart;
import org.knowm.xchart.XYSeries;
import org.knowm.xchart.style.lines.SeriesLines;
import org.knowm.xchart.style.markers.SeriesMarkers;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.file.Experiment;
import reve.core.file.RunPoint;
import reve.core.text.Rounded;
import reve.core.unit.Unit;
import reve.worlds.plot.Charts;

import java.awt.Color;
import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;

/** Plots of results, and their PNG files. No display is needed. */
final class Plots {
    private static final Logger LOG = LoggerFactory.getLogger("reve.experiment");

    private static final String ENDING = ".png";

    /** Maximum number of lines in a plot. */
    private static final int MAX_LINES = 12;

    /** Maximum number of points in a line. */
    private static final int MAX_POINTS = 2000;

    private final Experiment experiment;
    private final List<RunResult> results;
    private final List<Plot> plots = new ArrayList<>();

    private Plots(Experiment experiment, List<RunResult> results) {
        this.experiment = experiment;
        this.results = results;
    }

    /**
     * Writes the plots. Each measure is plotted over the variable with the most values. A measure
     * that is taken during the runs is also plotted over time. No plots are written on a machine
     * without fonts, and the log reports this.
     *
     * @return the names of the files
     */
    static List<String> write(Path folder, Experiment experiment, List<RunResult> results)
            throws IOException {
        System.setProperty("java.awt.headless", "true");
        List<String> written = new ArrayList<>();
        try {
            for (Map.Entry<String, XYChart> chart : charts(experiment, results).entrySet()) {
                Charts.write(chart.getValue(), folder.resolve(chart.getKey()));
                written.add(chart.getKey());
            }
        } catch (RuntimeException | LinkageError | InternalError unable) {
            if (isEnding()) {
                // Some classes for drawing cannot be initialised any more.
                throw new IOException("the process ended while plots were drawn", unable);
            }
            LOG.warn(
                    "plots cannot be drawn: {}; on Debian, install fontconfig and"
                            + " fonts-dejavu-core",
                    unable.toString());
            LOG.debug("plots", unable);
        }
        return written;
    }

    /** Returns whether the Java runtime is ending, for example after Ctrl-C. */
    private static boolean isEnding() {
        var probe = new Thread(() -> {});
        try {
            Runtime.getRuntime().addShutdownHook(probe);
            Runtime.getRuntime().removeShutdownHook(probe);
            return false;
        } catch (IllegalStateException ending) {
            return true;
        }
    }

    /** Returns the charts by the names of their files. */
    static Map<String, XYChart> charts(Experiment experiment, List<RunResult> results) {
        Map<String, XYChart> charts = new LinkedHashMap<>();
        of(experiment, results).forEach(plot -> charts.put(plot.name() + ENDING, chart(plot)));
        return charts;
    }

    /**
     * Returns the plots. The numbers of a measure are in its {@link Experiment#measurementUnit} and
     * {@link Experiment#valueUnit}, and those of a variable in SI units.
     */
    static List<Plot> of(Experiment experiment, List<RunResult> results) {
        var plots = new Plots(experiment, results);
        for (int i = 0; i < experiment.measures().size(); i++) {
            plots.overVariable(i);
            plots.overTime(i);
        }
        return List.copyOf(plots.plots);
    }

    private void overVariable(int measure) {
        Optional<String> variable = mostVaried();
        if (variable.isEmpty()) {
            return;
        }
        Optional<Unit> unit = experiment.valueUnit(measure);
        double scale = unit.map(Unit::scale).orElse(1.0);
        Map<String, Map<Double, List<Double>>> lines = new LinkedHashMap<>();
        Map<String, Map<Double, List<Double>>> expected = new LinkedHashMap<>();
        for (RunResult run : results) {
            double x = run.point().values().get(variable.get());
            String name = others(run.point(), variable.get());
            if (run.values().get(measure).orElse(null) instanceof Double y) {
                add(lines, name, x, y / scale);
            }
            run.expected().get(measure).ifPresent(y -> add(expected, name, x, y / scale));
        }
        String name = experiment.measures().get(measure);
        List<Plot.Line> drawn = new ArrayList<>();
        int colour = 0;
        for (Map.Entry<String, Map<Double, List<Double>>> line : lines.entrySet()) {
            if (colour == MAX_LINES) {
                break;
            }
            String label = line.getKey().isEmpty() ? name : line.getKey();
            drawn.add(
                    line(
                            label,
                            colour,
                            expected.isEmpty() ? Plot.Style.JOINED : Plot.Style.POINTS,
                            line.getValue()));
            if (expected.containsKey(line.getKey())) {
                drawn.add(
                        line(
                                line.getKey().isEmpty() ? "expected" : label + ", expected",
                                colour,
                                Plot.Style.DASHED,
                                expected.get(line.getKey())));
            }
            colour++;
        }
        keep(
                name + "-over-" + variable.get(),
                name,
                title(variable.get(), experiment.variableUnit(variable.get())),
                title(name, unit),
                drawn);
    }

    /**
     * Returns the variable with the most values. Returns the last of several such variables. The
     * result is empty if no variable has several values.
     */
    private Optional<String> mostVaried() {
        Optional<String> most = Optional.empty();
        long values = 2;
        for (String name : experiment.variables()) {
            long count =
                    results.stream().map(run -> run.point().values().get(name)).distinct().count();
            if (count >= values) {
                most = Optional.of(name);
                values = count;
            }
        }
        return most;
    }

    private static void add(
            Map<String, Map<Double, List<Double>>> lines, String name, double x, double y) {
        if (Double.isFinite(x) && Double.isFinite(y)) {
            lines.computeIfAbsent(name, _ -> new TreeMap<>())
                    .computeIfAbsent(x, _ -> new ArrayList<>())
                    .add(y);
        }
    }

    /**
     * Returns a line with the mean of the values at each x. The line has standard deviations if
     * there are several values at one x.
     */
    private static Plot.Line line(
            String label, int colour, Plot.Style style, Map<Double, List<Double>> points) {
        List<Double> mean = new ArrayList<>();
        List<Double> deviation = new ArrayList<>();
        boolean several = false;
        for (List<Double> values : points.values()) {
            double sum = values.stream().reduce(0.0, Double::sum);
            double m = sum / values.size();
            double squares = values.stream().map(y -> (y - m) * (y - m)).reduce(0.0, Double::sum);
            mean.add(m);
            deviation.add(values.size() < 2 ? 0 : Math.sqrt(squares / (values.size() - 1)));
            several |= values.size() > 1;
        }
        return new Plot.Line(
                label,
                colour,
                style,
                List.copyOf(points.keySet()),
                mean,
                several ? deviation : List.of());
    }

    private String others(RunPoint point, String variable) {
        List<String> parts = new ArrayList<>();
        point.itsCase().ifPresent(parts::add);
        point.values()
                .forEach(
                        (name, value) -> {
                            if (!name.equals(variable)) {
                                String unit =
                                        symbol(experiment.variableUnit(name))
                                                .map(symbol -> " " + symbol)
                                                .orElse("");
                                parts.add(name + " = " + Rounded.of(value) + unit);
                            }
                        });
        return String.join(", ", parts);
    }

    private void overTime(int measure) {
        if (experiment.every().isEmpty()) {
            return;
        }
        String name = experiment.measures().get(measure);
        Optional<Unit> unit = experiment.measurementUnit(measure);
        double scale = unit.map(Unit::scale).orElse(1.0);
        List<Plot.Line> drawn = new ArrayList<>();
        for (RunResult run : results) {
            List<Double> x = new ArrayList<>();
            List<Double> y = new ArrayList<>();
            int step = Math.max(1, run.samples().size() / MAX_POINTS);
            for (int i = 0; i < run.samples().size(); i += step) {
                Sample sample = run.samples().get(i);
                if (sample.values().get(measure).orElse(null) instanceof Double value
                        && Double.isFinite(value / scale)) {
                    x.add(sample.timeSeconds());
                    y.add(value / scale);
                }
            }
            if (!x.isEmpty() && drawn.size() < MAX_LINES) {
                drawn.add(
                        new Plot.Line(
                                ResultTable.describe(run.point(), Rounded::of),
                                drawn.size(),
                                Plot.Style.CURVE,
                                x,
                                y,
                                List.of()));
            }
        }
        keep(
                name + "-over-time",
                results.size() > MAX_LINES
                        ? name + ", first " + MAX_LINES + " of " + results.size() + " runs"
                        : name,
                "time [s]",
                title(name, unit),
                drawn);
    }

    /** Returns the title of an axis, such as {@code speed [km/h]}. */
    private static String title(String name, Optional<Unit> unit) {
        return symbol(unit).map(symbol -> name + " [" + symbol + "]").orElse(name);
    }

    /** Returns the symbol of a unit; empty for an unknown unit and for plain numbers. */
    static Optional<String> symbol(Optional<Unit> unit) {
        return unit.map(Unit::symbol).filter(symbol -> !symbol.equals(Unit.ONE.symbol()));
    }

    private void keep(String name, String title, String x, String y, List<Plot.Line> lines) {
        if (!lines.isEmpty()) {
            plots.add(new Plot(name, experiment.name() + ": " + title, x, y, lines));
        }
    }

    /** Returns a plot as a chart for a PNG file. */
    private static XYChart chart(Plot plot) {
        XYChart chart = Charts.create(plot.title(), plot.x(), plot.y());
        for (Plot.Line line : plot.lines()) {
            XYSeries series =
                    line.deviation().isEmpty()
                            ? chart.addSeries(line.label(), line.x(), line.y())
                            : chart.addSeries(line.label(), line.x(), line.y(), line.deviation());
            Color[] colours = chart.getStyler().getSeriesColors();
            Color colour = colours[line.colour() % colours.length];
            series.setLineColor(colour);
            series.setMarkerColor(colour);
            switch (line.style()) {
                case JOINED -> {}
                case POINTS -> series.setXYSeriesRenderStyle(XYSeries.XYSeriesRenderStyle.Scatter);
                case CURVE -> series.setMarker(SeriesMarkers.NONE);
                case DASHED -> {
                    series.setLineStyle(SeriesLines.DASH_DASH);
                    series.setMarker(SeriesMarkers.NONE);
                }
            }
        }
        return chart;
    }
}
