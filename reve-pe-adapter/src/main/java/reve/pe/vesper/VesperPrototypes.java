// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static reve.pe.vesper.VesperLayouts.LAW_INFO;
import static reve.pe.vesper.VesperLayouts.PARAMETER_DESC;
import static reve.pe.vesper.VesperLayouts.PROPERTY_DESCRIPTOR;
import static reve.pe.vesper.VesperLayouts.PROPERTY_USE;
import static reve.pe.vesper.VesperLayouts.PROTOTYPE;
import static reve.pe.vesper.VesperLayouts.UNIT;
import static reve.pe.vesper.VesperLayouts.offset;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_BYTE;
import static java.lang.foreign.ValueLayout.JAVA_DOUBLE;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import org.jspecify.annotations.Nullable;

import reve.pe.Access;
import reve.pe.LawParameter;
import reve.pe.Phase;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyDescriptor;
import reve.pe.PropertyUse;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.SiUnit;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.StructLayout;
import java.util.ArrayList;
import java.util.EnumSet;
import java.util.List;
import java.util.Set;

/** Conversion of prototypes and laws between C structs and records of {@code reve.pe}. */
final class VesperPrototypes {
    private static final int USE_OPTIONAL = 1;

    private VesperPrototypes() {}

    /**
     * Writes the prototype as {@code vesper_prototype}, with all data that it points to, into the
     * arena.
     */
    static MemorySegment write(Arena arena, Prototype prototype) {
        List<PropertyDescriptor> properties = prototype.properties();
        MemorySegment rows = arena.allocate(PROPERTY_DESCRIPTOR, properties.size());
        for (int i = 0; i < properties.size(); i++) {
            writeDescriptor(arena, element(rows, PROPERTY_DESCRIPTOR, i), properties.get(i));
        }
        MemorySegment struct = arena.allocate(PROTOTYPE);
        struct.set(JAVA_INT, offset(PROTOTYPE, "struct_size"), (int) PROTOTYPE.byteSize());
        struct.set(JAVA_INT, offset(PROTOTYPE, "real_type"), number(prototype.realType()));
        struct.set(
                ADDRESS, offset(PROTOTYPE, "name"), VesperStrings.write(arena, prototype.name()));
        writeUnit(struct.asSlice(offset(PROTOTYPE, "time_unit"), UNIT), prototype.timeUnit());
        struct.set(JAVA_INT, offset(PROTOTYPE, "property_count"), properties.size());
        struct.set(ADDRESS, offset(PROTOTYPE, "properties"), rows);
        return struct;
    }

    /** Copies the {@code vesper_prototype} at an address that C returned. */
    static Prototype read(MemorySegment address) {
        MemorySegment struct = struct(address, PROTOTYPE);
        MemorySegment first = struct.get(ADDRESS, offset(PROTOTYPE, "properties"));
        int count = struct.get(JAVA_INT, offset(PROTOTYPE, "property_count"));
        List<PropertyDescriptor> properties = new ArrayList<>(count);
        for (MemorySegment row : array(first, PROPERTY_DESCRIPTOR, count)) {
            properties.add(readDescriptor(row));
        }
        return new Prototype(
                VesperStrings.readAt(struct, offset(PROTOTYPE, "name")),
                scalarType(struct.get(JAVA_INT, offset(PROTOTYPE, "real_type"))),
                readUnit(struct.asSlice(offset(PROTOTYPE, "time_unit"), UNIT)),
                properties);
    }

