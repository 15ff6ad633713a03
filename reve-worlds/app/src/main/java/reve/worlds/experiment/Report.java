// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.Experiment;
import reve.core.text.Rounded;
import reve.core.unit.Unit;
import reve.worlds.Product;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.util.ArrayList;
import java.util.Base64;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/**
 * The results of an experiment as one HTML page. The page contains its plots, style and script, and
 * makes no network requests. Its texts come from the experiment file, whose author may be
 * untrusted.
 */
final class Report {
    /** Maximum number of runs in the table of the page. */
    private static final int MAX_ROWS = 1000;

    /** Maximum number of messages about runs. */
    private static final int MAX_MESSAGES = 100;

    private final Experiment experiment;
    private final List<RunResult> results;
    private final StringBuilder out = new StringBuilder();

    private Report(Experiment experiment, List<RunResult> results) {
        this.experiment = experiment;
        this.results = results;
    }

    /**
     * Returns the page. Equal results of the same files, with the same version and on the same kind
     * of machine, give the same page.
     *
     * @param files SHA-256 of the files that were used, by name
     * @param laws SHA-256 of the laws that were used, by name
     */
    static String of(
            Experiment experiment,
            List<RunResult> results,
            Map<String, String> files,
            Map<String, String> laws)
            throws IOException {
        var report = new Report(experiment, results);
        report.head();
        report.plots();
        report.table();
        report.messages();
        report.origin(files, laws);
        report.out.append("</main>\n<script>").append(resource("report.js")).append("</script>\n");
        report.out.append("</body>\n</html>\n");
        return report.out.toString();
    }

    private static String resource(String name) throws IOException {
        try (InputStream in = Report.class.getResourceAsStream(name)) {
            if (in == null) {
                throw new IOException("the program lacks its file " + name);
            }
            return new String(in.readAllBytes(), StandardCharsets.UTF_8);
        }
    }

    private static String sha256(String text) {
        try {
            byte[] hash =
                    MessageDigest.getInstance("SHA-256")
                            .digest(text.getBytes(StandardCharsets.UTF_8));
            return "'sha256-" + Base64.getEncoder().encodeToString(hash) + "'";
        } catch (NoSuchAlgorithmException e) {
            throw new AssertionError("every Java platform has SHA-256", e);
        }
    }

