// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.frame.FrameEvent;
import reve.core.world.ItemId;
import reve.core.world.WorldEvent;
import reve.pe.LedgerLine;
import reve.pe.PhysicsException;
import reve.pe.Status;
import reve.pe.adapter.LawChange;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.Laws;
import reve.pe.adapter.NewVersion;
import reve.worlds.journal.SimulationImage;

import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.atomic.AtomicLong;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * A copy of a world, with its own engine, in which new versions of laws act on the same frames. The
 * copy runs on its own thread and may lag behind the world. The world never waits for it.
 */
final class Shadow implements AutoCloseable {
    /** Maximum memory of waiting frames, for all copies of this process together [bytes]. */
    private static final long MOST_WAITING_BYTES =
            Math.min(256L << 20, Runtime.getRuntime().maxMemory() / 8);

    private static final AtomicLong WAITING_BYTES = new AtomicLong();

    private final Simulation of;
    private final List<NewVersion> versions;

    /** Changes that load the new versions into the copy, one for each version. */
    private final List<LawChange> changes;

    private final SwapPlan plan;
    private final int frames;
    private final BlockingQueue<ShadowFrame> waiting = new LinkedBlockingQueue<>();
    private final Thread thread;
    private volatile @Nullable SimulationImage image;
    private volatile Progress progress = Progress.NONE;
    private volatile @Nullable Verdict verdict;
    private volatile boolean cancelled;

    /** The failure that the copy has found; null if none. Only the copy's thread uses the field. */
    private @Nullable PhysicsException failure;

    /**
     * The items that were arrested in the copy in this frame. An arrested item is at rest and
     * immovable, because a law failed at it. Only the copy's thread uses the field.
     */
    private final Set<ItemId> arrests = new LinkedHashSet<>();

    /**
     * The progress of a trial.
     *
     * @param frames number of frames that the copy has made
     * @param energy the energy that the laws have added to the copy's bodies [J], and its limit;
     *     null if the energy is not known
     */
    record Progress(
            int frames,
            ShadowDivergence divergence,
            @Nullable Double energy,
            @Nullable Double mostEnergy) {
        static final Progress NONE = new Progress(0, ShadowDivergence.NONE, null, null);
    }

    /**
     * The result of a trial.
     *
     * @param refused the refused versions, each with the reason; the other versions may take over
     */
    record Verdict(Map<NewVersion, PhysicsException> refused) {}

    /**
     * Starts the copy.
     *
     * @param image image of the world, which the copy closes
     * @param changes changes that load the new versions into an equal world, in the order of {@code
     *     versions}
     * @param frames number of frames of the trial
     */
    Shadow(
            Simulation of,
            SimulationImage image,
            List<NewVersion> versions,
            List<LawChange> changes,
            SwapPlan plan,
            int frames) {
        this.of = of;
        this.image = image;
        this.versions = List.copyOf(versions);
        this.changes = List.copyOf(changes);
        this.plan = plan;
        this.frames = frames;
        thread =
                Thread.ofPlatform()
                        .daemon()
                        .name("shadow of " + names().collect(Collectors.joining(", ")))
                        .start(this::run);
    }

    private Stream<String> names() {
        return versions.stream().map(version -> version.library().name());
    }

    /**
     * Passes the next frame to the copy. For the world's thread only.
     *
     * @return false if too many frames wait already
     */
    boolean give(ShadowFrame frame) {
        if (!hasRoom(frame.bytes() - frame.rowBytes())) {
            return false;
        }
        WAITING_BYTES.addAndGet(frame.bytes());
        waiting.add(frame);
        return true;
    }

    /** Returns whether more bytes may wait. For any thread. */
    static boolean hasRoom(long bytes) {
        return WAITING_BYTES.get() + bytes <= MOST_WAITING_BYTES;
    }

    /** Returns the progress of the copy. For any thread. */
    Progress progress() {
        return progress;
    }

    /**
     * Returns the result of the trial; empty until the copy has made all frames or has failed. For
     * any thread.
     */
    Optional<Verdict> verdict() {
        return Optional.ofNullable(verdict);
    }

