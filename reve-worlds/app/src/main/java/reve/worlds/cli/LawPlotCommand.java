// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.knowm.xchart.XYChart;
import org.knowm.xchart.XYSeries;
import org.knowm.xchart.style.Styler;
import org.knowm.xchart.style.markers.SeriesMarkers;

import picocli.CommandLine.Command;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.worlds.Product;
import reve.worlds.plot.Charts;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.math.BigDecimal;
import java.math.MathContext;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;

/**
 * The command {@code law plot}. It draws the force and energy of a law over the distance of two
 * bodies, their speed or their place, or the energy of a small scene over the time. The program
 * {@code vesper} computes the values.
 */
@Command(
        name = "plot",
        description =
                "Draws force and energy of a law over distance, speed or place, or the energy of a"
                        + " small scene over time.")
public final class LawPlotCommand implements Callable<Integer> {
    /**
     * Fraction of the values that determines the range of an axis. It contains the smallest values,
     * and larger values may be outside of the chart.
     */
    private static final double USUAL = 0.7;

    /** Range of an axis, as a multiple of the usual values. */
    private static final double RANGE = 4;

    /** Precision of the numbers on the horizontal axis. */
    private static final MathContext DIGITS = new MathContext(4);

    /** The axis that shows how the energy of the scene of {@code law run} changes. */
    private static final String TIME = "time";

    /** Number of times at which the energy is drawn. */
    private static final int TIMES = 401;

    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(paramLabel = "FILE", description = "The law's file, such as wind.law.")
    private Path file = Path.of("");

    @Option(
            names = "--out",
            paramLabel = "FILE",
            description = "PNG file to write (default: the law's name and .png).")
    private Optional<Path> out = Optional.empty();

    @Option(
            names = "--parameter",
            paramLabel = "NAME=VALUE",
            description = "Value of a parameter in SI units; may be repeated.")
    private List<String> parameters = List.of();

    @Option(
            names = "--set",
            paramLabel = "NAME=VALUE",
            description =
                    "Value of a property, also of the law's own, in its unit; may be repeated.")
    private List<String> properties = List.of();

    @Option(
            names = "--over",
            paramLabel = "X",
            description =
                    "distance, speed, place or time (default: what the force depends on). time"
                            + " draws the energy of the scene of law run.")
    private Optional<String> over = Optional.empty();

    @Option(names = "--from", paramLabel = "X", description = "First value [m or m/s].")
    private Optional<Double> from = Optional.empty();

    @Option(names = "--to", paramLabel = "X", description = "Last value [m or m/s].")
    private Optional<Double> to = Optional.empty();

    @Option(
            names = "--seconds",
            paramLabel = "S",
            description = "Duration with --over time [s] (default: 5).")
    private Optional<Double> seconds = Optional.empty();

