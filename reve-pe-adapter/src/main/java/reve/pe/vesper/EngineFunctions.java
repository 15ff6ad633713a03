// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static reve.pe.vesper.VesperLibrary.function;
import static reve.pe.vesper.VesperLibrary.procedure;
import static reve.pe.vesper.VesperLibrary.rethrown;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_DOUBLE;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import reve.pe.OwnColumn;

import java.lang.foreign.MemorySegment;
import java.lang.invoke.MethodHandle;

/**
 * Bindings of the C functions of {@code engine.h} that need an engine, one static method each, with
 * the same order of arguments. The methods return C's status numbers; {@link VesperErrors} converts
 * them to exceptions. A program whose engines all run in separate processes never loads this class.
 * It then saves the processor time for linking these functions.
 */
final class EngineFunctions {
    private static final MethodHandle CONFIG_INIT =
            procedure("vesper_engine_config_init_sized", ADDRESS, JAVA_LONG);
    private static final MethodHandle ENGINE_CREATE =
            function("vesper_engine_create", JAVA_INT, ADDRESS, ADDRESS, ADDRESS, ADDRESS);
    private static final MethodHandle ENGINE_DESTROY = procedure("vesper_engine_destroy", ADDRESS);
    private static final MethodHandle PROPERTY_PROVIDER =
            function("vesper_engine_property_provider", ADDRESS, ADDRESS);
    private static final MethodHandle ADD_PROPERTY =
            function(
                    "vesper_provider_add_physical_property",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS);
    private static final MethodHandle REBIND_PROPERTY =
            function(
                    "vesper_provider_rebind_physical_property",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS,
                    JAVA_LONG,
                    ADDRESS);
    private static final MethodHandle REMOVE_PROPERTY =
            function(
                    "vesper_provider_remove_physical_property",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS);
    private static final MethodHandle FIND_PROPERTY =
            function(
                    "vesper_provider_find_physical_property",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS);
    private static final MethodHandle TOUCH =
            function("vesper_provider_touch", JAVA_INT, ADDRESS, ADDRESS, JAVA_INT, ADDRESS);
    private static final MethodHandle LOAD_PREPARED =
            function(
                    "vesper_engine_load_prepared",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    ADDRESS,
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS);
    private static final MethodHandle UNLOAD_LAW =
            function("vesper_engine_unload_physics_law", JAVA_INT, ADDRESS, JAVA_INT, ADDRESS);
    private static final MethodHandle REPLACE_LIBRARY =
            function(
                    "vesper_engine_replace_library",
                    JAVA_INT,
                    ADDRESS,
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    JAVA_INT,
                    ADDRESS);
    private static final MethodHandle BEGIN_CHANGES =
            function("vesper_engine_begin_changes", JAVA_INT, ADDRESS, ADDRESS);
    private static final MethodHandle END_CHANGES =
            function("vesper_engine_end_changes", JAVA_INT, ADDRESS, JAVA_INT, ADDRESS);
    private static final MethodHandle SET_INTERVAL =
            function("vesper_engine_set_interval", JAVA_INT, ADDRESS, JAVA_INT, JAVA_INT, ADDRESS);
    private static final MethodHandle LAW_INFO =
            function(
                    "vesper_engine_law_info",
                    JAVA_INT,
                    ADDRESS,
                    JAVA_INT,
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS);
    private static final MethodHandle SCRATCH_ROW =
            function(
                    "vesper_engine_scratch_row",
                    JAVA_INT,
                    ADDRESS,
                    JAVA_INT,
                    JAVA_INT,
                    JAVA_INT,
                    JAVA_LONG,
                    ADDRESS,
                    JAVA_INT,
                    ADDRESS);
    private static final MethodHandle ADVANCE =
            function("vesper_engine_advance", JAVA_INT, ADDRESS, JAVA_DOUBLE, JAVA_INT, ADDRESS);
    private static final MethodHandle CLEAR_FAULT =
            function("vesper_engine_clear_fault", JAVA_INT, ADDRESS, ADDRESS);
    private static final MethodHandle MOVE_ROW =
            function(
                    "vesper_engine_move_row",
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS,
                    JAVA_LONG,
                    JAVA_LONG,
                    ADDRESS);
    private static final MethodHandle SET_STEP_COUNT =
            function(
                    "vesper_engine_set_step_count",
                    JAVA_INT,
                    ADDRESS,
                    JAVA_LONG,
                    JAVA_DOUBLE,
                    ADDRESS);
    private static final MethodHandle STEP_COUNT =
            function("vesper_engine_step_count", JAVA_LONG, ADDRESS);
    private static final MethodHandle STATE_SIZE =
            function("vesper_engine_state_size", JAVA_INT, ADDRESS, ADDRESS, ADDRESS);
    private static final MethodHandle SAVE_STATE =
            function("vesper_engine_save_state", JAVA_INT, ADDRESS, ADDRESS, JAVA_LONG, ADDRESS);
    private static final MethodHandle LOAD_STATE =
            function("vesper_engine_load_state", JAVA_INT, ADDRESS, ADDRESS, JAVA_LONG, ADDRESS);
    private static final MethodHandle STATE_HASH =
            function("vesper_engine_state_hash", JAVA_INT, ADDRESS, ADDRESS, ADDRESS);
    private static final MethodHandle SET_LEDGER =
            function("vesper_engine_set_ledger", JAVA_INT, ADDRESS, JAVA_INT, ADDRESS);
    private static final MethodHandle LEDGER =
            function(
                    "vesper_engine_ledger",
                    JAVA_INT,
                    ADDRESS,
                    JAVA_INT,
                    JAVA_INT,
                    ADDRESS,
                    ADDRESS);

