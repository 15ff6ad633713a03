// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static reve.pe.vesper.VesperLayouts.LEDGER_ENTRY;
import static reve.pe.vesper.VesperLayouts.offset;

import static java.lang.foreign.ValueLayout.JAVA_DOUBLE;
import static java.lang.foreign.ValueLayout.JAVA_INT;

import reve.pe.LedgerLine;
import reve.pe.PhysicsLaw;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.List;

/** Reader of an engine's ledger. */
final class VesperLedger {
    /**
     * Names of the lines that belong to no library (VESPER_NO_LIBRARY), in the order of their
     * numbers.
     */
    private static final List<String> OTHERS = List.of("client", "ground", "unloaded", "total");

    private static final int NO_LIBRARY = 0;

    private VesperLedger() {}

    /** Returns the lines of the laws in the order of `laws`, then the lines of other sources. */
    static List<LedgerLine> read(MemorySegment engine, List<PhysicsLaw> laws, VesperErrors errors) {
        List<LedgerLine> lines = new ArrayList<>();
        try (Arena call = Arena.ofConfined()) {
            MemorySegment entry = call.allocate(LEDGER_ENTRY);
            entry.set(JAVA_INT, offset(LEDGER_ENTRY, "struct_size"), (int) LEDGER_ENTRY.byteSize());
            int library = NO_LIBRARY;
            int index = 0;
            for (PhysicsLaw law : laws) {
                index = law.libraryId() == library ? index + 1 : 0;
                library = law.libraryId();
                errors.check(
                        EngineFunctions.engineLedger(
                                engine, library, index, entry, errors.segment()));
                lines.add(line(law.name(), true, entry));
            }
            for (int line = 0; line < OTHERS.size(); line++) {
                errors.check(
                        EngineFunctions.engineLedger(
                                engine, NO_LIBRARY, line, entry, errors.segment()));
                lines.add(line(OTHERS.get(line), false, entry));
            }
        }
        return lines;
    }

    private static LedgerLine line(String name, boolean law, MemorySegment entry) {
        return new LedgerLine(
                name,
                law,
                vector(entry, "momentum"),
                vector(entry, "angular_momentum"),
                number(entry, "energy"),
                entry.get(JAVA_INT, offset(LEDGER_ENTRY, "has_potential_energy")) != 0,
                number(entry, "initial_potential_energy"),
                number(entry, "potential_energy"),
                number(entry, "impulse_size"),
                number(entry, "angular_impulse_size"));
    }

    private static double number(MemorySegment entry, String field) {
        return entry.get(JAVA_DOUBLE, offset(LEDGER_ENTRY, field));
    }

    private static List<Double> vector(MemorySegment entry, String field) {
        long at = offset(LEDGER_ENTRY, field);
        return List.of(
                entry.get(JAVA_DOUBLE, at),
                entry.get(JAVA_DOUBLE, at + Double.BYTES),
                entry.get(JAVA_DOUBLE, at + 2 * Double.BYTES));
    }
}
