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

/** Plots of results, as PNG files. No display is needed. */
final class Plots {
    private static final Logger LOG = LoggerFactory.getLogger("reve.experiment");

    /** Maximum number of lines in a plot. */
    private static final int MAX_LINES = 12;

    /** Maximum number of points in a line. */
    private static final int MAX_POINTS = 2000;

    private final Path folder;
    private final Experiment experiment;
    private final List<RunResult> results;
    private final List<String> written = new ArrayList<>();

    private Plots(Path folder, Experiment experiment, List<RunResult> results) {
        this.folder = folder;
        this.experiment = experiment;
        this.results = results;
    }

    /**
     * Writes the plots. Each measure is plotted over the variable with the most values. A measure
     * that is taken during the runs is also plotted over time. On a machine without fonts no plots
     * are written, and the log reports this.
     *
     * @return the names of the files
     */
    static List<String> write(Path folder, Experiment experiment, List<RunResult> results)
            throws IOException {
        System.setProperty("java.awt.headless", "true");
        var plots = new Plots(folder, experiment, results);
        try {
            for (int i = 0; i < experiment.measures().size(); i++) {
                plots.overVariable(i);
                plots.overTime(i);
            }
        } catch (RuntimeException | LinkageError | InternalError unable) {
            LOG.warn(
                    "plots cannot be drawn: {}; on Debian, install fontconfig and"
                            + " fonts-dejavu-core",
                    unable.toString());
            LOG.debug("plots", unable);
        }
        return plots.written;
    }

    private void overVariable(int measure) throws IOException {
        Optional<String> variable = mostVaried();
        if (variable.isEmpty()) {
            return;
        }
        Map<String, Map<Double, List<Double>>> lines = new LinkedHashMap<>();
        Map<String, Map<Double, List<Double>>> expected = new LinkedHashMap<>();
        for (RunResult run : results) {
            double x = run.point().values().get(variable.get());
            String name = others(run.point(), variable.get());
            if (run.values().get(measure).orElse(null) instanceof Double y) {
                add(lines, name, x, y);
            }
            run.expected().get(measure).ifPresent(y -> add(expected, name, x, y));
        }
        String name = experiment.measures().get(measure);
        XYChart chart = chart(name, variable.get(), name);
        int drawn = 0;
        for (Map.Entry<String, Map<Double, List<Double>>> line : lines.entrySet()) {
            if (drawn == MAX_LINES) {
                break;
            }
            Color colour = colour(chart, drawn++);
            String label = line.getKey().isEmpty() ? name : line.getKey();
            series(chart, label, line.getValue(), colour)
                    .setXYSeriesRenderStyle(
                            expected.isEmpty()
                                    ? XYSeries.XYSeriesRenderStyle.Line
                                    : XYSeries.XYSeriesRenderStyle.Scatter);
            if (expected.containsKey(line.getKey())) {
                XYSeries curve =
                        series(
                                chart,
                                line.getKey().isEmpty() ? "expected" : label + ", expected",
                                expected.get(line.getKey()),
                                colour);
                curve.setLineStyle(SeriesLines.DASH_DASH);
                curve.setMarker(SeriesMarkers.NONE);
            }
        }
        save(chart, name + "-over-" + variable.get() + ".png", drawn);
    }

    /**
     * Returns the variable with the most values. If several have the most values, returns the last
     * of them. Empty if no variable has several values.
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
        lines.computeIfAbsent(name, _ -> new TreeMap<>())
                .computeIfAbsent(x, _ -> new ArrayList<>())
                .add(y);
    }

    /**
     * Adds the means of the values. If there are several values for one x, adds their standard
     * deviations, too.
     */
    private static XYSeries series(
            XYChart chart, String label, Map<Double, List<Double>> points, Color colour) {
        double[] x = new double[points.size()];
        double[] mean = new double[x.length];
        double[] deviation = new double[x.length];
        boolean several = false;
        int next = 0;
        for (Map.Entry<Double, List<Double>> point : points.entrySet()) {
            List<Double> values = point.getValue();
            double sum = values.stream().reduce(0.0, Double::sum);
            double m = sum / values.size();
            double squares = values.stream().map(y -> (y - m) * (y - m)).reduce(0.0, Double::sum);
            x[next] = point.getKey();
            mean[next] = m;
            deviation[next++] = values.size() < 2 ? 0 : Math.sqrt(squares / (values.size() - 1));
            several |= values.size() > 1;
        }
        XYSeries series =
                several
                        ? chart.addSeries(label, x, mean, deviation)
                        : chart.addSeries(label, x, mean);
        series.setLineColor(colour);
        series.setMarkerColor(colour);
        return series;
    }

    private static Color colour(XYChart chart, int index) {
        Color[] colours = chart.getStyler().getSeriesColors();
        return colours[index % colours.length];
    }

    private String others(RunPoint point, String variable) {
        List<String> parts = new ArrayList<>();
        point.itsCase().ifPresent(parts::add);
        point.values()
                .forEach(
                        (name, value) -> {
                            if (!name.equals(variable)) {
                                parts.add(name + " = " + ResultTable.text(value));
                            }
                        });
        return String.join(", ", parts);
    }

    private void overTime(int measure) throws IOException {
        if (experiment.every().isEmpty()) {
            return;
        }
        String name = experiment.measures().get(measure);
        var table = new ResultTable(experiment, results);
        XYChart chart =
                chart(
                        results.size() > MAX_LINES
                                ? name + ", first " + MAX_LINES + " of " + results.size() + " runs"
                                : name,
                        "time [s]",
                        name);
        int drawn = 0;
        for (RunResult run : results) {
            List<Double> x = new ArrayList<>();
            List<Double> y = new ArrayList<>();
            int step = Math.max(1, run.samples().size() / MAX_POINTS);
            for (int i = 0; i < run.samples().size(); i += step) {
                Sample sample = run.samples().get(i);
                if (sample.values().get(measure).orElse(null) instanceof Double value) {
                    x.add(sample.timeSeconds());
                    y.add(value);
                }
            }
            if (!x.isEmpty() && drawn < MAX_LINES) {
                drawn++;
                chart.addSeries(table.describe(run.point()), x, y).setMarker(SeriesMarkers.NONE);
            }
        }
        save(chart, name + "-over-time.png", drawn);
    }

    private XYChart chart(String title, String x, String y) {
        return Charts.create(experiment.name() + ": " + title, x, y);
    }

    private void save(XYChart chart, String file, int lines) throws IOException {
        if (lines == 0) {
            return;
        }
        Charts.write(chart, folder.resolve(file));
        written.add(file);
    }
}