    private void head() throws IOException {
        String style = resource("report.css");
        String name = Html.text(experiment.name());
        out.append("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n")
                .append(
                        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';")
                .append(" style-src ")
                .append(sha256(style))
                .append("; script-src ")
                .append(sha256(resource("report.js")))
                .append("; base-uri 'none'; form-action 'none'\">\n")
                .append("<meta name=\"viewport\" content=\"width=device-width\">\n<title>")
                .append(name)
                .append(", results of an experiment</title>\n<style>")
                .append(style)
                .append("</style>\n</head>\n<body>\n<header><h1>")
                .append(name)
                .append("</h1>")
                .append("<button id=\"theme\" type=\"button\" hidden>Light or dark</button>")
                .append("</header>\n<main>\n");
        if (!experiment.doc().isEmpty()) {
            out.append("<p class=\"doc\">")
                    .append(Html.text(experiment.doc().strip().replaceAll("\\s+", " ")))
                    .append("</p>\n");
        }
        out.append("<ul class=\"counts\">")
                .append("<li>")
                .append(count(results.size(), "run"))
                .append("</li>");
        for (RunResult.State state : RunResult.State.values()) {
            long count = results.stream().filter(run -> run.state() == state).count();
            if (count > 0 || state == RunResult.State.OK) {
                out.append("<li class=\"")
                        .append(name(state))
                        .append("\">")
                        .append(count)
                        .append(' ')
                        .append(words(state))
                        .append("</li>");
            }
        }
        out.append("</ul>\n");
    }

    private static String count(int number, String noun) {
        return number + " " + noun + (number == 1 ? "" : "s");
    }

    private static String name(RunResult.State state) {
        return state.name().toLowerCase(Locale.ROOT);
    }

    private static String words(RunResult.State state) {
        return switch (state) {
            case OK -> "ok";
            case OUTSIDE -> "outside of a tolerance";
            case FAILED -> "failed";
        };
    }

    private void plots() {
        List<Plot> plots = Plots.of(experiment, results);
        if (plots.isEmpty()) {
            return;
        }
        out.append("<section aria-labelledby=\"plots\"><h2 id=\"plots\">Plots</h2>\n")
                .append("<div class=\"plots\">\n");
        for (int i = 0; i < plots.size(); i++) {
            Plot plot = plots.get(i);
            String title = plot.title().substring(experiment.name().length() + 2);
            String axis = plot.x().replaceFirst(" \\[.*", "");
            out.append("<figure><figcaption>")
                    .append(Html.text(title.replaceFirst("(,|$)", " over " + axis + "$1")))
                    .append("</figcaption>\n");
            SvgPlot.append(plot, "plot" + i, out);
            out.append("<ul class=\"legend\">");
            for (Plot.Line line : plot.lines()) {
                out.append("<li class=\"s")
                        .append(line.colour())
                        .append(
                                switch (line.style()) {
                                    case DASHED -> " dashed";
                                    case POINTS -> " points";
                                    case JOINED, CURVE -> "";
                                })
                        .append("\">")
                        .append(Html.text(line.label()))
                        .append("</li>");
            }
            out.append("</ul></figure>\n");
        }
        out.append("</div>");
        boolean hasDeviations =
                plots.stream()
                        .flatMap(plot -> plot.lines().stream())
                        .anyMatch(line -> !line.deviation().isEmpty());
        if (hasDeviations) {
            out.append(
                    "<p class=\"note\">Each point is the mean over the seeds, with the standard"
                            + " deviation.</p>");
        }
        out.append("</section>\n");
    }

    private void table() {
        List<String> expected = experiment.expected();
        out.append("<section aria-labelledby=\"runs\"><h2 id=\"runs\">Runs</h2>\n")
                .append("<div class=\"scroll\" tabindex=\"0\" role=\"region\"")
                .append(" aria-labelledby=\"runs\"><table id=\"table\">\n")
                .append("<thead><tr>");
        column("run", false);
        if (experiment.hasCases()) {
            column("case", false);
        }
        for (String variable : experiment.variables()) {
            column(variable + unit(experiment.variableUnit(variable)), true);
        }
        column("seed", true);
        for (int i = 0; i < experiment.measures().size(); i++) {
            String measure = experiment.measures().get(i);
            int index = i;
            boolean isNumber =
                    results.stream()
                            .flatMap(run -> run.values().get(index).stream())
                            .allMatch(Double.class::isInstance);
            column(measure + unit(experiment.valueUnit(i).map(Unit::si)), isNumber);
            if (expected.contains(measure)) {
                column("expected", true);
                column("error", true);
            }
        }
        column("state", false);
        column("state hash", false);
        out.append("</tr></thead>\n<tbody>\n");
        for (RunResult run : results.subList(0, Math.min(MAX_ROWS, results.size()))) {
            row(run, expected);
        }
        out.append("</tbody></table></div>\n<p class=\"note\">");
        if (results.size() > MAX_ROWS) {
            out.append("The table shows the first ")
                    .append(MAX_ROWS)
                    .append(" of ")
                    .append(results.size())
                    .append(" runs. ");
        }
        out.append("Numbers are rounded and in SI units. The files ");
        link(ResultFolder.RUNS, " (all digits), ");
        link(ResultFolder.SERIES, " (all measurements) and ");
        link(ResultFolder.RESULT, " are in the same folder.</p></section>\n");
    }

    private void link(String file, String then) {
        out.append("<a href=\"")
                .append(file)
                .append("\">")
                .append(file)
                .append("</a>")
                .append(then);
    }

    private static String unit(Optional<Unit> unit) {
        return Plots.symbol(unit).map(symbol -> " [" + symbol + "]").orElse("");
    }

    private void column(String title, boolean isNumber) {
        out.append(isNumber ? "<th scope=\"col\" class=\"number\">" : "<th scope=\"col\">")
                .append(Html.text(title))
                .append("</th>");
    }

    private void row(RunResult run, List<String> expected) {
        out.append("<tr><th scope=\"row\">").append(run.point().number()).append("</th>");
        run.point().itsCase().ifPresent(this::cell);
        run.point().values().values().forEach(this::cell);
        cell(Double.valueOf(run.point().seed()));
        for (int i = 0; i < experiment.measures().size(); i++) {
            run.values().get(i).ifPresentOrElse(this::cell, this::empty);
            if (expected.contains(experiment.measures().get(i))) {
                run.expected().get(i).ifPresentOrElse(this::cell, this::empty);
                run.error(i).ifPresentOrElse(this::cell, this::empty);
            }
        }
        out.append("<td><span class=\"state ")
                .append(name(run.state()))
                .append("\">")
                .append(name(run.state()))
                .append("</span></td><td><code>")
                .append(Html.text(run.stateHash()))
                .append("</code></td></tr>\n");
    }

    private void empty() {
        out.append("<td class=\"none\">–</td>");
    }

    /** Appends a rounded value. Its HTML attribute {@code title} contains all digits. */
    private void cell(Object value) {
        if (value instanceof Double number) {
            out.append("<td class=\"number\" title=\"")
                    .append(ResultTable.text(number))
                    .append("\">")
                    .append(Rounded.of(number))
                    .append("</td>");
        } else {
            out.append("<td>").append(Html.text(rounded(value))).append("</td>");
        }
    }

    private static String rounded(Object value) {
        return switch (value) {
            case Double number -> Rounded.of(number);
            case List<?> list -> String.join(" ", list.stream().map(Report::rounded).toList());
            default -> String.valueOf(value);
        };
    }

    private void messages() {
        List<String> messages = new ArrayList<>();
        for (RunResult run : results) {
            String begin = "Run " + run.point().number() + ": ";
            if (!run.message().isEmpty()) {
                messages.add(begin + run.message());
            }
            run.notes().forEach(note -> messages.add(begin + note));
        }
        if (messages.isEmpty()) {
            return;
        }
        out.append("<section aria-labelledby=\"notes\"><h2 id=\"notes\">Messages</h2>\n<ul>\n");
        messages.stream()
                .limit(MAX_MESSAGES)
                .forEach(
                        message -> out.append("<li>").append(Html.text(message)).append("</li>\n"));
        if (messages.size() > MAX_MESSAGES) {
            out.append("<li>and ")
                    .append(messages.size() - MAX_MESSAGES)
                    .append(" more, which runs.csv and result.json contain</li>\n");
        }
        out.append("</ul></section>\n");
    }

    /** Appends the data that another person needs to repeat the experiment. */
    private void origin(Map<String, String> files, Map<String, String> laws) {
        out.append("<section aria-labelledby=\"origin\"><h2 id=\"origin\">Origin</h2>\n<p>")
                .append("Made by REVE ")
                .append(Html.text(Product.version()))
                .append(" on ")
                .append(Html.text(ResultFolder.machine()))
                .append(". To compare the results with new ones, to the bit, run <code>./reve")
                .append(" experiment ")
                .append(Html.text(String.valueOf(experiment.file().getFileName())))
                .append(" --out FOLDER</code> with this folder.</p>\n");
        hashes("Files", files);
        hashes("Laws", laws);
        out.append("</section>\n");
    }

    private void hashes(String title, Map<String, String> hashes) {
        if (hashes.isEmpty()) {
            return;
        }
        out.append("<details><summary>")
                .append(title)
                .append(" and their SHA-256</summary><table>\n");
        hashes.forEach(
                (name, hash) ->
                        out.append("<tr><th scope=\"row\">")
                                .append(Html.text(name))
                                .append("</th><td><code>")
                                .append(Html.text(hash))
                                .append("</code></td></tr>\n"));
        out.append("</table></details>\n");
    }
}
