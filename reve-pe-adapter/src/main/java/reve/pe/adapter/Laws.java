// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.frame.TimeBudget;
import reve.core.text.Suggestion;
import reve.core.world.Item;
import reve.core.world.RefusedSize;
import reve.core.world.World;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Status;

import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collections;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;
import java.util.function.Consumer;

/**
 * The loaded and the quarantined laws of a world. Each change raises a {@code law-loaded}, {@code
 * law-unloaded} or {@code fault} event. The events {@code law-unloaded} and {@code fault} contain
 * the number of calls of the library's laws, and their wall-clock time in milliseconds. For the
 * world's thread only.
 */
public final class Laws {
    private static final Logger LOG = LoggerFactory.getLogger("laws");

    /** Maximum number of attempts at a change, if the engine's process is lost during it. */
    private static final int MOST_TRIES = 10;

    /** Statuses that the engine throws if its process was lost. */
    private static final Set<Status> LOSSES = Set.of(Status.ENGINE_LOST, Status.LAW_CRASHED);

    private final World world;
    private final PhysicsEngine engine;
    private final LawEvents events;
    private final Map<Integer, LawLibrary> loaded = new LinkedHashMap<>();

    /** Ids of libraries that a laws folder may adopt if a file of the folder has their bytes. */
    private final Set<Integer> forFolder = new HashSet<>();

    private final Map<String, Quarantined> quarantined = new LinkedHashMap<>();
    private final List<Consumer<LawChange>> listeners = new ArrayList<>();

    /** The budgets by name of the library. A new version of a library has the same budget. */
    private final Map<String, TimeBudget> budgets = new HashMap<>();

    /** The versions that were replaced lately, by id of the library. */
    private final Map<Integer, Previous> previous = new HashMap<>();

    /** Number of frames in which a new version that fails is rolled back. */
    private long probation;

    private NameGuard guard = (name, file, library) -> {};
    private long version;
    private boolean unmoved;

    /**
     * The changes of the attempt in progress. Listeners receive these changes at the end of the
     * attempt.
     */
    private @Nullable List<LawChange> attempted;

    Laws(World world, PhysicsEngine engine) {
        this.world = world;
        this.engine = engine;
        this.events = new LawEvents(world, engine);
    }

    /**
     * A version that was replaced.
     *
     * @param untilFrame last frame in which this version is restored if the new version fails
     */
    private record Previous(LawLibrary library, long untilFrame) {}

    /**
     * Sets the number of frames after a replacement in which a failure of the new version restores
     * the old version. The initial number is 0. A replay must not set it, because journals contain
     * the restored versions.
     */
    public void keepPreviousFor(long frames) {
        probation = frames;
    }

    /**
     * Activates a library, at any time except in the frame's phase PHYSICS. Its laws act from the
     * next step on.
     *
     * @param frame the frame in progress, 0 before the first
     * @param parameters values, keyed by {@code parameter} or {@code law.parameter}
     * @return id of the library, for {@link #unload}
     * @throws PhysicsException if the engine refuses it, or a library with the same bytes is
     *     quarantined; nothing has changed in this case, and the caller still owns the library
     */
    public int load(long frame, PreparedLibrary prepared, Map<String, Double> parameters) {
        return load(frame, prepared, parameters, name -> {});
    }

    /**
     * Activates a library that was read from a file. The {@link NameGuard} may refuse the library's
     * name, or that of one of its laws.
     */
    public int load(
            long frame, PreparedLibrary prepared, Map<String, Double> parameters, Path file) {
        byte[] bytes = prepared.bytes();
        return load(frame, prepared, parameters, name -> guard.check(name, file, bytes));
    }

    /** Sets the guard that may refuse names of libraries and of their laws. */
    public void guardNames(NameGuard newGuard) {
        guard = newGuard;
    }

    /** A check that can refuse libraries by their name, or by the names of their laws. */
    public interface NameGuard {
        /**
         * Checks the name of a library or of one of its laws.
         *
         * @throws PhysicsException if the library may not have this name
         */
        void check(String name, Path file, byte[] library);
    }