    /** Copies a filled {@code vesper_law_info}. */
    static PhysicsLaw readLaw(MemorySegment info) {
        MemorySegment first = info.get(ADDRESS, offset(LAW_INFO, "uses"));
        List<PropertyUse> uses = new ArrayList<>();
        int count = info.get(JAVA_INT, offset(LAW_INFO, "use_count"));
        for (MemorySegment use : array(first, PROPERTY_USE, count)) {
            uses.add(readUse(use));
        }
        List<LawParameter> parameters = new ArrayList<>();
        for (MemorySegment parameter :
                array(
                        info.get(ADDRESS, offset(LAW_INFO, "parameters")),
                        PARAMETER_DESC,
                        info.get(JAVA_INT, offset(LAW_INFO, "parameter_count")))) {
            parameters.add(
                    new LawParameter(
                            VesperStrings.readAt(parameter, offset(PARAMETER_DESC, "name")),
                            VesperStrings.readAt(parameter, offset(PARAMETER_DESC, "doc")),
                            readUnit(parameter.asSlice(offset(PARAMETER_DESC, "unit"), UNIT)),
                            parameter.get(JAVA_DOUBLE, offset(PARAMETER_DESC, "default_value")),
                            parameter.get(JAVA_DOUBLE, offset(PARAMETER_DESC, "minimum")),
                            parameter.get(JAVA_DOUBLE, offset(PARAMETER_DESC, "maximum"))));
        }
        return new PhysicsLaw(
                info.get(JAVA_INT, offset(LAW_INFO, "library_id")),
                VesperStrings.readAt(info, offset(LAW_INFO, "library")),
                VesperStrings.readAt(info, offset(LAW_INFO, "name")),
                VesperStrings.readAt(info, offset(LAW_INFO, "version")),
                VesperStrings.readAt(info, offset(LAW_INFO, "doc")),
                Phase.values()[info.get(JAVA_INT, offset(LAW_INFO, "phase")) - 1],
                info.get(JAVA_INT, offset(LAW_INFO, "stages")),
                PhysicsLaw.claims(info.get(JAVA_INT, offset(LAW_INFO, "claims"))),
                uses,
                parameters,
                info.get(JAVA_LONG, offset(LAW_INFO, "calls")),
                info.get(JAVA_LONG, offset(LAW_INFO, "nanoseconds")),
                info.get(JAVA_INT, offset(LAW_INFO, "resting")) != 0);
    }

    static ScalarType scalarType(int number) {
        return ScalarType.values()[number - 1];
    }

    static Set<Access> access(int bits) {
        Set<Access> set = EnumSet.noneOf(Access.class);
        for (Access access : Access.values()) {
            if ((bits & bit(access)) != 0) {
                set.add(access);
            }
        }
        return set;
    }

    /**
     * Returns C's bit for an access: VESPER_READ = 1, VESPER_WRITE = 2, VESPER_ACCUMULATE = 4,
     * VESPER_SCRATCH = 8.
     */
    private static int bit(Access access) {
        return 1 << access.ordinal();
    }

    private static int number(ScalarType type) {
        return type.ordinal() + 1;
    }

    private static void writeDescriptor(
            Arena arena, MemorySegment row, PropertyDescriptor property) {
        row.set(
                JAVA_INT,
                offset(PROPERTY_DESCRIPTOR, "struct_size"),
                (int) PROPERTY_DESCRIPTOR.byteSize());
        row.set(JAVA_INT, offset(PROPERTY_DESCRIPTOR, "scalar_type"), number(property.type()));
        row.set(JAVA_INT, offset(PROPERTY_DESCRIPTOR, "components"), property.components());
        row.set(
                JAVA_INT,
                offset(PROPERTY_DESCRIPTOR, "law_access"),
                property.lawAccess().stream().mapToInt(VesperPrototypes::bit).sum());
        writeUnit(row.asSlice(offset(PROPERTY_DESCRIPTOR, "unit"), UNIT), property.unit());
        writeString(arena, row, "name", property.name());
        writeString(arena, row, "kind", property.kind());
        writeString(arena, row, "refers_to", property.refersTo());
        writeString(arena, row, "initial_from", property.initialFrom());
        writeString(arena, row, "doc", property.doc());
        if (property.minimum() != Double.NEGATIVE_INFINITY) {
            row.set(JAVA_INT, offset(PROPERTY_DESCRIPTOR, "has_minimum"), 1);
            row.set(JAVA_DOUBLE, offset(PROPERTY_DESCRIPTOR, "minimum"), property.minimum());
        }
    }

    private static void writeString(
            Arena arena, MemorySegment row, String field, @Nullable String text) {
        row.set(ADDRESS, offset(PROPERTY_DESCRIPTOR, field), VesperStrings.write(arena, text));
    }