    private EngineFunctions() {}

    static void engineConfigInit(MemorySegment config) {
        try {
            CONFIG_INIT.invokeExact(config, config.byteSize());
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineCreate(
            MemorySegment config, MemorySegment prototype, MemorySegment out, MemorySegment error) {
        try {
            return (int) ENGINE_CREATE.invokeExact(config, prototype, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static void engineDestroy(MemorySegment engine) {
        try {
            ENGINE_DESTROY.invokeExact(engine);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static MemorySegment enginePropertyProvider(MemorySegment engine) {
        try {
            return (MemorySegment) PROPERTY_PROVIDER.invokeExact(engine);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int providerAddPhysicalProperty(
            MemorySegment provider,
            MemorySegment name,
            MemorySegment data,
            long valueCount,
            MemorySegment indices,
            long objectCount,
            MemorySegment error) {
        try {
            return (int)
                    ADD_PROPERTY.invokeExact(
                            provider, name, data, valueCount, indices, objectCount, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int providerRebindPhysicalProperty(
            MemorySegment provider,
            MemorySegment name,
            MemorySegment data,
            long valueCount,
            MemorySegment indices,
            long objectCount,
            MemorySegment error) {
        try {
            return (int)
                    REBIND_PROPERTY.invokeExact(
                            provider, name, data, valueCount, indices, objectCount, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int providerRemovePhysicalProperty(
            MemorySegment provider, MemorySegment name, MemorySegment error) {
        try {
            return (int) REMOVE_PROPERTY.invokeExact(provider, name, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int providerFindPhysicalProperty(
            MemorySegment provider, MemorySegment name, MemorySegment out, MemorySegment error) {
        try {
            return (int) FIND_PROPERTY.invokeExact(provider, name, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int providerTouch(
            MemorySegment provider, MemorySegment names, int count, MemorySegment error) {
        try {
            return (int) TOUCH.invokeExact(provider, names, count, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineLoadPrepared(
            MemorySegment engine,
            MemorySegment prepared,
            MemorySegment parameters,
            int count,
            MemorySegment out,
            MemorySegment error) {
        try {
            return (int) LOAD_PREPARED.invokeExact(engine, prepared, parameters, count, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineSetInterval(
            MemorySegment engine, int library, int interval, MemorySegment error) {
        try {
            return (int) SET_INTERVAL.invokeExact(engine, library, interval, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineScratchRow(
            MemorySegment engine,
            OwnColumn column,
            long row,
            MemorySegment out,
            MemorySegment error) {
        try {
            return (int)
                    SCRATCH_ROW.invokeExact(
                            engine,
                            column.libraryId(),
                            column.law(),
                            column.use(),
                            row,
                            out,
                            column.components(),
                            error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineUnloadPhysicsLaw(MemorySegment engine, int library, MemorySegment error) {
        try {
            return (int) UNLOAD_LAW.invokeExact(engine, library, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineReplaceLibrary(
            MemorySegment engine,
            int library,
            MemorySegment prepared,
            MemorySegment parameters,
            int count,
            MemorySegment error) {
        try {
            return (int)
                    REPLACE_LIBRARY.invokeExact(
                            engine, library, prepared, parameters, count, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineBeginChanges(MemorySegment engine, MemorySegment error) {
        try {
            return (int) BEGIN_CHANGES.invokeExact(engine, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineEndChanges(MemorySegment engine, int keep, MemorySegment error) {
        try {
            return (int) END_CHANGES.invokeExact(engine, keep, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineLawInfo(
            MemorySegment engine, int library, int index, MemorySegment out, MemorySegment error) {
        try {
            return (int) LAW_INFO.invokeExact(engine, library, index, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineAdvance(MemorySegment engine, double dt, int steps, MemorySegment error) {
        try {
            return (int) ADVANCE.invokeExact(engine, dt, steps, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineClearFault(MemorySegment engine, MemorySegment error) {
        try {
            return (int) CLEAR_FAULT.invokeExact(engine, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineMoveRow(
            MemorySegment engine, MemorySegment kind, long from, long to, MemorySegment error) {
        try {
            return (int) MOVE_ROW.invokeExact(engine, kind, from, to, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineSetStepCount(
            MemorySegment engine, long steps, double dt, MemorySegment error) {
        try {
            return (int) SET_STEP_COUNT.invokeExact(engine, steps, dt, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static long engineStepCount(MemorySegment engine) {
        try {
            return (long) STEP_COUNT.invokeExact(engine);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineStateSize(MemorySegment engine, MemorySegment out, MemorySegment error) {
        try {
            return (int) STATE_SIZE.invokeExact(engine, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineSaveState(
            MemorySegment engine, MemorySegment out, long size, MemorySegment error) {
        try {
            return (int) SAVE_STATE.invokeExact(engine, out, size, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineLoadState(
            MemorySegment engine, MemorySegment state, long size, MemorySegment error) {
        try {
            return (int) LOAD_STATE.invokeExact(engine, state, size, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineStateHash(MemorySegment engine, MemorySegment out, MemorySegment error) {
        try {
            return (int) STATE_HASH.invokeExact(engine, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineSetLedger(MemorySegment engine, int on, MemorySegment error) {
        try {
            return (int) SET_LEDGER.invokeExact(engine, on, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }

    static int engineLedger(
            MemorySegment engine, int library, int line, MemorySegment out, MemorySegment error) {
        try {
            return (int) LEDGER.invokeExact(engine, library, line, out, error);
        } catch (Throwable t) {
            throw rethrown(t);
        }
    }
}
