// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import java.util.List;

/**
 * The columns that laws have of their own ({@link reve.pe.Access#SCRATCH}), with the values of one
 * item.
 *
 * @param columns in the order of the laws
 * @param more number of further columns, which are omitted because there are too many values
 */
public record LawColumns(List<Column> columns, int more) {

    /** The columns of an item that has none. */
    public static final LawColumns NONE = new LawColumns(List.of(), 0);

    /**
     * A column of a law, with the values of one item.
     *
     * @param unit the symbol of the unit
     * @param values the first values [the unit], at most 64
     * @param components number of all values
     */
    public record Column(
            String library,
            String law,
            String name,
            String unit,
            List<Double> values,
            int components) {
        /** Copies the list. */
        public Column {
            values = List.copyOf(values);
        }
    }

    /** Copies the list. */
    public LawColumns {
        columns = List.copyOf(columns);
    }
}
