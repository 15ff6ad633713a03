// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;

import reve.pe.LedgerLine;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.PythonLaw;
import reve.pe.Status;
import reve.pe.posix.SharedPart;
import reve.pe.vesper.LawText;
import reve.pe.vesper.LibraryFile;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperLog;

import java.io.IOException;
import java.lang.foreign.MemorySegment;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.function.Consumer;
import java.util.function.Function;

/**
 * A Vesper engine in a process of its own, the host, which uses the arrays of the provider in
 * place. {@link #advance} is one exchange.
 *
 * <p>If a law ends the host, or does not return in time, the call fails with {@link
 * Status#LAW_CRASHED} or {@link Status#LAW_TIMED_OUT} and names the law. As after any failed
 * advance the client restores its arrays and unloads the library. The next call runs in a new host
 * with the laws that are still loaded, and the state of the engine after the last successful
 * advance. {@link Status#ENGINE_LOST} means that the host ended and no law is known to be the
 * cause; the call can be repeated.
 */
public final class HostedEngine implements PhysicsEngine {
    /** Time for a request that is not an advance, such as the creation of a law. */
    private static final Duration REQUEST = Duration.ofSeconds(10);

    /** Time for the first advance; laws may have much to build. */
    private static final Duration FIRST_ADVANCE = Duration.ofSeconds(10);

    /** A frame may take this many times the longest one of the last frames. */
    private static final int GROWTH = 8;

    /** Number of frames after which a long one counts about a third. */
    private static final int MEMORY = 256;

    private static final List<String> OTHER_LINES =
            List.of("client", "ground", "unloaded", "total");

    private final Hosts hosts;
    private final Duration frameLimit;
    private final VesperConfig config;
    private final Prototype prototype;
    private final HostedProvider provider;
    private final List<Loaded> libraries = new ArrayList<>();
    private final KeptState state = new KeptState();

    /** Moves of rows since the state was kept. */
    private final List<Move> moves = new ArrayList<>();

    private @Nullable HostProcess host;
    private int nextId = 1;
    private boolean ledger;

    /** Whether laws run one after the other, to find out which of several ended the last host. */
    private boolean alone;

    private long longestNanos;
    private boolean advancedBefore;
    private volatile boolean closed;

    private record Move(String kind, long from, long to) {}

    /**
     * Creates an engine and its first host.
     *
     * @param hosts starts its processes; closed after this object
     * @param frameLimit time that all laws together may take for an advance: processor time, and
     *     time in which they only wait. The first advance may take at least ten seconds, and others
     *     eight times the longest of the last frames
     * @param parts returns where hosts find memory that is lent to the engine, and throws
     *     IllegalArgumentException for other memory
     * @throws PhysicsException if the engine refuses the prototype
     * @throws IllegalStateException if no process can be started
     */
    public HostedEngine(
            Hosts hosts,
            Duration frameLimit,
            VesperConfig config,
            Prototype prototype,
            Function<MemorySegment, SharedPart> parts) {
        this.hosts = hosts;
        this.frameLimit = frameLimit;
        this.config = config;
        this.prototype = prototype;
        this.provider = new HostedProvider(this, prototype, parts);
        try {
            host();
        } catch (HostLost lost) {
            close();
            throw new IllegalStateException(
                    "the engine's process ended as soon as it was started: " + lost.getMessage());
        } catch (RuntimeException refused) {
            close();
            throw refused;
        }
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
        return prepare(LibraryFile.find(library, config.lawPath()));
    }