    /** Ends the copy as soon as its present frame is done. Does not wait for this end. */
    @Override
    public void close() {
        cancelled = true;
        thread.interrupt();
        for (ShadowFrame frame = waiting.poll(); frame != null; frame = waiting.poll()) {
            WAITING_BYTES.addAndGet(-frame.bytes());
        }
    }

    /** Waits until the copy has ended or the time has passed [ms]. */
    void join(long milliseconds) throws InterruptedException {
        thread.join(milliseconds);
    }

    boolean isAlive() {
        return thread.isAlive();
    }

    private void run() {
        Verdict found;
        try {
            found = tried();
        } catch (InterruptedException stopped) {
            return;
        } catch (PhysicsException refused) {
            found = all(refused);
        } catch (RuntimeException | LinkageError | OutOfMemoryError failed) {
            found = all(new PhysicsException(Status.INTERNAL, "its shadow failed: " + failed));
        } finally {
            SimulationImage unused = image;
            if (unused != null) {
                unused.close();
            }
        }
        if (!cancelled) {
            verdict = found;
        }
    }

    private Verdict tried() throws InterruptedException {
        for (NewVersion version : versions) {
            checkText(version);
        }
        SimulationImage from = image;
        if (from == null || cancelled) {
            throw new InterruptedException();
        }
        try (Simulation copy = of.shadow(from)) {
            from.close();
            image = null;
            copy.physics().laws().addListener(this::note);
            copy.onPublish("shadow", this::noteBudgets);
            Map<NewVersion, PhysicsException> refused = loaded(copy);
            if (refused.size() < versions.size()) {
                make(copy);
            }
            return new Verdict(refused);
        }
    }

    /** Refuses a text that is not valid. The reason lists all its problems with their lines. */
    private void checkText(NewVersion version) {
        LawLibrary library = version.library();
        if (!version.parametersOnly() && library.isText()) {
            String problems = of.engine().checkText(version.source(), library.bytes());
            if (!problems.isEmpty()) {
                throw new PhysicsException(Status.LIBRARY_LOAD_FAILED, problems);
            }
        }
    }

    /**
     * Loads the new versions into the copy. A refused version is tried again after the other
     * versions, because it may depend on them.
     *
     * @return the refused versions, each with the reason
     */
    private Map<NewVersion, PhysicsException> loaded(Simulation copy) {
        Laws laws = copy.physics().laws();
        long frame = copy.loop().frame() + 1;
        dropOtherBudgets(laws, frame);
        Map<NewVersion, PhysicsException> refused = new LinkedHashMap<>();
        for (int i = 0; i < versions.size(); i++) {
            try {
                laws.apply(frame, changes.get(i));
            } catch (PhysicsException why) {
                refused.put(versions.get(i), why);
            }
        }
        if (versions.size() > 1) {
            for (NewVersion again : List.copyOf(refused.keySet())) {
                try {
                    laws.apply(frame, changes.get(versions.indexOf(again)));
                    refused.remove(again);
                } catch (PhysicsException why) {
                    refused.put(again, why);
                }
            }
        }
        return refused;
    }

    /**
     * Removes the budgets of all libraries except the new versions, because those budgets apply
     * only in the world.
     */
    private void dropOtherBudgets(Laws laws, long frame) {
        Set<String> tried = names().collect(Collectors.toSet());
        List<LawLibrary> present = laws.libraries();
        for (int place = 0; place < present.size(); place++) {
            LawLibrary library = present.get(place);
            if (library.budget().isPresent() && !tried.contains(library.name())) {
                laws.apply(frame, new LawChange.BudgetSet(place, Optional.empty()));
                laws.apply(frame, new LawChange.IntervalSet(place, library.interval()));
            }
        }
    }