    private int load(
            long frame,
            PreparedLibrary prepared,
            Map<String, Double> parameters,
            Consumer<String> names) {
        refuseQuarantined(prepared);
        names.accept(prepared.name());
        int id = engine.loadPhysicsLaw(prepared, parameters);
        try {
            lawsOf(id).stream().map(PhysicsLaw::name).forEach(names);
        } catch (PhysicsException refused) {
            engine.unloadPhysicsLaw(id);
            throw refused;
        }
        LawLibrary added =
                LawLibrary.of(prepared, parameters)
                        .withBudget(Optional.ofNullable(budgets.get(prepared.name())));
        loaded.put(id, added);
        version++;
        tell(new LawChange.Loaded(added));
        events.loaded(frame, added, id);
        return id;
    }

    private void refuseQuarantined(PreparedLibrary prepared) {
        Quarantined reason = quarantined.get(prepared.sha256());
        if (reason != null) {
            throw new PhysicsException(
                    reason.status(),
                    "law library '"
                            + prepared.name()
                            + "' is in quarantine since frame "
                            + reason.frame()
                            + ": "
                            + reason.message());
        }
    }

    /** Returns the laws of a loaded library. */
    List<PhysicsLaw> lawsOf(int libraryId) {
        return engine.laws(libraryId);
    }

    /**
     * Prepares and activates a library in one call, which takes milliseconds; for the start of a
     * world.
     */
    public int load(long frame, String library, Map<String, Double> parameters) {
        try (PreparedLibrary prepared = engine.prepare(library)) {
            return load(frame, prepared, parameters);
        }
    }

    /** Returns whether a loaded library runs in a sandbox. */
    public boolean isApart(int libraryId) {
        return engine.isApart(libraryId);
    }

    /**
     * Unloads a library outside PHYSICS.
     *
     * @throws IllegalArgumentException if it is not loaded
     */
    public void unload(long frame, int libraryId) {
        LawLibrary library = loaded.get(libraryId);
        if (library == null) {
            throw new IllegalArgumentException(
                    "law library " + libraryId + " is not loaded; loaded are " + loaded.keySet());
        }
        Map<String, Object> fields = events.fieldsWithCost(library, libraryId);
        tell(new LawChange.Unloaded(drop(libraryId)));
        events.unloaded(frame, fields);
    }

    /**
     * Changes parameters of a loaded library, outside PHYSICS. The engine creates the library again
     * at the same place; its laws keep their SCRATCH memory.
     *
     * @param changed values, keyed by {@code parameter} or {@code law.parameter}; other parameters
     *     keep their values
     * @throws IllegalArgumentException if no library has the name
     * @throws PhysicsException if the engine refuses a parameter; then nothing changed
     */
    public void setParameters(long frame, String library, Map<String, Double> changed) {
        setParameters(frame, placeOf(library), changed);
    }

    /** Returns the place of a library in the order of loading. */
    private int placeOf(String library) {
        int place = libraries().stream().map(LawLibrary::name).toList().indexOf(library);
        if (place < 0) {
            throw new IllegalArgumentException(notLoaded(library));
        }
        return place;
    }

    /**
     * Returns a message about a library that is not loaded. It suggests a similar name, or lists
     * the names of the loaded libraries.
     */
    public String notLoaded(String library) {
        List<String> names = libraries().stream().map(LawLibrary::name).toList();
        String near = Suggestion.of(library, names);
        return "no library \""
                + library
                + "\" is loaded"
                + (near.isEmpty() && !names.isEmpty()
                        ? "; loaded are " + String.join(", ", names)
                        : near);
    }

    private void setParameters(long frame, int place, Map<String, Double> changed) {
        int id = idAt(place);
        LawLibrary wanted = Objects.requireNonNull(loaded.get(id)).with(changed);
        attempt(
                made -> {
                    try (PreparedLibrary again = engine.prepare(wanted.bytes())) {
                        exchange(frame, id, again, wanted);
                    }
                    engine.setInterval(id, wanted.interval());
                    tell(new LawChange.ParametersSet(place, Map.copyOf(changed)));
                });
    }

