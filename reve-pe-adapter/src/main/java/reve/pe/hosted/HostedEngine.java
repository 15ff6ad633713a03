// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;

import reve.pe.LedgerLine;
import reve.pe.OwnColumn;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.Status;
import reve.pe.posix.SharedPart;
import reve.pe.vesper.LawText;
import reve.pe.vesper.LibraryFile;
import reve.pe.vesper.VesperConfig;

import java.lang.foreign.MemorySegment;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.function.Consumer;
import java.util.function.Function;
import java.util.function.LongPredicate;

/**
 * A Vesper engine in its own process, the host, which uses the arrays of the provider in place.
 * {@link #advance} is one exchange of a request and a reply.
 *
 * <p>The call fails with {@link Status#LAW_CRASHED} or {@link Status#LAW_TIMED_OUT} if a law ends
 * the host or does not return in time. The exception names the law. As after any failed advance,
 * the client restores its arrays and unloads the library. The next call runs in a new host. The new
 * host has the laws that are still loaded, and the state of the engine after the last successful
 * advance. {@link Status#ENGINE_LOST} means that the host ended and that no law is known to be the
 * cause. The call can then be repeated.
 */
public final class HostedEngine implements PhysicsEngine {
    /**
     * Time limit for a request that is not an advance, such as the creation of a law. All time
     * limits of this class are less than the 5 s after which a watchdog reports the world.
     */
    private static final long REQUEST_NANOS = Duration.ofSeconds(3).toNanos();

    /** Time limit for a new host to create its engine. */
    private static final long CREATE_NANOS = Duration.ofSeconds(1).toNanos();

    /** Time limit for advances in which laws may build large data structures. */
    private static final long BUILD_NANOS = Duration.ofSeconds(3).toNanos();

    /**
     * Number of advances with the time limit {@link #BUILD_NANOS}. Laws build data structures in
     * the first advance. The second advance is measured, to set later time limits.
     */
    private static final int BUILD_ADVANCES = 2;

    /** Maximum number of hosts that are started for one call. */
    private static final int STARTS = 3;

    /** Maximum time of a frame, as a multiple of the longest of the last frames. */
    private static final int GROWTH = 8;

    /** Number of frames after which a long frame counts with only about a third of its time. */
    private static final int MEMORY = 256;

    /**
     * Time without a start after two new processes in succession have not answered, as a multiple
     * of the time for which the world waited for the last one. Otherwise a program on a disk that
     * hangs would delay each frame.
     */
    private static final int REST_AFTER_LATE_START = 9;

    /** A message without numbers, so that it is reported once. */
    private static final String SILENT =
            "the engine's process did not answer before it had the world; another one is started,"
                    + " after a pause if the one before did not answer either";

    private final Hosts hosts;
    private final Duration frameLimit;
    private final VesperConfig config;
    private final Prototype prototype;
    private final HostedProvider provider;
    private final List<Loaded> libraries = new ArrayList<>();
    private final KeptState state = new KeptState();

    /** Moves of rows since the state was kept. */
    private final List<RowMoves> moves = new ArrayList<>();

    private @Nullable HostProcess host;

    /** The time before which no process is started [ns]; only while {@link #isResting}. */
    private long restsUntilNanos;

    private boolean isResting;

    /** Number of new processes in succession that did not answer. */
    private int lateStarts;

    private int nextId = 1;
    private boolean ledger;

    private final ReadyHosts ready;
    private final Losses losses;
    private final LibraryOpener opener;
    private long longestNanos;
    private long waitedNanos;

    /** Number of the next advances in which laws may build large data structures. */
    private int building = BUILD_ADVANCES;

    /** The changes in progress; null if there are none. */
    private @Nullable Changes changes;

    /** A state that a host of the present libraries has loaded, with its step count. */
    private KeptState.@Nullable Saved accepted;

    private volatile boolean closed;

    /** A method reference that is created once, because an advance must allocate nothing. */
    private final LongPredicate isApartWord = this::isApartWord;