    @Override
    public PreparedLibrary prepare(Path file) {
        try {
            if (file.getFileName().toString().endsWith(PreparedLibrary.TEXT_ENDING)) {
                return prepareText(file.getFileName().toString(), LawText.read(file));
            }
            byte[] bytes = LibraryFile.read(file);
            if (file.getFileName().toString().endsWith(PreparedLibrary.PYTHON_ENDING)) {
                return preparePython(file.getFileName().toString(), bytes);
            }
            return prepare(file.toString(), bytes, HostedLibrary.Form.NATIVE);
        } catch (IOException e) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED, file + " cannot be read: " + e.getMessage());
        }
    }

    @Override
    public PreparedLibrary prepare(byte[] library) {
        if (PreparedLibrary.isPython(library)) {
            return preparePython(PythonLaw.nameOf(library), library);
        }
        return PreparedLibrary.isText(library)
                ? prepareText("text", library)
                : prepare("a law library", library, HostedLibrary.Form.NATIVE);
    }

    @Override
    public PreparedLibrary prepareText(String source, byte[] text) {
        checkOpen();
        String name = LawText.name(prototype, source, text);
        return new HostedLibrary(source, text, HostedLibrary.Form.TEXT).named(name);
    }

    @Override
    public String checkText(String source, byte[] text) {
        checkOpen();
        return LawText.check(prototype, source, text);
    }

    private PreparedLibrary preparePython(String source, byte[] bytes) {
        PythonLaw.requireLaw(source, bytes);
        return prepare(source, bytes, HostedLibrary.Form.PYTHON);
    }

    private PreparedLibrary prepare(String source, byte[] bytes, HostedLibrary.Form form) {
        checkOpen();
        return new Trial(hosts, config, prototype).prepare(source, bytes, form);
    }

    @Override
    public int loadPhysicsLaw(PreparedLibrary prepared, Map<String, Double> parameters) {
        checkOpen();
        if (!(prepared instanceof HostedLibrary library)) {
            throw new IllegalArgumentException(
                    "prepared library '"
                            + prepared.name()
                            + "' was prepared by another kind of engine");
        }
        library.requireFree();
        Loaded added = new Loaded(nextId, library, parameters);
        try {
            Calls calls = connected();
            loadWithReport(calls, added);
            library.taken();
            libraries.add(added);
            nextId++;
            state.keep(calls);
            return added.id;
        } catch (HostLost lost) {
            lose();
            throw new PhysicsException(
                    statusOf(lost),
                    "library "
                            + library.name()
                            + ": "
                            + lost.getMessage()
                            + " while it was loaded"
                            + (lost.late ? "" : "; the engine goes on in a new process"));
        }
    }

    /** Loads a library; the refusal of a text has all its problems. */
    private void loadWithReport(Calls calls, Loaded added) throws HostLost {
        try {
            load(calls, added);
        } catch (PhysicsException refused) {
            throw PreparedLibrary.isText(added.library.bytes())
                    ? LawText.withReport(
                            prototype, added.library.source(), added.library.bytes(), refused)
                    : refused;
        }
    }

    private static void load(Calls calls, Loaded library) throws HostLost {
        Mailbox reply =
                calls.call(
                        to -> {
                            Mailbox request =
                                    library.library
                                            .put(to.begin(Request.LOAD))
                                            .putInt(library.parameters.size());
                            library.parameters.forEach(
                                    (name, value) -> request.putText(name).putDouble(value));
                        });
        library.threads = reply.getInt();
        library.hostId = reply.getInt();
        library.read(reply);
    }

    @Override
    public void unloadPhysicsLaw(int libraryId) {
        checkOpen();
        Loaded old =
                libraries.stream()
                        .filter(library -> library.id == libraryId)
                        .findFirst()
                        .orElseThrow(
                                () ->
                                        new PhysicsException(
                                                Status.NOT_FOUND,
                                                "no library with id " + libraryId + " is loaded"));
        HostProcess current = host;
        if (current != null) {
            try {
                Calls calls = calls(current, REQUEST.toNanos(), config.log());
                int threads =
                        calls.call(to -> to.begin(Request.UNLOAD).putInt(old.hostId)).getInt();
                state.keep(calls);
                if (threads > old.threads) {
                    lose(); // a thread that the library left might still write
                }
            } catch (HostLost lost) {
                lose();
                state.leave(old.library.name());
                config.log().log(
                        System.Logger.Level.WARNING,
                        "library "
                                + old.library.name()
                                + ": "
                                + lost.getMessage()
                                + " while it was unloaded; the engine goes on in a new"
                                + " process");
            }
        } else {
            state.leave(old.library.name());
        }
        libraries.remove(old);
        old.library.free();
    }

    @Override
    public List<PhysicsLaw> laws() {
        checkOpen();
        List<PhysicsLaw> laws = new ArrayList<>();
        for (Loaded library : libraries) {
            if (host != null) {
                try {
                    library.read(
                            calls(host, REQUEST.toNanos(), config.log())
                                    .call(to -> to.begin(Request.LAWS).putInt(library.hostId)));
                } catch (HostLost lost) {
                    lose();
                }
            }
            laws.addAll(library.laws());
        }
        return laws;
    }

    @Override
    public void advance(double dt, int steps) {
        checkOpen();
        provider.checkArraysAlive();
        try {
            HostProcess current = host();
            if (provider.hasPending()) {
                provider.flush(calls(current, REQUEST.toNanos(), config.log()));
            }
            provider.flushTouches();
            current.begin(Request.ADVANCE).putDouble(dt).putInt(steps);
            long start = System.nanoTime();
            Mailbox reply = current.call(frameLimit(), config.log());
            requireOk(reply);
            boolean kept = state.keep(reply);
            for (int i = 0; i < libraries.size(); i++) { // an iterator would be allocated
                libraries.get(i).count(reply);
            }
            if (!kept) {
                Calls calls = calls(current, REQUEST.toNanos(), config.log());
                state.lend(calls);
                state.keep(calls);
            }
            longestNanos =
                    Math.max(System.nanoTime() - start, longestNanos - longestNanos / MEMORY);
            moves.clear();
            advancedBefore = true;
        } catch (HostLost lost) {
            throw lost(lost);
        }
    }

    private long frameLimit() {
        return Math.max(
                advancedBefore ? GROWTH * longestNanos : FIRST_ADVANCE.toNanos(),
                frameLimit.toNanos());
    }

    @Override
    public void clearFault() {
        checkOpen();
        if (host != null) {
            ask(to -> to.begin(Request.CLEAR_FAULT));
        }
    }

    @Override
    public void moveRow(String kind, long from, long to) {
        ask(host -> put(host, new Move(kind, from, to)));
        moves.add(new Move(kind, from, to));
    }

    private static void put(HostProcess host, Move move) {
        host.begin(Request.MOVE_ROW).putText(move.kind).putLong(move.from).putLong(move.to);
    }

    @Override
    public void setStepCount(long steps, double dtSeconds) {
        ask(to -> to.begin(Request.SET_STEP_COUNT).putLong(steps).putDouble(dtSeconds));
        keepState();
    }

    @Override
    public long stepCount() {
        checkOpen();
        return state.steps();
    }

    @Override
    public long stateHash() {
        checkOpen();
        provider.checkArraysAlive();
        provider.flushTouches();
        return ask(to -> to.begin(Request.STATE_HASH)).getLong();
    }

    @Override
    public byte[] saveState() {
        checkOpen();
        provider.checkArraysAlive();
        keepState();
        return state.bytes();
    }

    @Override
    public void loadState(byte[] saved) {
        checkOpen();
        try {
            Calls calls = connected();
            state.load(saved, List.of(), calls);
            state.keep(calls);
            moves.clear();
        } catch (HostLost lost) {
            throw lost(lost);
        }
    }

    private void keepState() {
        try {
            state.keep(connected());
            moves.clear();
        } catch (HostLost lost) {
            throw lost(lost);
        }
    }

    @Override
    public void setLedger(boolean on) {
        ask(to -> to.begin(Request.SET_LEDGER).putInt(on ? 1 : 0));
        ledger = on;
    }

    @Override
    public List<LedgerLine> ledger() {
        checkOpen();
        provider.checkArraysAlive();
        provider.flushTouches();
        int laws = libraries.stream().mapToInt(library -> library.laws().size()).sum();
        Mailbox reply =
                ask(
                        to -> {
                            Mailbox request =
                                    to.begin(Request.LEDGER).putInt(laws + OTHER_LINES.size());
                            for (Loaded library : libraries) {
                                for (int law = 0; law < library.laws().size(); law++) {
                                    request.putInt(library.hostId).putInt(law);
                                }
                            }
                            for (int line = 0; line < OTHER_LINES.size(); line++) {
                                request.putInt(0).putInt(line);
                            }
                        });
        List<LedgerLine> lines = new ArrayList<>();
        for (Loaded library : libraries) {
            library.laws().forEach(law -> lines.add(Wire.line(reply, law.name(), true)));
        }
        OTHER_LINES.forEach(name -> lines.add(Wire.line(reply, name, false)));
        return lines;
    }

    @Override
    public void close() {
        if (!closed) {
            closed = true;
            lose();
            libraries.forEach(library -> library.library.free());
            libraries.clear();
            state.close();
        }
    }

    void checkOpen() {
        if (closed) {
            throw new IllegalStateException("the engine is closed");
        }
    }

    /** Sends a request that does not depend on the arrays; once more if the host was lost. */
    Mailbox ask(Consumer<HostProcess> request) {
        checkOpen();
        try {
            try {
                return connected().call(request);
            } catch (HostLost lost) {
                if (!lost.running.isEmpty()) {
                    throw lost;
                }
                lose();
                return connected().call(request);
            }
        } catch (HostLost lost) {
            throw lost(lost);
        }
    }

    /** Returns a connection to the host, which has the present arrays. */
    private Calls connected() throws HostLost {
        Calls calls = calls(host(), REQUEST.toNanos(), config.log());
        if (provider.hasPending()) {
            provider.flush(calls);
        }
        return calls;
    }

    private Calls calls(HostProcess to, long limitNanos, VesperLog log) {
        return request -> {
            request.accept(to);
            Mailbox reply = to.call(limitNanos, log);
            requireOk(reply);
            return reply;
        };
    }

    private void requireOk(Mailbox reply) {
        if (reply.getInt() != 0) {
            throw failure(Wire.Failure.read(reply));
        }
    }

    /** Returns the host; if it was lost, a new one in the state that was kept. */
    private HostProcess host() throws HostLost {
        if (host != null && host.isAlive()) {
            return host;
        }
        lose();
        HostProcess fresh = hosts.take();
        try {
            Calls calls = calls(fresh, REQUEST.toNanos(), config.log());
            calls.create(config, alone ? 1 : config.threads(), prototype);
            provider.bindAll(calls);
            for (Loaded library : libraries) {
                reload(calls, library);
            }
            state.lend(calls);
            state.restore(calls);
            for (Move move : moves) {
                calls.call(to -> put(to, move));
            }
            if (ledger) {
                calls.call(to -> to.begin(Request.SET_LEDGER).putInt(1));
                if (state.steps() > 0) {
                    config.log().log(
                            System.Logger.Level.WARNING,
                            "the ledger begins again, with the engine's new process");
                }
            }
        } catch (HostLost | RuntimeException failed) {
            fresh.close();
            throw failed;
        }
        host = fresh;
        hosts.refill(); // now, because the start would have delayed this host
        return fresh;
    }

    /** Loads a library into a new host; what goes wrong here is the library's fault. */
    private static void reload(Calls calls, Loaded library) throws HostLost {
        try {
            load(calls, library);
        } catch (HostLost lost) {
            throw exception(
                    statusOf(lost), library, 0, "", -1, lost.getMessage() + " while it was loaded");
        }
    }

    /** Forgets the host; the next call starts another one. */
    void lose() {
        if (host != null) {
            host.close();
            host = null;
            libraries.forEach(Loaded::keepCounts);
        }
    }

    /** Returns the failure of the law that ended the host, or did not return. */
    private PhysicsException lost(HostLost lost) {
        lose();
        List<Loaded> running =
                lost.running.stream()
                        .map(word -> (int) (word >>> Integer.SIZE))
                        .distinct()
                        .flatMap(id -> byHostId(id).stream())
                        .toList();
        alone = running.size() > 1;
        if (running.size() != 1) {
            return new PhysicsException(
                    Status.ENGINE_LOST,
                    "the engine's process was lost ("
                            + lost.getMessage()
                            + ") while "
                            + (running.isEmpty() ? "no law" : running.size() + " libraries")
                            + " ran");
        }
        int law = (int) (lost.running.getFirst() & 0xFFFFFFFFL) - 1;
        long row = provider.row(lost.property, lost.offset);
        return exception(
                statusOf(lost),
                running.getFirst(),
                law,
                row < 0 ? "" : lost.property,
                row,
                lost.late
                        ? lost.getMessage() + " of its frame"
                        : "ended the engine's process: "
                                + lost.getMessage()
                                + (row < 0
                                        ? ""
                                        : "; it wrote property "
                                                + lost.property
                                                + ", row "
                                                + row
                                                + ", which no loaded law declares to write"));
    }

    private Optional<Loaded> byHostId(int id) {
        return libraries.stream().filter(library -> library.hostId == id).findFirst();
    }

    private static Status statusOf(HostLost lost) {
        return lost.late ? Status.LAW_TIMED_OUT : Status.LAW_CRASHED;
    }

    private static PhysicsException exception(
            Status status, Loaded library, int law, String property, long row, String message) {
        String name = library.lawName(law);
        return new PhysicsException(
                status,
                library.id,
                library.library.name(),
                name,
                property,
                row,
                (name.isEmpty() ? "library " + library.library.name() : "law " + name)
                        + ": "
                        + message);
    }

    private PhysicsException failure(Wire.Failure failure) {
        Optional<Loaded> library = byHostId(failure.library());
        return failure.exception(
                library.map(found -> found.id).orElse(0),
                library.map(found -> found.library.name()).orElse(""),
                library.map(found -> found.lawName(failure.law())).orElse(""));
    }
}