    /** Replaces a loaded library in the engine, and reports it. */
    private void exchange(long frame, int id, PreparedLibrary prepared, LawLibrary by) {
        LawLibrary old = Objects.requireNonNull(loaded.get(id));
        Map<String, Object> fields = events.fieldsWithCost(old, id);
        engine.replacePhysicsLaw(id, prepared, by.parameters());
        loaded.put(id, by);
        version++;
        events.unloaded(frame, fields);
        events.loaded(frame, by, id);
    }

    /**
     * Sets the computing time that the laws of a library may take in a frame; later versions of the
     * library keep this budget. Resets the interval of the laws to 1, so that they act in every
     * step. Must not be called in the phase PHYSICS. See {@link PhysicsAdapter#enforceBudgets}.
     *
     * @throws IllegalArgumentException if no library has the name
     * @throws PhysicsException if the laws cannot skip steps as the budget says; then nothing
     *     changed
     */
    public void setBudget(String library, Optional<TimeBudget> budget) {
        int place = placeOf(library);
        int id = idAt(place);
        if (budget.isPresent() && budget.get().response() == TimeBudget.Response.SKIP_STEPS) {
            engine.setInterval(id, budget.get().every()); // refuses laws that cannot skip steps
        }
        apply(id, budget, 1);
        tell(new LawChange.BudgetSet(place, budget));
    }

    /**
     * Makes the laws of a library act in every n-th step only. Must not be called in the phase
     * PHYSICS.
     */
    void setInterval(int libraryId, int interval) {
        LawLibrary library = loaded.get(libraryId);
        if (library != null && library.interval() != interval) {
            apply(libraryId, library.budget(), interval);
            tell(
                    new LawChange.IntervalSet(
                            List.copyOf(loaded.keySet()).indexOf(libraryId), interval));
        }
    }

    private void apply(int libraryId, Optional<TimeBudget> budget, int interval) {
        LawLibrary library = Objects.requireNonNull(loaded.get(libraryId));
        engine.setInterval(libraryId, interval);
        loaded.put(libraryId, library.withBudget(budget).withInterval(interval));
        budgets.remove(library.name());
        budget.ifPresent(some -> budgets.put(library.name(), some));
        version++;
    }

    /**
     * Replaces a loaded library between two frames, outside PHYSICS. The new library takes the id
     * and the place of the old library, and the budget of its name. It also takes the SCRATCH
     * memory of the old laws, where the layout is the same. Nothing changes if it is refused or
     * fails.
     *
     * @param libraryId id of the loaded library
     * @param check check of the new laws, which may throw PhysicsException
     * @throws PhysicsException if the engine, the {@link NameGuard} or {@code check} refuses the
     *     library, or it is quarantined; the caller then closes {@code prepared}
     */
    public void replace(
            long frame,
            int libraryId,
            PreparedLibrary prepared,
            Map<String, Double> parameters,
            Path file,
            Consumer<List<PhysicsLaw>> check) {
        byte[] bytes = prepared.bytes();
        attempt(
                made -> {
                    if (!loaded.containsKey(libraryId)) {
                        throw new PhysicsException(
                                Status.NOT_FOUND, "the library was unloaded meanwhile");
                    }
                    refuseQuarantined(prepared);
                    guard.check(prepared.name(), file, bytes);
                    replaceBy(
                            frame,
                            libraryId,
                            prepared,
                            LawLibrary.of(prepared, parameters)
                                    .withBudget(Optional.ofNullable(budgets.get(prepared.name()))));
                    List<PhysicsLaw> laws = lawsOf(libraryId);
                    laws.forEach(law -> guard.check(law.name(), file, bytes));
                    check.accept(laws);
                });
    }

    /**
     * Returns a new version of a loaded library, which has not replaced the library yet. Arguments
     * are those of {@link #replace}. The new version owns {@code prepared}.
     */
    public NewVersion newVersion(
            int libraryId,
            PreparedLibrary prepared,
            Map<String, Double> parameters,
            Path file,
            Consumer<List<PhysicsLaw>> check) {
        return new NewVersion(
                libraryId,
                LawLibrary.of(prepared, parameters)
                        .withBudget(Optional.ofNullable(budgets.get(prepared.name()))),
                file.getFileName().toString(),
                false,
                frame -> replace(frame, libraryId, prepared, parameters, file, check),
                NewVersion.Ended.UNHEARD,
                prepared::close);
    }

