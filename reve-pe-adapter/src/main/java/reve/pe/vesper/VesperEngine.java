// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static reve.pe.vesper.VesperLayouts.ENGINE_CONFIG;
import static reve.pe.vesper.VesperLayouts.LAW_INFO;
import static reve.pe.vesper.VesperLayouts.PARAMETER;
import static reve.pe.vesper.VesperLayouts.offset;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_BYTE;
import static java.lang.foreign.ValueLayout.JAVA_DOUBLE;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import org.jspecify.annotations.Nullable;

import reve.pe.LedgerLine;
import reve.pe.OwnColumn;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.PythonLaw;
import reve.pe.Status;
import reve.pe.vesper.VesperErrors.LibraryNames;

import java.io.IOException;
import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.TreeMap;
import java.util.function.ToIntFunction;
import java.util.stream.Collectors;

/**
 * The Vesper engine. It uses the arrays of its provider in place, and {@link #advance} is one
 * native call. The caller closes all prepared libraries before the engine, and waits until {@code
 * prepare} has returned on other threads.
 */
public final class VesperEngine implements PhysicsEngine {
    private static final long STRUCT_SIZE = offset(LAW_INFO, "struct_size");
    private static final long NANOSECONDS = offset(LAW_INFO, "nanoseconds");

    private final Arena arena = Arena.ofShared();
    private final Prototype prototype;
    private final List<Path> lawPath;
    private final VesperErrors errors;
    private final MemorySegment config;
    private final MemorySegment engine;
    private final VesperProvider provider;
    private final MemorySegment lawInfo;
    private final MemorySegment out;
    private final Map<Integer, LibraryNames> libraries = new LinkedHashMap<>();

    /** The libraries before the changes in progress; null if there are none. */
    private @Nullable Map<Integer, LibraryNames> before;

    /** The ids of the libraries in the order of loading, and the number of laws of each. */
    private int[] libraryIds = {};

    private int[] lawCounts = {};
    private volatile boolean closed;

    /**
     * Creates an engine for a prototype. The system property {@code reve.native.path} names the
     * folder of the native library.
     *
     * @throws IllegalStateException if libvesper is missing or of another release
     * @throws PhysicsException if the engine refuses the prototype
     */
    public VesperEngine(VesperConfig config, Prototype prototype) {
        checkLibrary();
        this.prototype = prototype;
        this.lawPath = config.lawPath();
        errors = new VesperErrors(arena, libraries::get);
        lawInfo = arena.allocate(LAW_INFO);
        out = arena.allocate(JAVA_LONG);
        try {
            this.config = writeConfig(config, arena);
            engine = create();
        } catch (RuntimeException e) {
            arena.close();
            throw e;
        }
        provider =
                new VesperProvider(
                        this,
                        EngineFunctions.enginePropertyProvider(engine),
                        errors,
                        prototype,
                        arena);
    }

    /**
     * Returns a prototype that the engine defines.
     *
     * @param name "si-f64" or "si-f32"
     * @throws PhysicsException with the status NOT_FOUND for another name
     */
    public static Prototype standardPrototype(String name) {
        checkLibrary();
        try (Arena call = Arena.ofConfined()) {
            MemorySegment found = VesperLibrary.prototypeStandard(VesperStrings.write(call, name));
            if (found.address() == 0) {
                throw new PhysicsException(
                        Status.NOT_FOUND,
                        "there is no standard prototype '" + name + "', expected si-f64 or si-f32");
            }
            return VesperPrototypes.read(found);
        }
    }

    /** Returns the native library's compiler, flags and version, and the version of its ABI. */
    public static String buildInfo() {
        checkLibrary();
        int abi = VesperLibrary.abiVersion();
        return VesperStrings.read(VesperLibrary.buildInfo())
                + ", contract "
                + (abi >>> 16)
                + "."
                + (abi & 0xFFFF);
    }

    @Override
    public PhysicalPropertyProvider propertyProvider() {
        return provider;
    }

    @Override
    public Prototype prototype() {
        return prototype;
    }

    @Override
    public PreparedLibrary prepare(String library) {
        return prepare(LibraryFile.find(library, lawPath));
    }

