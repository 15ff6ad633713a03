// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_INT;

import java.lang.foreign.Arena;
import java.lang.foreign.FunctionDescriptor;
import java.lang.foreign.Linker;
import java.lang.foreign.MemoryLayout;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.SymbolLookup;
import java.lang.invoke.MethodHandle;

/**
 * Bindings of the C functions of {@code engine.h} that need neither an engine nor a library of
 * laws, one static method each, with the same order of arguments. The methods return C's status
 * numbers; {@link VesperErrors} converts them to exceptions.
 */
@SuppressWarnings("restricted") // this class is the only one that looks up functions of the engine
final class VesperLibrary {
    private static final Linker LINKER = Linker.nativeLinker();
    private static final SymbolLookup SYMBOLS =
            SymbolLookup.libraryLookup(NativeFolder.libvesper(), Arena.global());

    private static final MethodHandle ABI_VERSION = function("vesper_abi_version", JAVA_INT);
    private static final MethodHandle BUILD_INFO = function("vesper_build_info", ADDRESS);
    private static final MethodHandle ABI_LAYOUT = function("vesper_abi_layout", ADDRESS, ADDRESS);
    private static final MethodHandle PROTOTYPE_STANDARD =
            function("vesper_prototype_standard", ADDRESS, ADDRESS);

    private VesperLibrary() {}

    static int abiVersion() {
        try {
            return (int) ABI_VERSION.invokeExact();
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static MemorySegment buildInfo() {
        try {
            return (MemorySegment) BUILD_INFO.invokeExact();
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static MemorySegment abiLayout(MemorySegment count) {
        try {
            return (MemorySegment) ABI_LAYOUT.invokeExact(count);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static MemorySegment prototypeStandard(MemorySegment name) {
        try {
            return (MemorySegment) PROTOTYPE_STANDARD.invokeExact(name);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    /** Returns the handle of a C function that returns a value. */
    static MethodHandle function(String name, MemoryLayout result, MemoryLayout... arguments) {
        return LINKER.downcallHandle(
                SYMBOLS.findOrThrow(name), FunctionDescriptor.of(result, arguments));
    }

    /** Returns the handle of a C function that returns nothing. */
    static MethodHandle procedure(String name, MemoryLayout... arguments) {
        return LINKER.downcallHandle(
                SYMBOLS.findOrThrow(name), FunctionDescriptor.ofVoid(arguments));
    }

    /**
     * Rethrows an exception that Java's binding threw, for example for a closed segment. C
     * functions throw no exceptions.
     */
    static RuntimeException rethrown(Throwable t) {
        if (t instanceof RuntimeException exception) {
            return exception;
        }
        if (t instanceof Error error) {
            throw error;
        }
        throw new AssertionError("a downcall threw a checked exception", t);
    }
}