    /**
     * Returns a version of a loaded library with other parameters, which has not replaced the
     * library yet. Arguments are those of {@link #setParameters(long, String, Map)}.
     *
     * @throws IllegalArgumentException if no library has the name
     */
    public NewVersion newParameters(String library, Map<String, Double> changed) {
        int id = idAt(placeOf(library));
        LawLibrary present = Objects.requireNonNull(loaded.get(id));
        return new NewVersion(
                id,
                present.with(changed),
                library,
                true,
                frame -> setParameters(frame, placeOf(library), changed),
                NewVersion.Ended.UNHEARD,
                () -> {});
    }

    private void replaceBy(long frame, int id, PreparedLibrary prepared, LawLibrary by) {
        LawLibrary old = Objects.requireNonNull(loaded.get(id));
        exchange(frame, id, prepared, by);
        if (probation > 0) {
            previous.put(id, new Previous(old, frame + probation));
        }
        tell(new LawChange.Replaced(List.copyOf(loaded.keySet()).indexOf(id), by));
    }

    /**
     * A function that loads and unloads libraries. Listeners receive only the changes that remain
     * at its end.
     */
    private interface Attempt {
        /**
         * Makes the changes.
         *
         * @param made receives the changes
         */
        void make(List<LawChange> made);
    }

    /**
     * Runs a function of changes as a whole. All its changes are undone if one of them is refused.
     */
    private void attempt(Attempt attempt) {
        Map<Integer, LawLibrary> before = new LinkedHashMap<>(loaded);
        Set<Integer> adoptable = Set.copyOf(forFolder);
        Map<String, Quarantined> out = new LinkedHashMap<>(quarantined);
        Map<String, TimeBudget> allowed = new HashMap<>(budgets);
        boolean wasUnmoved = unmoved;
        List<LawChange> made = new ArrayList<>();
        engine.beginChanges();
        attempted = made;
        events.hold();
        boolean whole = false;
        try {
            attempt.make(made);
            whole = true;
        } finally {
            attempted = null;
            if (!whole) {
                events.drop();
                put(loaded, before);
                put(quarantined, out);
                put(budgets, allowed);
                forFolder.clear();
                forFolder.addAll(adoptable);
                unmoved = wasUnmoved;
                version++;
            }
            engine.endChanges(whole);
        }
        events.release();
        made.forEach(this::tell);
    }

    private static <K, V> void put(Map<K, V> map, Map<K, V> content) {
        map.clear();
        map.putAll(content);
    }

    /** Returns whether the library is loaded; false after it was unloaded or quarantined. */
    public boolean isLoaded(int libraryId) {
        return loaded.containsKey(libraryId);
    }

    /** Returns the loaded laws with their cost so far, in the order of loading. */
    public List<PhysicsLaw> loaded() {
        return engine.laws();
    }

    /** Returns the quarantined libraries, in the order of their failures. */
    public List<Quarantined> quarantined() {
        return List.copyOf(quarantined.values());
    }

    /** Permits a quarantined library's bytes again. Returns false if they were not quarantined. */
    public boolean release(String sha256) {
        if (quarantined.remove(sha256) == null) {
            return false;
        }
        tell(new LawChange.Released(sha256));
        return true;
    }

    /** Returns the loaded libraries by their ids, in the order of loading. */
    public Map<Integer, LawLibrary> byId() {
        return Collections.unmodifiableMap(new LinkedHashMap<>(loaded));
    }

    /** Returns the library that was loaded last, with its id. */
    Optional<Map.Entry<Integer, LawLibrary>> latest() {
        return loaded.entrySet().stream().reduce((earlier, later) -> later);
    }

    /**
     * Returns the name of the library that was loaded last.
     *
     * @throws java.util.NoSuchElementException if none is loaded
     */
    public String latestName() {
        return latest().orElseThrow().getValue().name();
    }

    /** Returns the loaded libraries, in the order of loading. */
    public List<LawLibrary> libraries() {
        return List.copyOf(loaded.values());
    }

