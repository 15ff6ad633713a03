// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.function.Supplier;
import java.util.stream.Collectors;

/**
 * The first difference between the results of an experiment and earlier results.
 *
 * @param run description of the run; empty if the runs or measures themselves differ
 * @param frame number of the frame; empty for a value of the whole run
 * @param measure name of the value
 * @param before the earlier value; empty if there was none
 * @param now the new value; empty if there is none
 */
public record Difference(
        String run, Optional<Long> frame, String measure, String before, String now) {

    /** Returns a sentence with the run, the frame, the measure and both values. */
    public String message() {
        return (run.isEmpty() ? "" : run + ": ")
                + frame.map(number -> "in frame " + number + " ").orElse("")
                + measure
                + " was "
                + shown(before)
                + ", is "
                + shown(now);
    }

    private static String shown(String value) {
        return value.isEmpty() ? "missing" : value;
    }

    /** Returns the fields for JSON. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        if (!run.isEmpty()) {
            fields.put("run", run);
        }
        frame.ifPresent(number -> fields.put("frame", number));
        fields.put("measure", measure);
        fields.put("before", before);
        fields.put("now", now);
        return fields;
    }

    /**
     * Compares two results. Each result consists of a table of runs and a table of measurements,
     * both with headers.
     *
     * @param now the new results, which also describe the runs in the message
     */
    static Optional<Difference> first(
            List<List<String>> runsBefore,
            List<List<String>> seriesBefore,
            ResultTable now,
            List<RunResult> results) {
        List<List<String>> runs = now.runs();
        List<List<String>> series = now.series();
        if (!runsBefore.getFirst().equals(runs.getFirst())) {
            return Optional.of(
                    new Difference(
                            "",
                            Optional.empty(),
                            "the list of columns",
                            ResultTable.line(runsBefore.getFirst()),
                            ResultTable.line(runs.getFirst())));
        }
        if (runsBefore.size() != runs.size()) {
            return Optional.of(
                    new Difference(
                            "",
                            Optional.empty(),
                            "the number of runs",
                            Integer.toString(runsBefore.size() - 1),
                            Integer.toString(runs.size() - 1)));
        }
        Map<String, List<List<String>>> before = byRun(seriesBefore);
        Map<String, List<List<String>>> after = byRun(series);
        for (int i = 1; i < runs.size(); i++) {
            String run = runs.get(i).getFirst();
            String described = now.describe(results.get(i - 1).point());
            Optional<Difference> found =
                    inSeries(
                                    described,
                                    series.getFirst(),
                                    before.getOrDefault(run, List.of()),
                                    after.getOrDefault(run, List.of()))
                            .or(inRow(described, runs.getFirst(), runsBefore.get(i), runs.get(i)));
            if (found.isPresent()) {
                return found;
            }
        }
        return Optional.empty();
    }

    private static Map<String, List<List<String>>> byRun(List<List<String>> series) {
        return series.stream()
                .skip(1)
                .collect(
                        Collectors.groupingBy(
                                List::getFirst, LinkedHashMap::new, Collectors.toList()));
    }

    private static Optional<Difference> inSeries(
            String run, List<String> header, List<List<String>> before, List<List<String>> now) {
        for (int i = 0; i < Math.max(before.size(), now.size()); i++) {
            List<String> old = i < before.size() ? before.get(i) : List.of();
            List<String> mine = i < now.size() ? now.get(i) : List.of();
            for (int column = 1; column < header.size(); column++) {
                String was = column < old.size() ? old.get(column) : "";
                String is = column < mine.size() ? mine.get(column) : "";
                if (!was.equals(is)) {
                    List<String> row = mine.isEmpty() ? old : mine;
                    return Optional.of(
                            new Difference(run, frame(row), header.get(column), was, is));
                }
            }
        }
        return Optional.empty();
    }

    private static Optional<Long> frame(List<String> row) {
        try {
            return Optional.of(Long.valueOf(row.get(1)));
        } catch (NumberFormatException damaged) {
            return Optional.empty();
        }
    }

    private static Supplier<Optional<Difference>> inRow(
            String run, List<String> header, List<String> before, List<String> now) {
        return () -> {
            for (int column = 0; column < header.size(); column++) {
                String was = column < before.size() ? before.get(column) : "";
                String is = now.get(column);
                if (!was.equals(is) && !header.get(column).equals(ResultTable.MESSAGE)) {
                    return Optional.of(
                            new Difference(run, Optional.empty(), header.get(column), was, is));
                }
            }
            return Optional.empty();
        };
    }
}
