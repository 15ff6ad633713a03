// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.Access;
import reve.pe.OwnColumn;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyUse;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;

/**
 * Reader of the columns that the loaded laws have of their own. The list of columns is read from
 * the engine only after a library was loaded or unloaded. For the world's thread only.
 */
final class OwnColumns {
    /** Maximum number of values of one column in a result. */
    static final int MOST_VALUES = 64;

    /** Maximum number of values of all columns that one call reads. */
    private static final int MOST_READ = 2_000;

    private final PhysicsEngine engine;
    private final Laws laws;
    private List<Known> known = List.of();
    private long knownLaws = -1;

    private record Known(String library, String law, PropertyUse use, OwnColumn place) {}

    OwnColumns(PhysicsEngine engine, Laws laws) {
        this.engine = engine;
        this.laws = laws;
    }

    /**
     * Returns the columns for items of a kind, with the values of one row. The engine must know all
     * moves of rows.
     */
    LawColumns of(String kind, long row) {
        if (knownLaws != laws.version()) {
            known = list();
            knownLaws = laws.version();
        }
        List<Known> read = new ArrayList<>();
        int values = 0;
        int all = 0;
        for (Known column : known) {
            if (column.use.kind().equals(kind)) {
                all++;
                values += column.place.components();
                if (values <= MOST_READ) {
                    read.add(column);
                }
            }
        }
        if (read.isEmpty()) {
            return new LawColumns(List.of(), all);
        }
        List<double[]> rows = engine.ownValues(read.stream().map(Known::place).toList(), row);
        List<LawColumns.Column> columns = new ArrayList<>();
        for (int i = 0; i < read.size(); i++) {
            columns.add(column(read.get(i), rows.get(i)));
        }
        return new LawColumns(columns, all - read.size());
    }

    private static LawColumns.Column column(Known column, double[] row) {
        return new LawColumns.Column(
                column.library,
                column.law,
                column.use.name(),
                column.use.unit().symbol(),
                Arrays.stream(row)
                        .limit(MOST_VALUES)
                        .map(value -> Double.isFinite(value) ? value : 0)
                        .boxed()
                        .toList(),
                row.length);
    }

    private List<Known> list() {
        List<Known> columns = new ArrayList<>();
        int library = 0;
        int index = 0;
        for (PhysicsLaw law : laws.loaded()) {
            index = law.libraryId() == library ? index + 1 : 0;
            library = law.libraryId();
            for (int use = 0; use < law.uses().size(); use++) {
                PropertyUse column = law.uses().get(use);
                if (column.access().contains(Access.SCRATCH)) {
                    OwnColumn place = new OwnColumn(library, index, use, column.components());
                    columns.add(new Known(law.library(), law.name(), column, place));
                }
            }
        }
        return columns;
    }
}
