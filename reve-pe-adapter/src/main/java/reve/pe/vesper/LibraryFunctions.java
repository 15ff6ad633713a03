// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static reve.pe.vesper.VesperLibrary.function;
import static reve.pe.vesper.VesperLibrary.procedure;
import static reve.pe.vesper.VesperLibrary.rethrown;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import java.lang.foreign.MemorySegment;
import java.lang.invoke.MethodHandle;

/**
 * Bindings of the C functions of {@code engine.h} for prepared libraries and texts of laws, one
 * static method each, with the same order of arguments. They are linked only in processes that use
 * them, because linking costs time at the start. The methods return C's status numbers; {@link
 * VesperErrors} converts them to exceptions.
 */
final class LibraryFunctions {
    private static final MethodHandle LIBRARY_PREPARE_BYTES =
            function(
                    "vesper_library_prepare_bytes",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS);
    private static final MethodHandle LIBRARY_PREPARE_TEXT =
            function(
                    "vesper_library_prepare_text",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS,
                    ADDRESS);
    private static final MethodHandle TEXT_CHECK =
            function(
                    "vesper_text_check",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS);
    private static final MethodHandle LIBRARY_DISCARD =
            procedure("vesper_library_discard", ADDRESS);
    private static final MethodHandle LIBRARY_NAME =
            function("vesper_library_name", ADDRESS, ADDRESS);

    private LibraryFunctions() {}

    static int libraryPrepareBytes(
            MemorySegment config,
            MemorySegment bytes,
            MemorySegment source,
            MemorySegment out,
            MemorySegment error) {
        try {
            return (int)
                    LIBRARY_PREPARE_BYTES.invokeExact(
                            config, bytes, bytes.byteSize(), source, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int libraryPrepareText(
            MemorySegment source, MemorySegment text, MemorySegment out, MemorySegment error) {
        try {
            return (int)
                    LIBRARY_PREPARE_TEXT.invokeExact(source, text, text.byteSize(), out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int textCheck(
            MemorySegment prototype,
            MemorySegment source,
            MemorySegment text,
            MemorySegment report,
            MemorySegment error) {
        try {
            return (int)
                    TEXT_CHECK.invokeExact(
                            prototype,
                            source,
                            text,
                            text.byteSize(),
                            report,
                            report.byteSize(),
                            error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static void libraryDiscard(MemorySegment prepared) {
        try {
            LIBRARY_DISCARD.invokeExact(prepared);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static MemorySegment libraryName(MemorySegment prepared) {
        try {
            return (MemorySegment) LIBRARY_NAME.invokeExact(prepared);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }
}