    @Option(
            names = "--dt",
            paramLabel = "S",
            description = "Time step with --over time [s] (default: 0.001).")
    private Optional<Double> dt = Optional.empty();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws IOException, InterruptedException {
        requireFitting();
        Path usual = Path.of(file.getFileName().toString().replaceFirst("\\.law$", "") + ".png");
        Path picture =
                WritableFile.require(spec, "--out", out.orElse(usual), "PNG\r\n", "a PNG picture");
        var process = new ProcessBuilder(command()).redirectErrorStream(false).start();
        process.getOutputStream().close();
        String values = new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        String errors = new String(process.getErrorStream().readAllBytes(), StandardCharsets.UTF_8);
        int code = process.waitFor();
        spec.commandLine().getErr().print(errors);
        spec.commandLine().getErr().flush();
        if (code != ExitCode.OK) {
            return code;
        }
        JsonNode curve = new JsonMapper().readTree(values);
        System.setProperty("java.awt.headless", "true");
        Charts.write(overTime() ? energyChart(curve) : chart(curve), picture);
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("picture", picture.toString());
            curve.properties().forEach(field -> fields.put(field.getKey(), field.getValue()));
            Json.print(spec, fields);
        } else {
            spec.commandLine().getOut().println(picture);
            spec.commandLine().getOut().flush();
        }
        return ExitCode.OK;
    }

    private boolean overTime() {
        return over.equals(Optional.of(TIME));
    }

    private void requireFitting() {
        if (overTime() ? from.isPresent() || to.isPresent() : seconds.or(() -> dt).isPresent()) {
            throw new ParameterException(
                    spec.commandLine(),
                    overTime()
                            ? "--from and --to do not fit --over time; --seconds sets the duration"
                            : "--seconds and --dt fit --over time only");
        }
    }

    private List<String> command() {
        List<String> command =
                new ArrayList<>(
                        List.of(
                                Product.nativeFolder().resolve("vesper").toString(),
                                "law",
                                overTime() ? "run" : "plot",
                                file.toString(),
                                "--json"));
        if (overTime()) {
            command.addAll(List.of("--rows", String.valueOf(TIMES)));
        } else {
            over.ifPresent(value -> command.addAll(List.of("--over", value)));
        }
        seconds.ifPresent(value -> command.addAll(List.of("--seconds", value.toString())));
        dt.ifPresent(value -> command.addAll(List.of("--dt", value.toString())));
        from.ifPresent(value -> command.addAll(List.of("--from", value.toString())));
        to.ifPresent(value -> command.addAll(List.of("--to", value.toString())));
        parameters.forEach(value -> command.addAll(List.of("--parameter", value)));
        properties.forEach(value -> command.addAll(List.of("--set", value)));
        return command;
    }

    private static XYChart chart(JsonNode curve) {
        JsonNode points = curve.get("points");
        String name = curve.get("over").asString();
        String component = curve.get("component").asString();
        String along =
                name.equals("distance") && component.equals("x")
                        ? "force [N] (above 0: repulsion)"
                        : "force along " + component + " [N]";
        String title = curve.get("law").asString() + ": force over " + name;
        XYChart chart =
                Charts.create(title, name + " [" + curve.get("unit").asString() + "]", along);
        chart.getStyler().setLegendPosition(Styler.LegendPosition.InsideNE);
        chart.setCustomXAxisTickLabelsFormatter(LawPlotCommand::label);
        double[] x = column(points, 0);
        add(chart, "force", x, column(points, 1), 0);
        if (points.get(0).size() > 2) {
            add(chart, "energy", x, column(points, 2), 1);
            chart.setYAxisGroupTitle(1, "energy [J]");
            chart.getStyler().setYAxisGroupPosition(1, Styler.YAxisPosition.Right);
        }
        return chart;
    }

    /** Draws the energy of a scene over the time. The title states how far the sum has drifted. */
    private static XYChart energyChart(JsonNode run) {
        JsonNode rows = run.get("rows");
        double[] time = field(rows, "time");
        double[] kinetic = field(rows, "kinetic");
        boolean complete = rows.get(0).has("potential");
        String title = run.get("law").asString() + " with " + run.get("with").asString() + ": ";
        if (!complete) {
            XYChart chart = Charts.create(title + "kinetic energy", "time [s]", "energy [J]");
            line(chart, "kinetic", time, kinetic);
            return chart;
        }
        double[] potential = field(rows, "potential");
        double[] sum = new double[time.length];
        Arrays.setAll(sum, i -> kinetic[i] + potential[i]);
        double scale = Arrays.stream(kinetic).max().orElse(0);
        double drift = sum[sum.length - 1] - sum[0];
        XYChart chart =
                Charts.create(
                        title
                                + String.format(
                                        Locale.ROOT,
                                        "the energy drifts by %.3g J (%.3g %%)",
                                        drift,
                                        scale == 0 ? 0 : 100 * drift / scale),
                        "time [s]",
                        "energy [J]");
        line(chart, "kinetic", time, kinetic);
        line(chart, "potential", time, potential);
        line(chart, "sum", time, sum);
        return chart;
    }

    private static void line(XYChart chart, String name, double[] x, double[] y) {
        chart.addSeries(name, x, y).setMarker(SeriesMarkers.NONE);
    }

    private static double[] field(JsonNode rows, String name) {
        double[] values = new double[rows.size()];
        Arrays.setAll(values, i -> rows.get(i).get(name).asDouble());
        return values;
    }

    private static String label(double value) {
        return new BigDecimal(value).round(DIGITS).stripTrailingZeros().toPlainString();
    }

    private static double[] column(JsonNode points, int index) {
        double[] values = new double[points.size()];
        for (int i = 0; i < values.length; i++) {
            values[i] = points.get(i).get(index).asDouble();
        }
        return values;
    }

    /**
     * Adds a line to the chart. A few very large values, which occur at small distances, do not
     * determine the range of the axis.
     */
    private static void add(XYChart chart, String name, double[] x, double[] y, int axis) {
        double[] sizes = Arrays.stream(y).map(Math::abs).sorted().toArray();
        double usual = sizes[(int) (USUAL * (sizes.length - 1))];
        double limit = RANGE * usual;
        double low = Math.max(Arrays.stream(y).min().orElse(0), -limit);
        double high = Math.min(Arrays.stream(y).max().orElse(0), limit);
        XYSeries series = chart.addSeries(name, x, y);
        series.setMarker(SeriesMarkers.NONE);
        series.setYAxisGroup(axis);
        if (low < high) {
            double margin = 0.05 * (high - low);
            chart.getStyler().setYAxisMin(axis, low - margin);
            chart.getStyler().setYAxisMax(axis, high + margin);
        }
    }
}