    /**
     * Permits a laws folder to adopt a loaded library if a file of the folder has the same bytes.
     * This file is then not loaded again, and the library is unloaded when the file is removed.
     */
    public void leaveToFolder(int libraryId) {
        forFolder.add(libraryId);
    }

    /** Returns the ids of the loaded libraries with these bytes that a laws folder may adopt. */
    List<Integer> forFolder(String sha256) {
        return loaded.entrySet().stream()
                .filter(library -> library.getValue().sha256().equals(sha256))
                .map(Map.Entry::getKey)
                .filter(forFolder::contains)
                .toList();
    }

    /**
     * Returns the ids of the loaded libraries of this name that a laws folder may adopt and that
     * are not in {@code owned}.
     */
    List<Integer> forFolderNamed(String name, Set<Integer> owned) {
        return loaded.entrySet().stream()
                .filter(library -> library.getValue().name().equals(name))
                .map(Map.Entry::getKey)
                .filter(id -> forFolder.contains(id) && !owned.contains(id))
                .toList();
    }

    /** Adds a listener for all later changes. */
    public void addListener(Consumer<LawChange> listener) {
        listeners.add(listener);
    }

    /** Removes a listener. */
    public void removeListener(Consumer<LawChange> listener) {
        listeners.remove(listener);
    }

    private void tell(LawChange change) {
        if (attempted != null) {
            attempted.add(change);
            return;
        }
        listeners.forEach(listener -> listener.accept(change));
    }

    /**
     * Repeats a change of another world with the same laws, for example from a journal. A library
     * that failed in the other world is removed in this world without a failure.
     *
     * @throws PhysicsException if the engine refuses a library
     * @throws IllegalArgumentException if there is no library at the index
     */
    public void apply(long frame, LawChange change) {
        switch (change) {
            case LawChange.Loaded added -> {
                // Journals of earlier versions of this program contain no change Released before a
                // load. The quarantine of the library is therefore ended here.
                quarantined.remove(added.library().sha256());
                try (PreparedLibrary prepared = engine.prepare(added.library().bytes())) {
                    warnOfOtherVersions(added.library(), prepared);
                    int id = load(frame, prepared, added.library().parameters());
                    apply(id, added.library().budget(), added.library().interval());
                    leaveToFolder(id);
                }
            }
            case LawChange.Replaced replaced -> {
                int id = idAt(replaced.place());
                try (PreparedLibrary prepared = engine.prepare(replaced.library().bytes())) {
                    warnOfOtherVersions(replaced.library(), prepared);
                    replaceBy(
                            frame,
                            id,
                            prepared,
                            replaced.library().withVersions(prepared.versions()));
                }
                apply(id, replaced.library().budget(), replaced.library().interval());
                leaveToFolder(id);
            }
            case LawChange.Unloaded gone -> unload(frame, idAt(gone.place()));
            case LawChange.ParametersSet set -> {
                idAt(set.place());
                setParameters(frame, set.place(), set.changed());
            }
            case LawChange.BudgetSet set -> {
                idAt(set.place());
                setBudget(libraries().get(set.place()).name(), set.budget());
            }
            case LawChange.IntervalSet set -> setInterval(idAt(set.place()), set.interval());
            case LawChange.Failed failed -> {
                unload(frame, idAt(failed.place()));
                quarantined.put(failed.reason().sha256(), failed.reason());
            }
            case LawChange.RolledBack back -> {
                int id = idAt(back.place());
                Map<String, Object> fields =
                        events.fieldsWithCost(Objects.requireNonNull(loaded.get(id)), id);
                putBack(id, back.library());
                quarantined.put(back.reason().sha256(), back.reason());
                leaveToFolder(id);
                tell(change);
                events.unloaded(frame, fields);
                events.loaded(frame, back.library(), id);
            }
            case LawChange.Arrested arrested ->
                    world.find(arrested.item()).ifPresent(world.arrests()::arrest);
            case LawChange.Released released -> release(released.sha256());
            case LawChange.Unmoved _ -> unmoved = true;
        }
    }