    private void make(Simulation copy) throws InterruptedException {
        copy.physics().enforceBudgets(true);
        ShadowEnergy energy = new ShadowEnergy(copy.world(), copy.physics(), plan.energyLimit());
        ShadowClaims claims = new ShadowClaims(copy.world(), tried(copy.physics().laws()));
        for (int made = 1; made <= frames; made++) {
            ShadowFrame frame = waiting.take();
            WAITING_BYTES.addAndGet(-frame.bytes());
            if (cancelled) {
                throw new InterruptedException();
            }
            ShadowFrame.repeat(copy.world(), frame.early());
            energy.before();
            copy.loop().step();
            failAtArrests(copy, frame);
            throwFailure(made);
            ShadowFrame.repeat(copy.world(), frame.late());
            List<LedgerLine> ledger = energy.ledger();
            energy.after(frame, ledger);
            progress =
                    new Progress(
                            made,
                            frame.hasRows()
                                    ? ShadowDivergence.of(copy.world(), frame)
                                    : progress.divergence(),
                            energy.gain().orElse(null),
                            energy.gain().isPresent() ? energy.mostGain() : null);
            Optional<String> wrong =
                    claims.broken(copy.engine().laws(), ledger)
                            .or(() -> frame.hasRows() ? energy.excess() : Optional.empty());
            if (wrong.isPresent()) {
                throw refusal(Status.LAW_MISBEHAVED, made, wrong.get());
            }
        }
    }

    /** Returns the ids of the new versions in the copy. */
    private Set<Integer> tried(Laws laws) {
        Set<String> tried = names().collect(Collectors.toSet());
        return laws.byId().entrySet().stream()
                .filter(loaded -> tried.contains(loaded.getValue().name()))
                .map(Map.Entry::getKey)
                .collect(Collectors.toSet());
    }

    /**
     * Fails if an item was arrested in the copy but not in the world. The cause is an action or an
     * edit, and not the new version, if the world has arrested the item in the same frame.
     */
    private void failAtArrests(Simulation copy, ShadowFrame frame) {
        arrests.stream()
                .filter(item -> !frame.arrested().contains(item))
                .findFirst()
                .ifPresent(
                        item ->
                                fail(
                                        Status.LAW_FAILED,
                                        "a law failed at the item "
                                                + copy.world()
                                                        .find(item)
                                                        .map(found -> found.name())
                                                        .orElse(item.toString())));
        arrests.clear();
    }

    private void throwFailure(int made) {
        PhysicsException found = failure;
        if (found != null) {
            throw refusal(found.status(), made, String.valueOf(found.getMessage()));
        }
    }

    private PhysicsException refusal(Status status, int made, String why) {
        return new PhysicsException(
                status, "in frame " + made + " of " + frames + " of its shadow: " + why);
    }

    /** Records the failure of a law that failed in the copy but not in the world. */
    private void note(LawChange change) {
        switch (change) {
            case LawChange.RolledBack back -> fail(back.reason().status(), back.reason().message());
            case LawChange.Failed failed ->
                    fail(failed.reason().status(), failed.reason().message());
            case LawChange.Arrested arrested -> arrests.add(arrested.item());
            case LawChange.Unmoved _ ->
                    fail(Status.ENGINE_LOST, "the engine's process was lost, and no law acted");
            case LawChange.Loaded _,
                    LawChange.Replaced _,
                    LawChange.Unloaded _,
                    LawChange.ParametersSet _,
                    LawChange.BudgetSet _,
                    LawChange.IntervalSet _,
                    LawChange.Released _ -> {}
        }
    }

    private void fail(Status status, String message) {
        if (failure == null) {
            failure = new PhysicsException(status, message);
        }
    }

    /** Records that a new version has exceeded its budget. */
    private void noteBudgets(FrameEvent frame) {
        for (WorldEvent event : frame.world().events()) {
            if (event.type().equals("over-budget")
                    && names().anyMatch(event.fields().get("library")::equals)) {
                fail(Status.LAW_TIMED_OUT, String.valueOf(event.fields().get("message")));
            }
        }
    }

    private Verdict all(PhysicsException why) {
        Map<NewVersion, PhysicsException> refused = new LinkedHashMap<>();
        versions.forEach(version -> refused.put(version, why));
        return new Verdict(refused);
    }
}
