// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_INT;

import java.lang.System.Logger.Level;
import java.lang.foreign.Arena;
import java.lang.foreign.FunctionDescriptor;
import java.lang.foreign.Linker;
import java.lang.foreign.MemorySegment;
import java.lang.invoke.MethodHandle;
import java.lang.invoke.MethodHandles;
import java.lang.invoke.MethodType;

/** The C function pointer through which an engine sends log lines to a {@link VesperLog}. */
final class LogUpcall {
    private static final Level[] LEVELS = {Level.DEBUG, Level.INFO, Level.WARNING, Level.ERROR};
    private static final FunctionDescriptor SIGNATURE =
            FunctionDescriptor.ofVoid(ADDRESS, JAVA_INT, ADDRESS);
    private static final MethodHandle RECEIVE = receiver();

    private final VesperLog log;

    private LogUpcall(VesperLog log) {
        this.log = log;
    }

    /** Returns a function pointer that lives as long as the arena. */
    @SuppressWarnings("restricted") // an upcall is the only way to receive log lines
    static MemorySegment create(VesperLog log, Arena arena) {
        return Linker.nativeLinker()
                .upcallStub(RECEIVE.bindTo(new LogUpcall(log)), SIGNATURE, arena);
    }

    private void receive(MemorySegment user, int level, MemorySegment message) {
        try {
            log.log(LEVELS[Math.clamp(level, 1, LEVELS.length) - 1], VesperStrings.read(message));
        } catch (Throwable failure) {
            // The exception is printed here, because it must not reach C code. A failing log cannot
            // report its own failure.
            System.err.println("a Vesper log listener failed: " + failure);
        }
    }

    private static MethodHandle receiver() {
        try {
            return MethodHandles.lookup()
                    .findVirtual(
                            LogUpcall.class,
                            "receive",
                            MethodType.methodType(
                                    void.class,
                                    MemorySegment.class,
                                    int.class,
                                    MemorySegment.class));
        } catch (ReflectiveOperationException e) {
            throw new ExceptionInInitializerError(e);
        }
    }
}