    /**
     * Warns if the recorded library used other versions than this process. Recordings of earlier
     * versions of this program contain no versions.
     */
    private static void warnOfOtherVersions(LawLibrary recorded, PreparedLibrary here) {
        if (!recorded.versions().isEmpty() && !recorded.versions().equals(here.versions())) {
            LOG.warn(
                    "law {} was recorded with {}, and here it runs with {}: its results may have"
                            + " other bits; install the recorded versions to get the same bits",
                    recorded.name(),
                    recorded.versions(),
                    here.versions());
        }
    }

    /** Reports to listeners that the laws did not act in this frame, because PHYSICS failed. */
    void failed() {
        tell(new LawChange.Unmoved());
    }

    /**
     * Returns whether a {@link LawChange.Unmoved} was applied, so that the laws must not act in
     * this frame. Resets this state.
     */
    boolean takeUnmoved() {
        boolean taken = unmoved;
        unmoved = false;
        return taken;
    }

    /**
     * Restores the loaded and the quarantined libraries and the engine's state from an image. Then
     * runs {@code columns}, which restores the columns of the world. Nothing has changed if one of
     * these actions fails.
     *
     * @throws PhysicsException if the engine refuses a library or the state, or its process is lost
     *     too often
     * @throws IllegalStateException if no process can be started for the engine
     */
    void restore(long frame, PhysicsImage image, Runnable columns) {
        attempt(
                made -> {
                    restore(frame, image.libraries(), image.quarantined());
                    previous.clear();
                    engine.loadState(image.engineState()); // this call refuses a damaged state
                    columns.run();
                });
    }

    /**
     * Loads and unloads libraries until exactly the wanted libraries are loaded, in this order. A
     * new process continues if the engine's process is lost meanwhile.
     *
     * @throws PhysicsException if the engine refuses a library, or its process is lost too often
     */
    private void restore(long frame, List<LawLibrary> wanted, List<Quarantined> out) {
        for (int tries = 1; ; tries++) {
            try {
                restoreOnce(frame, wanted, out);
                return;
            } catch (PhysicsException refused) {
                if (tries == MOST_TRIES || !LOSSES.contains(refused.status())) {
                    throw refused;
                }
            }
        }
    }

    private void restoreOnce(long frame, List<LawLibrary> wanted, List<Quarantined> out) {
        List<LawLibrary> present = libraries();
        int same = 0;
        while (same < Math.min(present.size(), wanted.size())
                && present.get(same).isSame(wanted.get(same))) {
            same++;
        }
        for (int id : List.copyOf(loaded.keySet()).subList(same, loaded.size())) {
            unload(frame, id);
        }
        List<Integer> kept = List.copyOf(loaded.keySet());
        for (int place = 0; place < same; place++) {
            LawLibrary library = wanted.get(place);
            if (library.interval() != present.get(place).interval()
                    || !library.budget().equals(present.get(place).budget())) {
                apply(kept.get(place), library.budget(), library.interval());
            }
        }
        quarantined.clear();
        unmoved = false;
        for (LawLibrary library : wanted.subList(same, wanted.size())) {
            apply(frame, new LawChange.Loaded(library));
        }
        out.forEach(reason -> quarantined.put(reason.sha256(), reason));
    }

    private int idAt(int place) {
        if (place < 0 || place >= loaded.size()) {
            throw new IllegalArgumentException(
                    "there is no law library in place "
                            + place
                            + ", "
                            + loaded.size()
                            + " are loaded");
        }
        return List.copyOf(loaded.keySet()).get(place);
    }

    /** Returns a counter that increases whenever a library is loaded or unloaded. */
    long version() {
        return version;
    }

    /**
     * Quarantines the library that caused a step's failure. Unloads the library, or restores the
     * version that it replaced recently.
     *
     * @param item item at whose row the law failed, if known
     * @return true if the previous version was restored
     * @throws PhysicsException the failure itself, if no loaded library caused it
     */
    boolean quarantine(long frame, PhysicsException failure, Optional<Item> item) {
        LawLibrary library = loaded.get(failure.libraryId());
        if (library == null) {
            throw failure;
        }
        Map<String, Object> fields = events.fieldsWithCost(library, failure.libraryId());
        Quarantined reason =
                new Quarantined(
                        library.sha256(),
                        library.name(),
                        frame,
                        failure.status(),
                        String.valueOf(failure.getMessage()));
        quarantined.put(library.sha256(), reason);
        LawEvents.addPlace(fields, failure);
        item.ifPresent(i -> fields.put("item", i.name()));
        Optional<LawLibrary> back = cameBack(frame, failure.libraryId());
        back.ifPresent(old -> fields.put("rolledBackTo", old.sha256()));
        if (back.isEmpty()) {
            tell(new LawChange.Failed(drop(failure.libraryId()), reason));
        } else {
            tell(
                    new LawChange.RolledBack(
                            List.copyOf(loaded.keySet()).indexOf(failure.libraryId()),
                            reason,
                            back.get()));
        }
        events.fault(frame, fields, failure);
        back.ifPresent(old -> events.loaded(frame, old, failure.libraryId()));
        return back.isPresent();
    }

