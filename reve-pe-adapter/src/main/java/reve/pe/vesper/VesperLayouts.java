// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_BYTE;
import static java.lang.foreign.ValueLayout.JAVA_DOUBLE;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import java.lang.foreign.MemoryLayout;
import java.lang.foreign.MemoryLayout.PathElement;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.StructLayout;
import java.util.List;

/** The structs of {@code types.h}, {@code law.h} and {@code engine.h} that Java and C exchange. */
final class VesperLayouts {
    static final StructLayout UNIT =
            MemoryLayout.structLayout(
                            MemoryLayout.sequenceLayout(7, JAVA_BYTE).withName("exponent"),
                            JAVA_BYTE.withName("reserved"),
                            JAVA_DOUBLE.withName("scale"),
                            MemoryLayout.sequenceLayout(16, JAVA_BYTE).withName("symbol"))
                    .withName("vesper_unit");

    static final StructLayout ERROR =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("status"),
                            JAVA_INT.withName("library_id"),
                            JAVA_INT.withName("law_index"),
                            JAVA_INT.withName("stage"),
                            JAVA_LONG.withName("row"),
                            MemoryLayout.sequenceLayout(48, JAVA_BYTE).withName("property"),
                            MemoryLayout.sequenceLayout(184, JAVA_BYTE).withName("message"))
                    .withName("vesper_error");

    static final StructLayout PARAMETER =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("reserved"),
                            ADDRESS.withName("name"),
                            JAVA_DOUBLE.withName("value"))
                    .withName("vesper_parameter");

    static final StructLayout PROPERTY_DESCRIPTOR =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("scalar_type"),
                            ADDRESS.withName("name"),
                            ADDRESS.withName("kind"),
                            JAVA_INT.withName("components"),
                            JAVA_INT.withName("law_access"),
                            UNIT.withName("unit"),
                            ADDRESS.withName("refers_to"),
                            ADDRESS.withName("initial_from"),
                            ADDRESS.withName("doc"),
                            JAVA_INT.withName("has_minimum"),
                            JAVA_INT.withName("reserved"),
                            JAVA_DOUBLE.withName("minimum"))
                    .withName("vesper_property_descriptor");

    static final StructLayout PROTOTYPE =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("real_type"),
                            ADDRESS.withName("name"),
                            UNIT.withName("time_unit"),
                            JAVA_INT.withName("property_count"),
                            JAVA_INT.withName("reserved"),
                            ADDRESS.withName("properties"))
                    .withName("vesper_prototype");

    static final StructLayout PROPERTY =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("scalar_type"),
                            ADDRESS.withName("name"),
                            ADDRESS.withName("kind"),
                            JAVA_INT.withName("components"),
                            JAVA_INT.withName("access"),
                            ADDRESS.withName("data"),
                            JAVA_LONG.withName("row_count"),
                            JAVA_LONG.withName("version"))
                    .withName("vesper_property");

    static final StructLayout PROPERTY_USE =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("scalar_type"),
                            ADDRESS.withName("name"),
                            ADDRESS.withName("kind"),
                            JAVA_INT.withName("components"),
                            JAVA_INT.withName("access"),
                            UNIT.withName("unit"),
                            JAVA_INT.withName("flags"),
                            JAVA_INT.withName("reserved"))
                    .withName("vesper_property_use");

    static final StructLayout PARAMETER_DESC =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("reserved"),
                            ADDRESS.withName("name"),
                            ADDRESS.withName("doc"),
                            UNIT.withName("unit"),
                            JAVA_DOUBLE.withName("default_value"),
                            JAVA_DOUBLE.withName("minimum"),
                            JAVA_DOUBLE.withName("maximum"))
                    .withName("vesper_parameter_desc");

    static final StructLayout ENGINE_CONFIG =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("threads"),
                            JAVA_INT.withName("validate"),
                            JAVA_INT.withName("probe_timeout_ms"),
                            ADDRESS.withName("law_path"),
                            ADDRESS.withName("probe_path"),
                            ADDRESS.withName("log"),
                            ADDRESS.withName("log_user"),
                            JAVA_INT.withName("deferred"),
                            JAVA_INT.withName("touches"),
                            ADDRESS.withName("running"),
                            JAVA_INT.withName("limit_values"),
                            JAVA_INT.withName("rest_without_fields"))
                    .withName("vesper_engine_config");

    static final StructLayout LAW_INFO =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("library_id"),
                            ADDRESS.withName("library"),
                            ADDRESS.withName("name"),
                            ADDRESS.withName("version"),
                            ADDRESS.withName("doc"),
                            JAVA_INT.withName("phase"),
                            JAVA_INT.withName("stages"),
                            JAVA_INT.withName("use_count"),
                            JAVA_INT.withName("parameter_count"),
                            ADDRESS.withName("uses"),
                            ADDRESS.withName("parameters"),
                            JAVA_LONG.withName("calls"),
                            JAVA_LONG.withName("nanoseconds"),
                            JAVA_INT.withName("claims"),
                            JAVA_INT.withName("resting"))
                    .withName("vesper_law_info");

    static final StructLayout LEDGER_ENTRY =
            MemoryLayout.structLayout(
                            JAVA_INT.withName("struct_size"),
                            JAVA_INT.withName("has_potential_energy"),
                            MemoryLayout.sequenceLayout(3, JAVA_DOUBLE).withName("momentum"),
                            MemoryLayout.sequenceLayout(3, JAVA_DOUBLE)
                                    .withName("angular_momentum"),
                            JAVA_DOUBLE.withName("energy"),
                            JAVA_DOUBLE.withName("initial_potential_energy"),
                            JAVA_DOUBLE.withName("potential_energy"),
                            JAVA_DOUBLE.withName("impulse_size"),
                            JAVA_DOUBLE.withName("angular_impulse_size"))
                    .withName("vesper_ledger_entry");

    static final StructLayout LAYOUT_ENTRY =
            MemoryLayout.structLayout(
                            ADDRESS.withName("struct_name"),
                            ADDRESS.withName("field"),
                            JAVA_INT.withName("offset"),
                            JAVA_INT.withName("size"))
                    .withName("vesper_layout_entry");

    private static final List<StructLayout> ALL =
            List.of(
                    UNIT,
                    ERROR,
                    PARAMETER,
                    PROPERTY_DESCRIPTOR,
                    PROTOTYPE,
                    PROPERTY,
                    PROPERTY_USE,
                    PARAMETER_DESC,
                    ENGINE_CONFIG,
                    LAW_INFO,
                    LEDGER_ENTRY,
                    LAYOUT_ENTRY);

    private VesperLayouts() {}

    /** One row of the library's own layout table; the field is empty for a struct's size. */
    record Row(String struct, String field, long offset, long size) {}

    /** Returns the byte offset of a field. */
    static long offset(StructLayout layout, String field) {
        return layout.byteOffset(PathElement.groupElement(field));
    }

    /** Copies the table that {@code vesper_abi_layout} returned. */
    @SuppressWarnings("restricted") // safe: C returns the number of entries
    static List<Row> read(MemorySegment first, int count) {
        return first.reinterpret(count * LAYOUT_ENTRY.byteSize())
                .elements(LAYOUT_ENTRY)
                .map(
                        entry ->
                                new Row(
                                        VesperStrings.readAt(
                                                entry, offset(LAYOUT_ENTRY, "struct_name")),
                                        VesperStrings.readAt(entry, offset(LAYOUT_ENTRY, "field")),
                                        entry.get(JAVA_INT, offset(LAYOUT_ENTRY, "offset")),
                                        entry.get(JAVA_INT, offset(LAYOUT_ENTRY, "size"))))
                .toList();
    }

    /**
     * Compares the library's layout of every struct with this class.
     *
     * @throws IllegalStateException if a layout differs
     */
    static void check(List<Row> library) {
        for (StructLayout layout : ALL) {
            String struct = layout.name().orElseThrow();
            expect(library, new Row(struct, "", 0, layout.byteSize()));
            for (MemoryLayout member : layout.memberLayouts()) {
                String field = member.name().orElseThrow();
                expect(library, new Row(struct, field, offset(layout, field), member.byteSize()));
            }
        }
    }

    private static void expect(List<Row> library, Row expected) {
        String name =
                expected.field.isEmpty() ? expected.struct : expected.struct + "." + expected.field;
        Row found =
                library.stream()
                        .filter(
                                row ->
                                        row.struct.equals(expected.struct)
                                                && row.field.equals(expected.field))
                        .findFirst()
                        .orElseThrow(() -> mismatch(name + " is missing from the library's table"));
        if (!found.equals(expected)) {
            throw mismatch(
                    name
                            + " is at offset "
                            + found.offset
                            + " with "
                            + found.size
                            + " bytes in the library, expected offset "
                            + expected.offset
                            + " with "
                            + expected.size
                            + " bytes");
        }
    }

    private static IllegalStateException mismatch(String what) {
        return new IllegalStateException(
                "libvesper does not fit this Java binding: "
                        + what
                        + "; use a library and a jar of the same release");
    }
}
