// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

import org.jspecify.annotations.Nullable;

import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStream;
import java.io.InputStreamReader;
import java.io.UncheckedIOException;
import java.nio.charset.StandardCharsets;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;

/**
 * The symbols of units and prefixes. They are read from the same tables from which the physics
 * engine is built.
 */
final class UnitTable {

    private static final Map<String, Named> UNITS = new HashMap<>();
    private static final Map<String, Scale> PREFIXES = new LinkedHashMap<>();

    static {
        for (String[] row : rows("units.csv")) {
            int[] exponents = new int[SiBase.values().length];
            for (int i = 0; i < exponents.length; i++) {
                exponents[i] = Integer.parseInt(row[4 + i]);
            }
            UNITS.put(row[0], new Named(exponents, scale(row[2], row[3]), row[1].equals("yes")));
        }
        for (String[] row : rows("prefixes.csv")) {
            PREFIXES.put(row[0], scale(row[1], row[2]));
        }
    }

    /** A scale as a fraction, so that ratios of units stay exact: g/ms is exactly kg/s. */
    record Scale(double numerator, double denominator) {}

    private record Named(int[] exponents, Scale scale, boolean takesPrefix) {}

    /** The meaning of a symbol such as {@code km}. */
    record Symbol(int[] exponents, Scale scale) {}

    private UnitTable() {}

    /** Returns the meaning of a symbol; null if the symbol is not in the tables. */
    static @Nullable Symbol find(String symbol) {
        Named unit = UNITS.get(symbol);
        if (unit != null) {
            return new Symbol(unit.exponents, unit.scale);
        }
        for (Map.Entry<String, Scale> prefix : PREFIXES.entrySet()) {
            Named base =
                    symbol.startsWith(prefix.getKey())
                            ? UNITS.get(symbol.substring(prefix.getKey().length()))
                            : null;
            if (base != null && base.takesPrefix) {
                return new Symbol(
                        base.exponents,
                        new Scale(
                                base.scale.numerator * prefix.getValue().numerator,
                                base.scale.denominator * prefix.getValue().denominator));
            }
        }
        return null;
    }

    private static Scale scale(String numerator, String denominator) {
        return new Scale(Double.parseDouble(numerator), Double.parseDouble(denominator));
    }

    private static List<String[]> rows(String name) {
        try (InputStream in = UnitTable.class.getResourceAsStream(name);
                var reader =
                        new BufferedReader(
                                new InputStreamReader(
                                        Objects.requireNonNull(in, name),
                                        StandardCharsets.UTF_8))) {
            return reader.lines().skip(1).map(line -> line.split(",")).toList();
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
    }
}
