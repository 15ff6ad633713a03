// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.pe.LedgerLine;

import java.io.PrintWriter;
import java.math.BigDecimal;
import java.math.MathContext;
import java.math.RoundingMode;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.function.Function;
import java.util.function.ToDoubleFunction;

/**
 * The ledger of energy and momentum of a run. It is printed as JSON or as a table in the form of
 * {@code vesper run --ledger}.
 */
final class LedgerReport {
    /**
     * Fraction of the largest number of a column. A smaller number counts as a rounding error of
     * the sums.
     */
    private static final double ROUNDING = 1e-12;

    private static final MathContext DIGITS = new MathContext(4, RoundingMode.HALF_EVEN);

    private final List<LedgerLine> lines;
    private final double mostEnergy;

    /**
     * Creates the report of a ledger. Omits lines that belong to no law and contain only zeros,
     * except the last line, which is the total.
     */
    LedgerReport(List<LedgerLine> ledger) {
        lines =
                ledger.stream()
                        .filter(line -> line.law() || line == ledger.getLast() || !isEmpty(line))
                        .toList();
        mostEnergy =
                largest(
                        lines,
                        line ->
                                Math.max(
                                        Math.abs(line.energy()), Math.abs(line.potentialChange())));
    }

    /**
     * Prints the table. A star marks the law with the largest momentum, angular momentum and energy
     * balance.
     */
    void print(PrintWriter out) {
        List<List<String>> columns =
                List.of(
                        column("ledger", LedgerLine::name),
                        vectors("momentum [kg*m/s]", LedgerLine::momentum),
                        vectors("angular momentum [kg*m^2/s]", LedgerLine::angularMomentum),
                        column("work [J]", line -> number(line.energy(), mostEnergy)),
                        column(
                                "potential [J]",
                                line ->
                                        line.hasPotentialEnergy()
                                                ? number(line.potentialChange(), mostEnergy)
                                                : "-"),
                        marked(
                                "work + potential [J]",
                                this::balance,
                                line -> number(line.energyBalance(), mostEnergy)));
        List<Integer> widths =
                columns.stream()
                        .map(cells -> cells.stream().mapToInt(String::length).max().orElse(0))
                        .toList();
        for (int row = 0; row <= lines.size(); row++) {
            StringBuilder text = new StringBuilder();
            for (int i = 0; i < columns.size(); i++) {
                String cell = columns.get(i).get(row);
                text.append("  ").append(cell).repeat(' ', widths.get(i) - cell.length());
            }
            out.println(text.toString().stripTrailing());
        }
    }

    /** Returns the lines for JSON, with all digits. */
    List<Map<String, Object>> fields() {
        return lines.stream().map(LedgerReport::lineFields).toList();
    }

    private static Map<String, Object> lineFields(LedgerLine line) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put(line.law() ? "law" : "line", line.name());
        fields.put("momentum", line.momentum());
        fields.put("angularMomentum", line.angularMomentum());
        fields.put("energy", line.energy());
        if (line.hasPotentialEnergy()) {
            fields.put(
                    "potentialEnergy",
                    Map.of(
                            "initial",
                            line.initialPotentialEnergy(),
                            "present",
                            line.potentialEnergy()));
        }
        return fields;
    }

    private List<String> vectors(String head, Function<LedgerLine, List<Double>> vector) {
        double largest = largest(lines, line -> length(vector.apply(line)));
        return marked(
                head,
                line -> length(vector.apply(line)),
                line -> {
                    List<String> numbers =
                            vector.apply(line).stream()
                                    .map(value -> number(value, largest))
                                    .toList();
                    return "(" + String.join(" ", numbers) + ")";
                });
    }

    /**
     * Returns the cells of one line. A star marks a value that is the largest among all laws and
     * exceeds rounding errors.
     */
    private List<String> marked(
            String head, ToDoubleFunction<LedgerLine> size, Function<LedgerLine, String> cell) {
        double largest = largest(lines, size);
        double largestOfLaws = largest(lines.stream().filter(LedgerLine::law).toList(), size);
        return column(
                head,
                line -> {
                    double own = size.applyAsDouble(line);
                    boolean star = line.law() && own == largestOfLaws && own > ROUNDING * largest;
                    return cell.apply(line) + (star ? " *" : "");
                });
    }

    private List<String> column(String head, Function<LedgerLine, String> cell) {
        List<String> cells = new ArrayList<>(List.of(head));
        lines.forEach(line -> cells.add(cell.apply(line)));
        return cells;
    }

    private double balance(LedgerLine line) {
        double size = Math.abs(line.energyBalance());
        return size <= ROUNDING * mostEnergy ? 0 : size;
    }

    private static double largest(List<LedgerLine> lines, ToDoubleFunction<LedgerLine> size) {
        return lines.stream().mapToDouble(size).max().orElse(0);
    }

    private static boolean isEmpty(LedgerLine line) {
        return length(line.momentum()) == 0
                && length(line.angularMomentum()) == 0
                && line.energy() == 0;
    }

    private static double length(List<Double> v) {
        return Math.hypot(Math.hypot(v.get(0), v.get(1)), v.get(2));
    }

    /** Formats a number with four digits and without trailing zeros, as C's {@code %.4g}. */
    static String number(double value, double largest) {
        if (Math.abs(value) <= ROUNDING * largest) {
            return "0";
        }
        if (!Double.isFinite(value)) {
            return Double.toString(value);
        }
        BigDecimal digits = new BigDecimal(value).round(DIGITS).stripTrailingZeros();
        int exponent = digits.precision() - digits.scale() - 1;
        if (exponent >= -4 && exponent < DIGITS.getPrecision()) {
            return digits.toPlainString();
        }
        return String.format(
                Locale.ROOT, "%se%+03d", digits.movePointLeft(exponent).toPlainString(), exponent);
    }
}