    /**
     * Reports a size that a body's shape cannot have.
     *
     * @param names names of the laws that write sizes
     */
    void refusedSize(long frame, String names, RefusedSize refused) {
        events.refusedSize(frame, names, refused);
    }

    /**
     * Restores the version that the library replaced recently, and returns this version. Returns
     * empty if there is no such version, or it cannot be loaded.
     */
    private Optional<LawLibrary> cameBack(long frame, int libraryId) {
        Previous old = previous.remove(libraryId);
        if (old == null
                || frame > old.untilFrame
                || quarantined.containsKey(old.library.sha256())) {
            return Optional.empty();
        }
        try {
            putBack(libraryId, old.library);
            return Optional.of(old.library);
        } catch (PhysicsException | IllegalStateException refused) {
            return Optional.empty(); // the library is unloaded instead
        }
    }

    /**
     * Ends a library between two frames, without quarantine. A version that the library replaced
     * recently takes its place. Without such a version, the library is unloaded.
     *
     * @return the restored version, if there is one
     */
    Optional<LawLibrary> retire(long frame, int libraryId) {
        Previous last = previous.remove(libraryId);
        if (last != null
                && frame <= last.untilFrame
                && !quarantined.containsKey(last.library.sha256())) {
            Optional<TimeBudget> budget = Optional.ofNullable(budgets.get(last.library.name()));
            try (PreparedLibrary prepared = engine.prepare(last.library.bytes())) {
                LawLibrary old = last.library.withBudget(budget).withInterval(1);
                exchange(frame, libraryId, prepared, old);
                tell(new LawChange.Replaced(List.copyOf(loaded.keySet()).indexOf(libraryId), old));
                return Optional.of(old);
            } catch (PhysicsException refused) {
                // The exception is ignored. The replaced version cannot be loaded, so the library
                // is unloaded instead.
            }
        }
        unload(frame, libraryId);
        return Optional.empty();
    }

    private void putBack(int libraryId, LawLibrary old) {
        try (PreparedLibrary prepared = engine.prepare(old.bytes())) {
            engine.replacePhysicsLaw(libraryId, prepared, old.parameters());
        }
        loaded.put(libraryId, old);
        apply(libraryId, old.budget(), old.interval());
    }

    /**
     * Reports that an item was arrested, so that laws do not act on it, because a law failed at it.
     * The law stays loaded.
     */
    void arrested(long frame, Item item, PhysicsException failure) {
        tell(new LawChange.Arrested(item.id()));
        LawLibrary library = loaded.get(failure.libraryId());
        Map<String, Object> fields = LawEvents.fields(library);
        LawEvents.addPlace(fields, failure);
        fields.put("item", item.name());
        fields.put("arrested", true);
        events.fault(frame, fields, failure);
    }

    /** Reports that the engine refused a call or a law failed. */
    void reportFault(long frame, Map<String, Object> fields, PhysicsException failure) {
        events.fault(frame, fields, failure);
    }

    /** Returns the reports of this world's laws. */
    LawEvents events() {
        return events;
    }

    /** Removes a library, and returns the index that it had in the order of loading. */
    private int drop(int libraryId) {
        engine.unloadPhysicsLaw(libraryId);
        int place = List.copyOf(loaded.keySet()).indexOf(libraryId);
        loaded.remove(libraryId);
        previous.remove(libraryId);
        forFolder.remove(libraryId);
        version++;
        return place;
    }
}
