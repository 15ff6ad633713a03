// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatCode;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;

import reve.pe.vesper.VesperLayouts.Row;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.List;

class VesperLayoutsNativeTest {
    private final List<Row> library = libraryTable();

    @Test
    void theLibraryLaysOutItsStructsAsThisBindingDoes() {
        assertThat(library).contains(new Row("vesper_error", "", 0, 256));
        assertThatCode(() -> VesperLayouts.check(library)).doesNotThrowAnyException();
    }

    @Test
    void aMovedFieldIsNamed() {
        replace(new Row("vesper_error", "row", 24, 8));
        assertThatIllegalStateException()
                .isThrownBy(() -> VesperLayouts.check(library))
                .withMessageContaining(
                        "vesper_error.row is at offset 24 with 8 bytes in the library,"
                                + " expected offset 16 with 8 bytes")
                .withMessageContaining("use a library and a jar of the same release");
    }

    @Test
    void aGrownStructIsNamed() {
        replace(new Row("vesper_engine_config", "", 0, 80));
        assertThatIllegalStateException()
                .isThrownBy(() -> VesperLayouts.check(library))
                .withMessageContaining("vesper_engine_config is at offset 0 with 80 bytes");
    }

    @Test
    void aMissingFieldIsNamed() {
        library.removeIf(
                row -> row.struct().equals("vesper_law_info") && row.field().equals("uses"));
        assertThatIllegalStateException()
                .isThrownBy(() -> VesperLayouts.check(library))
                .withMessageContaining("vesper_law_info.uses is missing from the library's table");
    }

    private void replace(Row changed) {
        library.replaceAll(
                row ->
                        row.struct().equals(changed.struct()) && row.field().equals(changed.field())
                                ? changed
                                : row);
    }

    private static List<Row> libraryTable() {
        try (Arena arena = Arena.ofConfined()) {
            MemorySegment count = arena.allocate(ValueLayout.JAVA_INT);
            MemorySegment first = VesperLibrary.abiLayout(count);
            return new ArrayList<>(VesperLayouts.read(first, count.get(ValueLayout.JAVA_INT, 0)));
        }
    }
}
