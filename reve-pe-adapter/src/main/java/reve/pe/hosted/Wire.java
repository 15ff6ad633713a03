// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;

import reve.pe.Access;
import reve.pe.LawParameter;
import reve.pe.LedgerLine;
import reve.pe.OwnColumn;
import reve.pe.Phase;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyDescriptor;
import reve.pe.PropertyUse;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.Status;

import java.util.ArrayList;
import java.util.EnumSet;
import java.util.List;
import java.util.Set;

/** Encoding of prototypes, laws, failures and ledger lines in messages to and from a host. */
final class Wire {
    private static final List<String> OTHER_LINES =
            List.of("client", "ground", "unloaded", "total");
    private static final int USE_OPTIONAL = 1;
    private static final int PROPERTY_BYTES = 48;
    private static final int MESSAGE_BYTES = 184;

    private Wire() {}

    static void put(Mailbox to, Prototype prototype) {
        to.putText(prototype.name())
                .putInt(number(prototype.realType()))
                .putUnit(prototype.timeUnit())
                .putInt(prototype.properties().size());
        prototype.properties().forEach(property -> put(to, property));
    }

    private static void put(Mailbox to, PropertyDescriptor property) {
        boolean hasMinimum = property.minimum() != Double.NEGATIVE_INFINITY;
        to.putText(property.name())
                .putText(property.kind())
                .putInt(number(property.type()))
                .putInt(property.components())
                .putInt(bits(property.lawAccess()))
                .putUnit(property.unit())
                .putText(orEmpty(property.refersTo()))
                .putText(orEmpty(property.initialFrom()))
                .putInt(hasMinimum ? 1 : 0)
                .putDouble(hasMinimum ? property.minimum() : 0)
                .putText(property.doc());
    }

    private static String orEmpty(@Nullable String text) {
        return text == null ? "" : text;
    }

    /** Reads the laws of a library. */
    static List<PhysicsLaw> laws(Mailbox from, int libraryId) {
        List<PhysicsLaw> laws = new ArrayList<>();
        while (from.getInt() != 0) {
            laws.add(
                    new PhysicsLaw(
                            libraryId,
                            from.getText(),
                            from.getText(),
                            from.getText(),
                            from.getText(),
                            Phase.values()[from.getInt() - 1],
                            from.getInt(),
                            PhysicsLaw.claims(from.getInt()),
                            uses(from),
                            parameters(from),
                            from.getLong(),
                            from.getLong(),
                            from.getInt() != 0));
        }
        return laws;
    }

    private static List<PropertyUse> uses(Mailbox from) {
        List<PropertyUse> uses = new ArrayList<>();
        for (int left = from.getInt(); left > 0; left--) {
            uses.add(
                    new PropertyUse(
                            from.getText(),
                            from.getText(),
                            ScalarType.values()[from.getInt() - 1],
                            from.getInt(),
                            access(from.getInt()),
                            from.getUnit(),
                            (from.getInt() & USE_OPTIONAL) != 0));
        }
        return uses;
    }

    private static List<LawParameter> parameters(Mailbox from) {
        List<LawParameter> parameters = new ArrayList<>();
        for (int left = from.getInt(); left > 0; left--) {
            parameters.add(
                    new LawParameter(
                            from.getText(),
                            from.getText(),
                            from.getUnit(),
                            from.getDouble(),
                            from.getDouble(),
                            from.getDouble()));
        }
        return parameters;
    }

    /** A failure that a host reports (a {@code vesper_error}). Its ids are those of the host. */
    record Failure(int status, int library, int law, long row, String property, String message) {
        static Failure read(Mailbox from) {
            int status = from.getInt();
            int library = from.getInt();
            int law = from.getInt();
            from.getInt(); // skips the stage
            return new Failure(
                    status,
                    library,
                    law,
                    from.getLong(),
                    from.getField(PROPERTY_BYTES),
                    from.getField(MESSAGE_BYTES));
        }

        PhysicsException exception(int libraryId, String library, String law) {
            return new PhysicsException(
                    status >= 1 && status <= Status.LAW_TIMED_OUT.ordinal() + 1
                            ? Status.values()[status - 1]
                            : Status.UNKNOWN,
                    libraryId,
                    library,
                    law,
                    property,
                    row,
                    message);
        }
    }

    /**
     * Writes a request for the lines of a ledger: those of all laws, then those of other sources.
     */
    static void putLedger(Mailbox to, List<Loaded> libraries) {
        int laws = libraries.stream().mapToInt(library -> library.laws().size()).sum();
        to.putInt(laws + OTHER_LINES.size());
        for (Loaded library : libraries) {
            for (int law = 0; law < library.laws().size(); law++) {
                to.putInt(library.hostId).putInt(law);
            }
        }
        for (int line = 0; line < OTHER_LINES.size(); line++) {
            to.putInt(0).putInt(line);
        }
    }

    /** Reads the lines that {@link #putLedger} requests. */
    static List<LedgerLine> ledger(Mailbox from, List<Loaded> libraries) {
        List<LedgerLine> lines = new ArrayList<>();
        for (Loaded library : libraries) {
            library.laws().forEach(law -> lines.add(line(from, law.name(), true)));
        }
        OTHER_LINES.forEach(name -> lines.add(line(from, name, false)));
        return lines;
    }

    private static LedgerLine line(Mailbox from, String name, boolean law) {
        from.getInt(); // skips the size of the struct
        boolean hasPotential = from.getInt() != 0;
        return new LedgerLine(
                name,
                law,
                List.of(from.getDouble(), from.getDouble(), from.getDouble()),
                List.of(from.getDouble(), from.getDouble(), from.getDouble()),
                from.getDouble(),
                hasPotential,
                from.getDouble(),
                from.getDouble(),
                from.getDouble(),
                from.getDouble());
    }

    /**
     * Writes a request for one row of columns of laws.
     *
     * @param owners the library of each column
     */
    static void putOwn(Mailbox to, List<OwnColumn> columns, List<Loaded> owners, long row) {
        to.putLong(row).putInt(columns.size());
        for (int i = 0; i < columns.size(); i++) {
            OwnColumn column = columns.get(i);
            to.putInt(owners.get(i).hostId)
                    .putInt(column.law())
                    .putInt(column.use())
                    .putInt(column.components());
        }
    }

    /** Reads the values that {@link #putOwn} requests. */
    static List<double[]> ownValues(Mailbox from, List<OwnColumn> columns) {
        List<double[]> values = new ArrayList<>();
        for (OwnColumn column : columns) {
            double[] row = new double[column.components()];
            for (int i = 0; i < row.length; i++) {
                row[i] = from.getDouble();
            }
            values.add(row);
        }
        return values;
    }

    private static int number(ScalarType type) {
        return type.ordinal() + 1;
    }

    private static int bits(Set<Access> access) {
        return access.stream().mapToInt(one -> 1 << one.ordinal()).sum();
    }

    private static Set<Access> access(int bits) {
        Set<Access> access = EnumSet.noneOf(Access.class);
        for (Access one : Access.values()) {
            if ((bits & 1 << one.ordinal()) != 0) {
                access.add(one);
            }
        }
        return access;
    }
}
