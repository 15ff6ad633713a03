// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * The runs of an experiment: all combinations of cases, swept values and seeds. The order of the
 * runs is that of nested loops. The innermost loop changes the seed, the next one the last
 * variable, and the outermost loop the case.
 */
final class SweepSpace {
    /** Maximum number of runs of an experiment. */
    static final int MAX_RUNS = 100_000;

    /** Names that variables of the sweep must not have, because they are names of other values. */
    static final Set<String> RESERVED = Set.of("seed", "run", "port");

    private final Problems problems;
    private final List<Node> cases;
    private final Map<String, double[]> axes = new LinkedHashMap<>();
    private final Map<String, Unit> units = new HashMap<>();
    private final long[] seeds;
    private final int count;

    private SweepSpace(Node root, Problems problems) {
        this.problems = problems;
        cases = root.get("cases").map(node -> List.copyOf(node.children())).orElse(List.of());
        var quantities = new Quantities(problems);
        for (Node axis : root.get("sweep").map(Node::children).orElse(List.of())) {
            if (RESERVED.contains(axis.key()) || Formula.isTaken(axis.key())) {
                problems.addAtKey(
                        axis,
                        "`"
                                + axis.key()
                                + "` means something else in formulas; choose another name");
            }
            axes.put(axis.key(), values(axis, quantities));
        }
        seeds = seeds(root.get("seeds"));
        double runs = (double) Math.max(1, cases.size()) * seeds.length;
        for (double[] axis : axes.values()) {
            runs *= axis.length;
        }
        if (runs > MAX_RUNS) {
            problems.add(
                    root.get("sweep").or(() -> root.get("seeds")).orElse(root),
                    "found "
                            + (long) runs
                            + " combinations of cases, values and seeds, expected at most "
                            + MAX_RUNS);
        }
        count = (int) Math.min(runs, MAX_RUNS);
    }

    /**
     * Reads the keys {@code cases}, {@code sweep} and {@code seeds}, and records their problems.
     */
    static SweepSpace read(Node root, Problems problems) {
        return new SweepSpace(root, problems);
    }

    private static long[] seeds(Optional<Node> node) {
        if (node.isEmpty()) {
            return new long[] {0};
        }
        if (node.get().number().isPresent()) {
            long[] seeds = new long[node.get().number().get().intValue()];
            for (int i = 0; i < seeds.length; i++) {
                seeds[i] = i;
            }
            return seeds;
        }
        return node.get().children().stream()
                .mapToLong(each -> each.number().orElse(0.0).longValue())
                .toArray();
    }

    private double[] values(Node axis, Quantities quantities) {
        List<Node> nodes =
                axis.isList()
                        ? List.copyOf(axis.children())
                        : List.of(axis.get("from").orElseThrow(), axis.get("to").orElseThrow());
        List<Double> values = new ArrayList<>();
        Optional<Unit> first = Optional.empty();
        for (Node node : nodes) {
            Optional<Quantities.Quantity> read = quantities.quantity(node);
            if (read.isEmpty()) {
                continue;
            }
            Unit unit = read.get().unit().orElse(Unit.ONE);
            if (first.isPresent() && !first.get().sameDimension(unit)) {
                problems.add(
                        node, node.label() + ": unit " + unit + " does not fit " + first.get());
            }
            first = Optional.of(first.orElse(unit));
            read.get().unit().ifPresent(own -> units.putIfAbsent(axis.key(), own.si()));
            values.add(read.get().value());
        }
        if (axis.isList() || values.size() < nodes.size()) {
            return values.stream().mapToDouble(Double::doubleValue).toArray();
        }
        return spaced(axis, values.getFirst(), values.getLast(), problems);
    }

    private static double[] spaced(Node axis, double from, double to, Problems problems) {
        boolean log = axis.get("scale").flatMap(Node::text).orElse("linear").equals("log");
        if (log && !(from > 0 && to > 0)) {
            problems.add(
                    axis,
                    axis.label()
                            + ": found "
                            + from
                            + " and "
                            + to
                            + " on a logarithmic scale, expected values above 0");
        }
        double[] values =
                new double[axis.get("count").flatMap(Node::number).orElse(2.0).intValue()];
        for (int i = 0; i < values.length; i++) {
            double part = (double) i / (values.length - 1);
            values[i] = log ? from * StrictMath.pow(to / from, part) : from + (to - from) * part;
        }
        values[values.length - 1] = to;
        return values;
    }

    /** Returns the number of runs. */
    int count() {
        return count;
    }

    /** Returns the names of the swept variables. */
    List<String> variables() {
        return List.copyOf(axes.keySet());
    }

    /** Returns the SI unit of a variable; empty if its values have no unit in the file. */
    Optional<Unit> unit(String variable) {
        return Optional.ofNullable(units.get(variable));
    }

    /** Returns whether the experiment has cases. */
    boolean hasCases() {
        return !cases.isEmpty();
    }

    /**
     * Returns the case of a run.
     *
     * @param run number of the run, from 0
     */
    Optional<Node> caseOf(int run) {
        return cases.isEmpty()
                ? Optional.empty()
                : Optional.of(cases.get(run / (count / cases.size())));
    }

    /**
     * Returns the values of a run.
     *
     * @param run number of the run, from 0
     */
    RunPoint point(int run) {
        int rest = run;
        long seed = seeds[rest % seeds.length];
        rest /= seeds.length;
        double[] values = new double[axes.size()];
        List<double[]> all = List.copyOf(axes.values());
        for (int i = values.length - 1; i >= 0; i--) {
            values[i] = all.get(i)[rest % all.get(i).length];
            rest /= all.get(i).length;
        }
        Map<String, Double> named = new LinkedHashMap<>();
        int next = 0;
        for (String name : axes.keySet()) {
            named.put(name, values[next++]);
        }
        return new RunPoint(run + 1, caseOf(run).map(Node::key), named, seed);
    }
}