    private static PropertyDescriptor readDescriptor(MemorySegment row) {
        String refersTo = VesperStrings.readAt(row, offset(PROPERTY_DESCRIPTOR, "refers_to"));
        String initialFrom = VesperStrings.readAt(row, offset(PROPERTY_DESCRIPTOR, "initial_from"));
        return new PropertyDescriptor(
                VesperStrings.readAt(row, offset(PROPERTY_DESCRIPTOR, "name")),
                VesperStrings.readAt(row, offset(PROPERTY_DESCRIPTOR, "kind")),
                scalarType(row.get(JAVA_INT, offset(PROPERTY_DESCRIPTOR, "scalar_type"))),
                row.get(JAVA_INT, offset(PROPERTY_DESCRIPTOR, "components")),
                access(row.get(JAVA_INT, offset(PROPERTY_DESCRIPTOR, "law_access"))),
                readUnit(row.asSlice(offset(PROPERTY_DESCRIPTOR, "unit"), UNIT)),
                refersTo.isEmpty() ? null : refersTo,
                initialFrom.isEmpty() ? null : initialFrom,
                row.get(JAVA_INT, offset(PROPERTY_DESCRIPTOR, "has_minimum")) == 0
                        ? Double.NEGATIVE_INFINITY
                        : row.get(JAVA_DOUBLE, offset(PROPERTY_DESCRIPTOR, "minimum")),
                VesperStrings.readAt(row, offset(PROPERTY_DESCRIPTOR, "doc")));
    }

    private static PropertyUse readUse(MemorySegment use) {
        return new PropertyUse(
                VesperStrings.readAt(use, offset(PROPERTY_USE, "name")),
                VesperStrings.readAt(use, offset(PROPERTY_USE, "kind")),
                scalarType(use.get(JAVA_INT, offset(PROPERTY_USE, "scalar_type"))),
                use.get(JAVA_INT, offset(PROPERTY_USE, "components")),
                access(use.get(JAVA_INT, offset(PROPERTY_USE, "access"))),
                readUnit(use.asSlice(offset(PROPERTY_USE, "unit"), UNIT)),
                (use.get(JAVA_INT, offset(PROPERTY_USE, "flags")) & USE_OPTIONAL) != 0);
    }

    private static void writeUnit(MemorySegment struct, SiUnit unit) {
        byte[] exponents = unit.exponents();
        MemorySegment.copy(
                exponents, 0, struct, JAVA_BYTE, offset(UNIT, "exponent"), exponents.length);
        struct.set(JAVA_DOUBLE, offset(UNIT, "scale"), unit.scale());
        VesperStrings.writeInline(
                struct,
                offset(UNIT, "symbol"),
                UNIT.byteSize() - offset(UNIT, "symbol"),
                unit.symbol());
    }

    private static SiUnit readUnit(MemorySegment struct) {
        byte[] exponents = new byte[7];
        MemorySegment.copy(
                struct, JAVA_BYTE, offset(UNIT, "exponent"), exponents, 0, exponents.length);
        return SiUnit.of(
                exponents,
                struct.get(JAVA_DOUBLE, offset(UNIT, "scale")),
                VesperStrings.readInline(
                        struct, offset(UNIT, "symbol"), UNIT.byteSize() - offset(UNIT, "symbol")));
    }

    /**
     * Returns the elements of a C array of structs. The distance between two elements is the
     * struct_size of the first element.
     */
    private static List<MemorySegment> array(MemorySegment first, StructLayout layout, int count) {
        List<MemorySegment> elements = new ArrayList<>(count);
        if (count > 0) {
            long stride = struct(first, layout).get(JAVA_INT, offset(layout, "struct_size"));
            for (int i = 0; i < count; i++) {
                elements.add(struct(MemorySegment.ofAddress(first.address() + i * stride), layout));
            }
        }
        return elements;
    }

    private static MemorySegment element(MemorySegment array, StructLayout layout, int index) {
        return array.asSlice(index * layout.byteSize(), layout);
    }

    @SuppressWarnings("restricted") // safe: C guarantees a struct of this layout at this address
    private static MemorySegment struct(MemorySegment address, StructLayout layout) {
        return address.reinterpret(layout.byteSize());
    }
}
