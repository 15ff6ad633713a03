// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.Experiment;
import reve.core.file.RunPoint;

import java.util.ArrayList;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.function.DoubleFunction;
import java.util.stream.Collectors;

/**
 * The results of an experiment as CSV with all digits. There is one table of runs, and one table of
 * all measurements. Numbers are in SI units.
 */
final class ResultTable {
    /** Name of the column that contains the hash of a run's final state. */
    static final String HASH = "stateHash";

    /** Name of the column with the number of the run. */
    static final String RUN = "run";

    /** Name of the column with the number of the frame. */
    static final String FRAME = "frame";

    /**
     * Name of the column with the reason why a run failed. The reason may differ between equal
     * runs.
     */
    static final String MESSAGE = "message";

    private static final double LARGEST_WHOLE = 1e15;

    private final Experiment experiment;
    private final List<RunResult> results;

    ResultTable(Experiment experiment, List<RunResult> results) {
        this.experiment = experiment;
        this.results = List.copyOf(results);
    }

    /** Returns the names of the columns that distinguish runs. */
    private List<String> pointColumns() {
        List<String> columns = new ArrayList<>(List.of(RUN));
        if (experiment.hasCases()) {
            columns.add("case");
        }
        columns.addAll(experiment.variables());
        columns.add("seed");
        return columns;
    }

    /** Returns the table of runs. It contains a header, and one row for each run. */
    List<List<String>> runs() {
        List<String> header = pointColumns();
        header.add("frames");
        List<String> expected = experiment.expected();
        for (String measure : experiment.measures()) {
            header.add(measure);
            if (expected.contains(measure)) {
                header.add(measure + ".expected");
                header.add(measure + ".error");
            }
        }
        header.addAll(List.of(HASH, "state", MESSAGE));
        List<List<String>> rows = new ArrayList<>(List.of(header));
        for (RunResult result : results) {
            List<String> row = new ArrayList<>();
            row.add(Integer.toString(result.point().number()));
            result.point().itsCase().ifPresent(row::add);
            result.point().values().values().forEach(value -> row.add(text(value)));
            row.add(Long.toString(result.point().seed()));
            row.add(Long.toString(result.frames()));
            for (int i = 0; i < experiment.measures().size(); i++) {
                row.add(result.values().get(i).map(ResultTable::text).orElse(""));
                if (expected.contains(experiment.measures().get(i))) {
                    row.add(result.expected().get(i).map(ResultTable::text).orElse(""));
                    row.add(result.error(i).map(ResultTable::text).orElse(""));
                }
            }
            row.add(result.stateHash());
            row.add(result.state().name().toLowerCase(Locale.ROOT));
            row.add(result.message());
            rows.add(row);
        }
        return rows;
    }

    /**
     * Returns the table of all measurements. It contains a header, and one row for each
     * measurement.
     */
    List<List<String>> series() {
        List<String> header = new ArrayList<>(List.of(RUN, FRAME, "time"));
        header.addAll(experiment.measures());
        List<List<String>> rows = new ArrayList<>(List.of(header));
        for (RunResult result : results) {
            for (Sample sample : result.samples()) {
                List<String> row = new ArrayList<>();
                row.add(Integer.toString(result.point().number()));
                row.add(Long.toString(sample.frame()));
                row.add(text(sample.timeSeconds()));
                sample.values().forEach(value -> row.add(value.map(ResultTable::text).orElse("")));
                rows.add(row);
            }
        }
        return rows;
    }

    /** Returns a description of a run: {@code run 3 (length = 0.5, seed = 1)}. */
    String describe(RunPoint point) {
        return describe(point, ResultTable::number);
    }

    /** Returns a description like {@link #describe(RunPoint)}, with numbers in another form. */
    static String describe(RunPoint point, DoubleFunction<String> form) {
        List<String> parts = new ArrayList<>();
        point.itsCase().ifPresent(parts::add);
        for (Map.Entry<String, Double> value : point.values().entrySet()) {
            parts.add(value.getKey() + " = " + form.apply(value.getValue()));
        }
        if (point.seed() != 0) {
            parts.add("seed = " + point.seed());
        }
        return "run "
                + point.number()
                + (parts.isEmpty() ? "" : " (" + String.join(", ", parts) + ")");
    }

    /** Returns a value with all digits. The components of a list are separated by spaces. */
    static String text(Object value) {
        return switch (value) {
            case Double number -> number(number);
            case List<?> list ->
                    list.stream().map(ResultTable::text).collect(Collectors.joining(" "));
            default -> String.valueOf(value);
        };
    }

    private static String number(double number) {
        boolean whole =
                number == Math.rint(number)
                        && Math.abs(number) < LARGEST_WHOLE
                        && !(number == 0 && 1 / number < 0);
        return whole ? Long.toString((long) number) : Double.toString(number);
    }

    /** Returns a row as a line of CSV (RFC 4180), without a line end. */
    static String line(List<String> row) {
        return row.stream().map(ResultTable::cell).collect(Collectors.joining(","));
    }

    private static String cell(String text) {
        boolean quoted = text.chars().anyMatch(c -> c == ',' || c == '"' || c == '\n' || c == '\r');
        return quoted ? '"' + text.replace("\"", "\"\"") + '"' : text;
    }

    /** Returns the rows of a CSV text that {@link #line} wrote; empty if the text is no CSV. */
    static Optional<List<List<String>>> parse(String text) {
        List<List<String>> rows = new ArrayList<>();
        List<String> row = new ArrayList<>();
        StringBuilder cell = new StringBuilder();
        boolean quoted = false;
        for (int i = 0; i < text.length(); i++) {
            char c = text.charAt(i);
            if (quoted) {
                if (c != '"') {
                    cell.append(c);
                } else if (i + 1 < text.length() && text.charAt(i + 1) == '"') {
                    cell.append(c);
                    i++;
                } else {
                    quoted = false;
                }
            } else if (c == '"' && cell.isEmpty()) {
                quoted = true;
            } else if (c == ',' || c == '\n') {
                row.add(cell.toString());
                cell.setLength(0);
                if (c == '\n') {
                    rows.add(row);
                    row = new ArrayList<>();
                }
            } else {
                cell.append(c);
            }
        }
        return quoted || !row.isEmpty() || !cell.isEmpty() ? Optional.empty() : Optional.of(rows);
    }
}