    @Override
    public PreparedLibrary prepare(Path file) {
        checkOpen();
        try {
            if (file.getFileName().toString().endsWith(PreparedLibrary.TEXT_ENDING)) {
                return prepareText(file.getFileName().toString(), LawText.read(file));
            }
            if (file.getFileName().toString().endsWith(PreparedLibrary.PYTHON_ENDING)) {
                throw PythonLaw.refusedHere(file.getFileName().toString());
            }
            return prepareNative(file.toAbsolutePath().toString(), LibraryFile.read(file));
        } catch (IOException e) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED, file + " cannot be read: " + e.getMessage());
        }
    }

    @Override
    public PreparedLibrary prepare(byte[] library) {
        checkOpen();
        if (PreparedLibrary.isPython(library)) {
            throw PythonLaw.refusedHere("a law");
        }
        return PreparedLibrary.isText(library)
                ? prepareText("text", library)
                : prepareNative("a law library.so", library);
    }

    @Override
    public PreparedLibrary prepareText(String source, byte[] text) {
        checkOpen();
        return new VesperPreparedLibrary(LawText.prepare(prototype, source, text), text, source);
    }

    @Override
    public String checkText(String source, byte[] text) {
        checkOpen();
        return LawText.check(prototype, source, text);
    }

    @Override
    public int loadPhysicsLaw(PreparedLibrary prepared, Map<String, Double> parameters) {
        VesperPreparedLibrary library = own(prepared);
        give(
                library,
                parameters,
                values ->
                        EngineFunctions.engineLoadPrepared(
                                engine,
                                library.handle(),
                                values,
                                parameters.size(),
                                out,
                                errors.segment()));
        int id = out.get(JAVA_INT, 0);
        list(id, library);
        return id;
    }

    @Override
    public void replacePhysicsLaw(
            int libraryId, PreparedLibrary prepared, Map<String, Double> parameters) {
        VesperPreparedLibrary library = own(prepared);
        give(
                library,
                parameters,
                values ->
                        EngineFunctions.engineReplaceLibrary(
                                engine,
                                libraryId,
                                library.handle(),
                                values,
                                parameters.size(),
                                errors.segment()));
        list(libraryId, library);
    }

    private VesperPreparedLibrary own(PreparedLibrary prepared) {
        checkOpen();
        if (prepared instanceof VesperPreparedLibrary library) {
            return library;
        }
        throw new IllegalArgumentException(
                "prepared library '"
                        + prepared.name()
                        + "' was prepared by another kind of engine");
    }

    /**
     * Loads a library into the engine. The message about a refused text contains all its problems.
     */
    private void give(
            VesperPreparedLibrary library,
            Map<String, Double> parameters,
            ToIntFunction<MemorySegment> give) {
        try (Arena call = Arena.ofConfined()) {
            int status = give.applyAsInt(writeParameters(call, parameters));
            if (status != 0 && library.source() != null) {
                throw LawText.withReport(
                        prototype, library.source(), library.bytes(), errors.exception(status));
            }
            errors.check(status);
        }
        library.taken();
    }

    private void list(int id, VesperPreparedLibrary library) {
        libraries.put(
                id,
                new LibraryNames(library.name(), laws(id).stream().map(PhysicsLaw::name).toList()));
        listLibraries();
    }

    @Override
    public void unloadPhysicsLaw(int libraryId) {
        checkOpen();
        errors.check(EngineFunctions.engineUnloadPhysicsLaw(engine, libraryId, errors.segment()));
        libraries.remove(libraryId);
        listLibraries();
    }

    @Override
    public void beginChanges() {
        checkOpen();
        if (before != null) {
            throw new IllegalStateException("changes are in progress; end them first");
        }
        errors.check(EngineFunctions.engineBeginChanges(engine, errors.segment()));
        before = new LinkedHashMap<>(libraries);
    }

    @Override
    public void endChanges(boolean keep) {
        checkOpen();
        if (before == null) {
            throw new IllegalStateException("no changes are in progress; begin them first");
        }
        Map<Integer, LibraryNames> begun = before;
        before = null;
        errors.check(EngineFunctions.engineEndChanges(engine, keep ? 1 : 0, errors.segment()));
        if (!keep) {
            libraries.clear();
            libraries.putAll(begun);
            listLibraries();
        }
    }

    private void listLibraries() {
        libraryIds = libraries.keySet().stream().mapToInt(Integer::intValue).toArray();
        lawCounts = libraries.values().stream().mapToInt(names -> names.laws().size()).toArray();
    }

    @Override
    public void setInterval(int libraryId, int interval) {
        checkOpen();
        errors.check(
                EngineFunctions.engineSetInterval(engine, libraryId, interval, errors.segment()));
    }

    @Override
    public List<double[]> ownValues(List<OwnColumn> columns, long row) {
        checkOpen();
        List<double[]> values = new ArrayList<>();
        try (Arena call = Arena.ofConfined()) {
            for (OwnColumn column : columns) {
                MemorySegment numbers = call.allocate(JAVA_DOUBLE, column.components());
                errors.check(
                        EngineFunctions.engineScratchRow(
                                engine, column, row, numbers, errors.segment()));
                values.add(numbers.toArray(JAVA_DOUBLE));
            }
        }
        return values;
    }

    @Override
    public void readTimes(long[] into) {
        checkOpen();
        int read = 0;
        for (int i = 0; i < libraryIds.length; i++) { // an iterator of the map would be allocated
            for (int law = 0; law < lawCounts[i]; law++) {
                nextLaw(libraryIds[i], law);
                into[read++] = lawInfo.get(JAVA_LONG, NANOSECONDS);
            }
        }
    }

    @Override
    public List<PhysicsLaw> laws() {
        checkOpen();
        return libraries.keySet().stream().flatMap(id -> laws(id).stream()).toList();
    }

    @Override
    public void advance(double dt, int steps) {
        checkOpen();
        provider.checkArraysAlive();
        errors.check(EngineFunctions.engineAdvance(engine, dt, steps, errors.segment()));
    }

    @Override
    public void clearFault() {
        checkOpen();
        errors.check(EngineFunctions.engineClearFault(engine, errors.segment()));
    }

    @Override
    public void moveRows(String kind, long[] moves) {
        checkOpen();
        try (Arena call = Arena.ofConfined()) {
            MemorySegment name = VesperStrings.write(call, kind);
            for (int i = 0; i < moves.length; i += 2) {
                errors.check(
                        EngineFunctions.engineMoveRow(
                                engine, name, moves[i], moves[i + 1], errors.segment()));
            }
        }
    }

    @Override
    public void setStepCount(long steps, double dtSeconds) {
        checkOpen();
        errors.check(
                EngineFunctions.engineSetStepCount(engine, steps, dtSeconds, errors.segment()));
    }

    @Override
    public long stepCount() {
        checkOpen();
        return EngineFunctions.engineStepCount(engine);
    }

    @Override
    public long stateHash() {
        checkOpen();
        provider.checkArraysAlive();
        errors.check(EngineFunctions.engineStateHash(engine, out, errors.segment()));
        return out.get(JAVA_LONG, 0);
    }

    @Override
    public byte[] saveState() {
        checkOpen();
        provider.checkArraysAlive();
        try (Arena call = Arena.ofConfined()) {
            errors.check(EngineFunctions.engineStateSize(engine, out, errors.segment()));
            MemorySegment state = call.allocate(out.get(JAVA_LONG, 0));
            errors.check(
                    EngineFunctions.engineSaveState(
                            engine, state, state.byteSize(), errors.segment()));
            return state.toArray(JAVA_BYTE);
        }
    }

    @Override
    public void loadState(byte[] state) {
        checkOpen();
        try (Arena call = Arena.ofConfined()) {
            MemorySegment copy = call.allocateFrom(JAVA_BYTE, state);
            errors.check(
                    EngineFunctions.engineLoadState(
                            engine, copy, copy.byteSize(), errors.segment()));
        }
    }

    @Override
    public void setLedger(boolean on) {
        checkOpen();
        errors.check(EngineFunctions.engineSetLedger(engine, on ? 1 : 0, errors.segment()));
    }

    @Override
    public List<LedgerLine> ledger() {
        checkOpen();
        provider.checkArraysAlive();
        return VesperLedger.read(engine, laws(), errors);
    }

    @Override
    public void close() {
        if (!closed) {
            closed = true;
            EngineFunctions.engineDestroy(engine);
            arena.close();
        }
    }

    void checkOpen() {
        if (closed) {
            throw new IllegalStateException("the engine is closed");
        }
    }

    private MemorySegment create() {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment handle = call.allocate(ADDRESS);
            errors.check(
                    EngineFunctions.engineCreate(
                            config,
                            VesperPrototypes.write(call, prototype),
                            handle,
                            errors.segment()));
            return handle.get(ADDRESS, 0);
        }
    }

    private static MemorySegment writeConfig(VesperConfig config, Arena arena) {
        MemorySegment struct = arena.allocate(ENGINE_CONFIG);
        EngineFunctions.engineConfigInit(struct);
        struct.set(JAVA_INT, offset(ENGINE_CONFIG, "threads"), config.threads());
        struct.set(JAVA_INT, offset(ENGINE_CONFIG, "validate"), config.validate() ? 1 : 0);
        struct.set(JAVA_INT, offset(ENGINE_CONFIG, "touches"), 1);
        struct.set(JAVA_INT, offset(ENGINE_CONFIG, "limit_values"), 1);
        struct.set(JAVA_INT, offset(ENGINE_CONFIG, "rest_without_fields"), 1);
        struct.set(
                ADDRESS,
                offset(ENGINE_CONFIG, "law_path"),
                VesperStrings.write(
                        arena,
                        config.lawPath().stream()
                                .map(Path::toString)
                                .collect(Collectors.joining(":"))));
        struct.set(ADDRESS, offset(ENGINE_CONFIG, "log"), LogUpcall.create(config.log(), arena));
        return struct;
    }

    private PreparedLibrary prepareNative(String source, byte[] bytes) {
        try (Arena call = Arena.ofConfined()) {
            VesperErrors failure = new VesperErrors(call, id -> null);
            MemorySegment handle = call.allocate(ADDRESS);
            failure.check(
                    LibraryFunctions.libraryPrepareBytes(
                            config,
                            call.allocateFrom(JAVA_BYTE, bytes),
                            VesperStrings.write(call, source),
                            handle,
                            failure.segment()));
            return new VesperPreparedLibrary(handle.get(ADDRESS, 0), bytes, null);
        }
    }

    @Override
    public List<PhysicsLaw> laws(int libraryId) {
        checkOpen();
        List<PhysicsLaw> laws = new ArrayList<>();
        while (nextLaw(libraryId, laws.size())) {
            laws.add(VesperPrototypes.readLaw(lawInfo));
        }
        return laws;
    }

    private boolean nextLaw(int libraryId, int index) {
        lawInfo.set(JAVA_INT, STRUCT_SIZE, (int) LAW_INFO.byteSize());
        return EngineFunctions.engineLawInfo(engine, libraryId, index, lawInfo, errors.segment())
                == 0;
    }

    /**
     * Copies the parameters to C structs in the order of their names, so that messages about them
     * are deterministic.
     */
    private static MemorySegment writeParameters(Arena arena, Map<String, Double> parameters) {
        MemorySegment array = arena.allocate(PARAMETER, Math.max(1, parameters.size()));
        long row = 0;
        for (Map.Entry<String, Double> parameter : new TreeMap<>(parameters).entrySet()) {
            MemorySegment struct = array.asSlice(row++ * PARAMETER.byteSize(), PARAMETER);
            struct.set(JAVA_INT, offset(PARAMETER, "struct_size"), (int) PARAMETER.byteSize());
            struct.set(
                    ADDRESS,
                    offset(PARAMETER, "name"),
                    VesperStrings.write(arena, parameter.getKey()));
            struct.set(JAVA_DOUBLE, offset(PARAMETER, "value"), parameter.getValue());
        }
        return array;
    }

    /** Compares the struct layouts of this binding with the table in the native library. */
    private static void checkLibrary() {
        Path library = NativeFolder.libvesper();
        try (Arena call = Arena.ofConfined()) {
            MemorySegment count = call.allocate(JAVA_INT);
            MemorySegment first = VesperLibrary.abiLayout(count);
            VesperLayouts.check(VesperLayouts.read(first, count.get(JAVA_INT, 0)));
        } catch (LinkageError unopened) {
            throw NativeFolder.refused(library, unopened);
        }
    }
}