    /**
     * Creates an engine and its first host.
     *
     * @param hosts object that starts the processes; the caller closes it after this engine
     * @param frameLimit time that all laws together may take for an advance: processor time, and
     *     time in which they only wait. The limit is at least three seconds for an advance in which
     *     laws may build data structures. For other advances it is at least eight times the longest
     *     of the last frames, up to three seconds
     * @param apart decides which native libraries run in a sandbox; the engine refuses laws in
     *     Python that would have to run in a sandbox
     * @param parts returns the shared memory that contains an array of the client; throws
     *     IllegalArgumentException for other memory
     * @throws PhysicsException if the engine refuses the prototype
     * @throws IllegalStateException if no process can be started
     */
    public HostedEngine(
            Hosts hosts,
            Duration frameLimit,
            VesperConfig config,
            Prototype prototype,
            ApartRule apart,
            Function<MemorySegment, SharedPart> parts) {
        this.opener = new LibraryOpener(hosts, config, prototype, apart);
        this.hosts = hosts;
        this.frameLimit = frameLimit;
        this.config = config;
        this.prototype = prototype;
        this.provider = new HostedProvider(this, prototype, parts);
        this.ready = new ReadyHosts(hosts, config, prototype);
        this.losses = new Losses(provider, libraries);
        try {
            host();
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
        checkOpen();
        return opener.open(file);
    }

    @Override
    public PreparedLibrary prepare(byte[] library) {
        checkOpen();
        return opener.open(library);
    }

    @Override
    public PreparedLibrary prepareText(String source, byte[] text) {
        checkOpen();
        return opener.openText(source, text);
    }

    @Override
    public String checkText(String source, byte[] text) {
        checkOpen();
        return LawText.check(prototype, source, text);
    }

    @Override
    public int loadPhysicsLaw(PreparedLibrary prepared, Map<String, Double> parameters) {
        HostedLibrary library = own(prepared);
        Loaded added = new Loaded(nextId, library, parameters);
        give(
                added,
                calls -> {
                    added.load(calls);
                    return calls;
                });
        libraries.add(added);
        nextId++;
        return added.id;
    }

    @Override
    public void replacePhysicsLaw(
            int libraryId, PreparedLibrary prepared, Map<String, Double> parameters) {
        HostedLibrary library = own(prepared);
        Loaded old = require(libraryId);
        Loaded added = new Loaded(libraryId, library, parameters);
        int threads = give(added, calls -> added.replace(calls, old));
        libraries.set(libraries.indexOf(old), added);
        if (changes == null && threads > added.threads && threads > old.threads) {
            lose(); // a thread that the old library left might still write
        }
        free(old);
    }

    private HostedLibrary own(PreparedLibrary prepared) {
        checkOpen();
        if (!(prepared instanceof HostedLibrary library)) {
            throw new IllegalArgumentException(
                    "prepared library '"
                            + prepared.name()
                            + "' was prepared by another kind of engine");
        }
        library.requireFree();
        return library;
    }

    /**
     * Loads a library into the host. The message about a refused text contains all its problems.
     */
    private <T> T give(Loaded added, Exchange<T> exchange) {
        HostedLibrary library = added.library;
        try {
            Calls calls = connected();
            T reply = exchange.with(calls);
            // The state is kept before the library counts as loaded, because a new host needs its
            // state.
            keep(calls);
            library.taken();
            accepted = null;
            expectBuilding();
            return reply;
        } catch (PhysicsException refused) {
            throw PreparedLibrary.isText(library.bytes())
                    ? LawText.withReport(prototype, library.source(), library.bytes(), refused)
                    : refused;
        } catch (HostLost lost) {
            lose();
            throw new PhysicsException(
                    Losses.statusOf(lost),
                    "library "
                            + library.name()
                            + ": "
                            + lost.getMessage()
                            + " while it was loaded"
                            + (lost.isLate() ? "" : "; the engine goes on in a new process"));
        }
    }

    private Loaded require(int libraryId) {
        checkOpen();
        return libraries.stream()
                .filter(library -> library.id == libraryId)
                .findFirst()
                .orElseThrow(
                        () ->
                                new PhysicsException(
                                        Status.NOT_FOUND,
                                        "no library with id " + libraryId + " is loaded"));
    }

    @Override
    public void unloadPhysicsLaw(int libraryId) {
        Loaded old = require(libraryId);
        HostProcess current = host;
        if (current != null) {
            try {
                Calls calls = calls(current);
                int threads =
                        calls.call(to -> to.begin(Request.UNLOAD).putInt(old.hostId)).getInt();
                keep(calls);
                if (changes == null && threads > old.threads) {
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
        free(old);
    }

    /** Frees a library that is no longer loaded, unless changes in progress may bring it back. */
    private void free(Loaded old) {
        accepted = null;
        if (changes == null || !changes.setAside(old)) {
            old.library.free();
        }
    }

    @Override
    public void beginChanges() {
        checkOpen();
        if (changes != null) {
            throw new IllegalStateException("changes are in progress; end them first");
        }
        keepState();
        HostProcess current = host();
        try {
            calls(current).call(to -> to.begin(Request.BEGIN_CHANGES));
        } catch (HostLost lost) {
            lose();
        }
        changes = new Changes(host, libraries, state.saved());
    }

    @Override
    public void endChanges(boolean keep) {
        checkOpen();
        if (changes == null) {
            throw new IllegalStateException("no changes are in progress; begin them first");
        }
        Changes ended = changes;
        changes = null;
        if (!keep) {
            accepted = null;
            state.set(ended.state());
            moves.clear();
            expectBuilding();
        }
        endInHost(ended, keep);
        for (Loaded gone : keep ? ended.unloaded() : ended.restore(libraries)) {
            gone.library.free();
        }
    }

    /**
     * Ends changes in the host in which they began. A host in which the changes did not begin is
     * replaced if they are undone.
     */
    private void endInHost(Changes ended, boolean keep) {
        if (host == null || host != ended.host()) {
            if (!keep) {
                lose();
            }
            return;
        }
        try {
            int threads =
                    calls(host)
                            .call(to -> to.begin(Request.END_CHANGES).putInt(keep ? 1 : 0))
                            .getInt();
            if (keep && ended.leftThreads(threads)) {
                lose(); // a thread that a library left might still write
            }
        } catch (HostLost | PhysicsException lost) {
            lose();
            config.log().log(
                    System.Logger.Level.WARNING,
                    lost.getMessage()
                            + " while libraries were replaced; the engine goes on in a new"
                            + " process");
        }
    }

    @Override
    public List<PhysicsLaw> laws() {
        checkOpen();
        List<PhysicsLaw> laws = new ArrayList<>();
        for (Loaded library : libraries) {
            laws.addAll(laws(library));
        }
        return laws;
    }

    /**
     * This method overrides the default, because it sends one request for this library only,
     * instead of one request for each library.
     */
    @Override
    public List<PhysicsLaw> laws(int libraryId) {
        checkOpen();
        List<PhysicsLaw> laws = new ArrayList<>();
        for (Loaded library : libraries) {
            if (library.id == libraryId) {
                laws.addAll(laws(library));
            }
        }
        return laws;
    }

    private List<PhysicsLaw> laws(Loaded library) {
        if (host != null) {
            try {
                library.read(calls(host).call(to -> to.begin(Request.LAWS).putInt(library.hostId)));
            } catch (HostLost lost) {
                lose();
            }
        }
        return library.laws();
    }

    @Override
    public boolean isApart(int libraryId) {
        return libraries.stream()
                .anyMatch(loaded -> loaded.id == libraryId && loaded.library.isApart());
    }

    @Override
    public void setInterval(int libraryId, int interval) {
        Loaded library = require(libraryId);
        ask(to -> to.begin(Request.SET_INTERVAL).putInt(library.hostId).putInt(interval));
        library.interval = interval;
    }

    @Override
    public List<double[]> ownValues(List<OwnColumn> columns, long row) {
        List<Loaded> owners = columns.stream().map(one -> require(one.libraryId())).toList();
        return Wire.ownValues(
                ask(to -> Wire.putOwn(to.begin(Request.SCRATCH_ROW), columns, owners, row)),
                columns);
    }

    @Override
    public void readTimes(long[] into) {
        checkOpen();
        int read = 0;
        for (int i = 0; i < libraries.size(); i++) { // an iterator would be allocated
            read = libraries.get(i).readTimes(into, read);
        }
    }

    @Override
    public long waitedNanos() {
        return waitedNanos;
    }

    @Override
    public void advance(double dt, int steps) {
        checkOpen();
        provider.checkArraysAlive();
        losses.beginAttempt();
        try {
            HostProcess current = host();
            if (provider.hasPending()) {
                provider.flush(calls(current));
            }
            provider.flushTouches();
            advance(current, dt, steps);
            if (building < BUILD_ADVANCES) {
                longestNanos = Math.max(current.spentNanos(), longestNanos - longestNanos / MEMORY);
            }
            building = Math.max(0, building - 1);
            losses.forget();
            ready.count(libraries);
        } catch (HostLost lost) {
            throw lost(lost);
        }
    }

    private void advance(HostProcess current, double dt, int steps) throws HostLost {
        try {
            long limit = frameLimit();
            current.begin(Request.ADVANCE).putDouble(dt).putInt(steps).putLong(limit);
            Mailbox reply;
            try {
                reply = current.call(limit, isApartWord, config.log());
            } catch (HostLost lost) {
                losses.spend(lost.spentNanos);
                throw lost;
            }
            waitedNanos = current.waitedNanos();
            requireOk(reply);
            boolean kept = state.keep(reply);
            for (int i = 0; i < libraries.size(); i++) { // an iterator would be allocated
                libraries.get(i).count(reply);
            }
            moves.clear();
            if (!kept) {
                Calls calls = calls(current);
                state.lend(calls);
                state.keep(calls);
            }
        } catch (RuntimeException failed) {
            losses.spend(current.spentNanos());
            if (failed instanceof PhysicsException refused
                    && (refused.libraryId() != 0 || refused.status() != Status.INTERNAL)) {
                throw refused;
            }
            // The host may have made the steps, but this process does not have the new state. The
            // host is therefore replaced.
            lose();
            throw new PhysicsException(
                    Status.ENGINE_LOST,
                    "the engine's process could not end the frame, and was replaced: "
                            + failed.getMessage());
        }
    }

    /** Returns whether a word that names the running law names a law in a sandbox. */
    private boolean isApartWord(long word) {
        int id = (int) (word >>> Integer.SIZE);
        for (int i = 0; i < libraries.size(); i++) { // an iterator would be allocated
            Loaded library = libraries.get(i);
            if (library.hostId == id && library.library.isApart()) {
                return true;
            }
        }
        return false;
    }

    private long frameLimit() {
        long usual =
                building > 0
                        ? losses.left(BUILD_NANOS)
                        : Math.min(GROWTH * longestNanos, BUILD_NANOS);
        return Math.max(usual, frameLimit.toNanos());
    }

    /** Sets the time limit of the next advances to that for building data structures. */
    void expectBuilding() {
        building = BUILD_ADVANCES;
    }

    @Override
    public void clearFault() {
        checkOpen();
        if (host != null) {
            ask(to -> to.begin(Request.CLEAR_FAULT));
        }
    }

    @Override
    public void moveRows(String kind, long[] rows) {
        checkOpen();
        RowMoves moved = new RowMoves(kind, rows);
        HostProcess current = host;
        if (current != null) {
            try {
                Calls calls = calls(current);
                if (provider.hasPending()) {
                    provider.flush(calls);
                }
                moved.send(calls);
            } catch (HostLost lost) {
                lose();
            }
        }
        moves.add(moved); // a new host must repeat these moves
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
        expectBuilding();
        KeptState.Saved known = accepted;
        try {
            withRetry(
                    calls -> {
                        state.load(saved, List.of(), calls);
                        keep(calls);
                        return calls;
                    });
            accepted = new KeptState.Saved(saved.clone(), state.steps());
        } catch (PhysicsException | IllegalStateException lost) {
            if (known == null || !Arrays.equals(known.bytes(), saved)) {
                throw lost;
            }
            lose();
            state.set(known); // the next host begins with this state
            moves.clear();
        }
    }

    private void keepState() {
        withRetry(
                calls -> {
                    keep(calls);
                    return calls;
                });
    }

    /** Keeps the state of the host, which already includes the moves of rows so far. */
    private void keep(Calls calls) throws HostLost {
        state.keep(calls);
        moves.clear();
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
        return Wire.ledger(
                ask(to -> Wire.putLedger(to.begin(Request.LEDGER), libraries)), libraries);
    }

    @Override
    public void close() {
        if (!closed) {
            closed = true;
            lose();
            ready.close();
            libraries.forEach(library -> library.library.free());
            libraries.clear();
            if (changes != null) {
                changes.unloaded().forEach(library -> library.library.free());
            }
            state.close();
        }
    }

    void checkOpen() {
        if (closed) {
            throw new IllegalStateException("the engine is closed");
        }
    }

    /** Sends a request that does not depend on the arrays; repeats it if the host was lost. */
    Mailbox ask(Consumer<HostProcess> request) {
        checkOpen();
        return withRetry(calls -> calls.call(request));
    }

    /** A function that sends requests to a host. It can be repeated. */
    private interface Exchange<T> {
        T with(Calls calls) throws HostLost;
    }

    /**
     * Makes an exchange with the host. Repeats the exchange if the host was lost while no law ran,
     * because another program may have killed the host. A host that did not answer in time is
     * replaced only once.
     */
    private <T> T withRetry(Exchange<T> exchange) {
        for (int tries = 1; ; tries++) {
            try {
                return exchange.with(connected());
            } catch (HostLost lost) {
                if (!lost.running.isEmpty() || tries >= (lost.isLate() ? 2 : STARTS)) {
                    throw lost(lost);
                }
                lose();
            }
        }
    }

    /** Returns a connection to the host, which has the present arrays. */
    private Calls connected() throws HostLost {
        Calls calls = calls(host());
        if (provider.hasPending()) {
            provider.flush(calls);
        }
        return calls;
    }

    private Calls calls(HostProcess to) {
        return calls(to, REQUEST_NANOS);
    }

    private Calls calls(HostProcess to, long limitNanos) {
        return request -> {
            request.accept(to);
            Mailbox reply;
            try {
                reply = to.call(Math.max(limitNanos, frameLimit.toNanos()), config.log());
            } catch (HostLost lost) {
                losses.spend(lost.spentNanos);
                throw lost;
            }
            requireOk(reply);
            return reply;
        };
    }

    private void requireOk(Mailbox reply) {
        if (reply.getInt() != 0) {
            throw losses.of(Wire.Failure.read(reply));
        }
    }

    /**
     * Returns the host. Starts a new host in the state that was kept if the host was lost.
     *
     * @throws IllegalStateException if no process can be started, or each new process ends at once;
     *     no law is the cause
     */
    private HostProcess host() {
        if (host != null && host.isAlive()) {
            return host;
        }
        lose();
        requireRested();
        long began = System.nanoTime();
        ReadyHost prepared = losses.isAlone() ? null : ready.take(libraries);
        if (prepared != null && isSetUp(prepared)) {
            host = prepared.host();
            expectBuilding();
            return host;
        }
        for (int starts = 1; ; starts++) {
            HostProcess fresh = hosts.take();
            try {
                setUp(fresh);
                host = fresh;
                lateStarts = 0;
                expectBuilding();
                // The next process is started last, because an earlier start would have delayed
                // this host.
                hosts.refill();
                return fresh;
            } catch (HostLost lost) {
                fresh.close();
                if (lost.isLate()) {
                    if (++lateStarts > 1) {
                        rest(System.nanoTime() - began);
                    }
                    throw new IllegalStateException(SILENT);
                }
                if (starts == STARTS) {
                    throw new IllegalStateException(
                            "the engine's process ended before it had the world ("
                                    + lost.getMessage()
                                    + "); the next frame starts another one");
                }
            } catch (RuntimeException failed) {
                fresh.close();
                if (starts == STARTS || !isEngineLost(failed)) {
                    throw failed;
                }
            }
        }
    }

    private void rest(long waitedNanos) {
        restsUntilNanos = System.nanoTime() + REST_AFTER_LATE_START * waitedNanos;
        isResting = true;
    }

    private void requireRested() {
        long left = restsUntilNanos - System.nanoTime();
        if (isResting && left > 0) {
            throw new IllegalStateException(SILENT);
        }
        isResting = false;
    }

    /** Returns whether a new host ended without a known cause while it loaded the libraries. */
    private static boolean isEngineLost(RuntimeException failed) {
        return failed instanceof PhysicsException lost && lost.status() == Status.ENGINE_LOST;
    }

    /**
     * Gives the columns and the state to a host that has loaded the libraries in advance. Returns
     * false if this fails for any reason. The host is then closed, and the same work in a new host
     * without libraries shows the reason.
     */
    private boolean isSetUp(ReadyHost prepared) {
        try {
            Calls calls = calls(prepared.host(), losses.left(REQUEST_NANOS));
            if (prepared.handOver(calls, libraries)) {
                provider.bindAll(calls);
                finishSetUp(calls);
                return true;
            }
        } catch (HostLost | RuntimeException failed) {
            config.log().log(
                    System.Logger.Level.WARNING,
                    "a process that was ready to replace the engine's process failed: "
                            + failed.getMessage());
        }
        prepared.close();
        return false;
    }

    private void setUp(HostProcess fresh) throws HostLost {
        calls(fresh, CREATE_NANOS)
                .create(config, losses.isAlone() ? 1 : config.threads(), prototype);
        Calls calls = calls(fresh);
        provider.bindAll(calls);
        for (Loaded library : libraries) {
            try {
                library.load(calls(fresh, losses.left(REQUEST_NANOS)));
                losses.spend(fresh.spentNanos());
            } catch (HostLost lost) {
                throw losses.blameForLoad(lost, library);
            }
        }
        finishSetUp(calls);
    }

    private void finishSetUp(Calls calls) throws HostLost {
        state.lend(calls);
        state.restore(calls);
        for (RowMoves moved : moves) {
            moved.send(calls);
        }
        if (ledger) {
            calls.call(to -> to.begin(Request.SET_LEDGER).putInt(1));
            if (state.steps() > 0) {
                config.log().log(
                        System.Logger.Level.WARNING,
                        "the ledger begins again, with the engine's new process");
            }
        }
    }

    /** Ends the use of the host, so that the next call starts a new host. */
    void lose() {
        if (host != null) {
            host.close();
            host = null;
            libraries.forEach(Loaded::keepCounts);
        }
    }

    private PhysicsException lost(HostLost lost) {
        lose();
        return losses.blame(lost);
    }
}
