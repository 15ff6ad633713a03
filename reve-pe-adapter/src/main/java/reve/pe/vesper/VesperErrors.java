// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static reve.pe.vesper.VesperLayouts.ERROR;
import static reve.pe.vesper.VesperLayouts.offset;

import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import org.jspecify.annotations.Nullable;

import reve.pe.PhysicsException;
import reve.pe.Status;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.List;
import java.util.function.IntFunction;

/**
 * The conversion of a status to an exception. This object owns the error struct that C functions
 * fill. All calls use the same struct. The thread rule of the called object applies.
 */
final class VesperErrors {
    private static final long LIBRARY_ID = offset(ERROR, "library_id");
    private static final long LAW_INDEX = offset(ERROR, "law_index");
    private static final long ROW = offset(ERROR, "row");
    private static final long PROPERTY = offset(ERROR, "property");
    private static final long PROPERTY_SIZE = offset(ERROR, "message") - PROPERTY;
    private static final long MESSAGE = offset(ERROR, "message");
    private static final long MESSAGE_SIZE = ERROR.byteSize() - MESSAGE;

    private final MemorySegment segment;
    private final IntFunction<@Nullable LibraryNames> libraries;

    /** The name of a loaded library, and the names of its laws in the order of its table. */
    record LibraryNames(String library, List<String> laws) {}

    /**
     * @param libraries returns the names of a loaded library by its id; null if it is not loaded
     */
    VesperErrors(Arena arena, IntFunction<@Nullable LibraryNames> libraries) {
        this.segment = arena.allocate(ERROR);
        this.libraries = libraries;
    }

    /** Returns the {@code vesper_error*} to pass to C. */
    MemorySegment segment() {
        return segment;
    }

    /** Throws an exception with the content of the error struct unless the status is OK. */
    void check(int status) {
        if (status != 0) {
            throw exception(status);
        }
    }

    /** Returns an exception with the content of the error struct. */
    PhysicsException exception(int status) {
        int library = segment.get(JAVA_INT, LIBRARY_ID);
        LibraryNames names = libraries.apply(library);
        return new PhysicsException(
                status(status),
                library,
                names == null ? "" : names.library,
                names == null ? "" : lawName(names.laws, segment.get(JAVA_INT, LAW_INDEX)),
                VesperStrings.readInline(segment, PROPERTY, PROPERTY_SIZE),
                segment.get(JAVA_LONG, ROW),
                VesperStrings.readInline(segment, MESSAGE, MESSAGE_SIZE));
    }

    private static String lawName(List<String> laws, int index) {
        return index >= 0 && index < laws.size() ? laws.get(index) : "";
    }

    /**
     * Converts a status number of {@code types.h}. These numbers have the order of {@link Status}
     * and begin with 1.
     */
    private static Status status(int number) {
        return number >= 1 && number <= Status.INTERNAL.ordinal() + 1
                ? Status.values()[number - 1]
                : Status.UNKNOWN;
    }
}
