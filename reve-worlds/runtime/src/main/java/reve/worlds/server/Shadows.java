// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.LawSwap;
import reve.core.frame.Subscription;
import reve.core.world.ItemId;
import reve.core.world.WorldChange;
import reve.core.world.WorldEvent;
import reve.pe.PhysicsException;
import reve.pe.Status;
import reve.pe.adapter.LawChange;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.Laws;
import reve.pe.adapter.NewVersion;
import reve.pe.adapter.Trials;
import reve.worlds.journal.SimulationImage;

import java.lang.foreign.ValueLayout;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;
import java.util.function.Consumer;
import java.util.stream.Collectors;

/**
 * The trials of new versions of laws in the shadow of a world. A copy of the world makes the same
 * frames with the new version, while the old version moves the world. One trial runs at a time. The
 * new version takes over in ACT, the phase for commands, as a {@link LawChange}. Therefore a replay
 * of the journal needs neither the copy nor a clock. Each stage raises an event {@code law-shadow}.
 * The world never waits for a copy. For the world's thread only.
 *
 * <p>A copy cannot continue to make the frames of the world after a change of laws, after a rewind,
 * or if too many frames wait. A new copy begins in these cases. A trial is refused as too slow if
 * it takes more than {@link #MOST_TIMES} times the world time that it covers. This limit applies
 * both to world time and to elapsed time. The limit of elapsed time is at least a minute. There is
 * at most one copy at a time. A new copy does not begin before the previous copy could have made
 * all its frames. Therefore repeated new versions or rewinds cost no more than one copy.
 */
final class Shadows implements Trials, AutoCloseable {
    /** Type of the events. */
    static final String EVENT = "law-shadow";

    /** Maximum time of a trial, as a multiple of the world time that the trial covers. */
    private static final int MOST_TIMES = 10;

    /**
     * Minimum elapsed time that a trial may take before it is refused as too slow [ns]. The time is
     * long because a machine may be busy.
     */
    private static final double LEAST_NANOS = 60e9;

    /** Number of events about the divergence in a trial. */
    private static final int REPORTS = 10;

    /**
     * World time after a replacement during which a failure of the new version restores the old
     * version [s].
     */
    private static final long PROBATION_SECONDS = 60;

    private static final long CLOSE_MILLISECONDS = 5_000;

    private final Simulation simulation;
    private final SwapPlan plan;
    private final int frames;
    private final Deque<Trial> waiting = new ArrayDeque<>();
    private final List<Shadow> ended = new ArrayList<>();
    private final List<Subscription> subscriptions = new ArrayList<>();
    private final Consumer<LawChange> lawListener = this::follow;
    private @Nullable Trial current;
    private List<ShadowFrame.Noted> early = List.of();
    private int earlyCount;

    /** Number of frames that the world has published; a rewind does not reduce it. */
    private long published;

    /** Number of published frames at which the next copy may begin. */
    private long nextCopyFrom;

    /** The items that were arrested in this frame. */
    private final Set<ItemId> arrests = new HashSet<>();

    /** True if the laws of the world have changed since the copy began. */
    private boolean lawsChanged;

    /** A trial of versions that take over together. */
    private static final class Trial {
        private List<NewVersion> versions;
        private @Nullable Shadow shadow;
        private long begunFrame = -1;
        private long begunNanos;
        private int given;
        private int reported;
        private int copies;

        /** The reason why the last copy was abandoned. */
        private String interruption = "";

        Trial(List<NewVersion> versions) {
            this.versions = new ArrayList<>(versions);
        }
    }

    Shadows(Simulation simulation, SwapPlan plan) {
        this.simulation = simulation;
        this.plan = plan;
        long framesPerSecond = simulation.description().timing().framesPerSecond();
        this.frames =
                Math.clamp(Math.round(plan.seconds() * framesPerSecond), 1, Integer.MAX_VALUE);
        simulation.physics().laws().addListener(lawListener);
        simulation.physics().laws().keepPreviousFor(PROBATION_SECONDS * framesPerSecond);
    }

    /** Subscribes to the frames. Called after all other listeners of ACT have subscribed. */
    void start() {
        subscriptions.add(simulation.bus().subscribe(FramePhase.ACT, "shadows", this::onAct));
        subscriptions.add(
                simulation.bus().subscribe(FramePhase.PUBLISH, "shadows", this::onPublish));
    }

    /**
     * Returns whether a new version is tried in the shadow before it takes over.
     *
     * @param text whether the version is a law as text
     */
    boolean areDue(boolean text, Optional<LawSwap> asked) {
        return plan.isShadowed(text, asked);
    }

    @Override
    public boolean areDue(LawLibrary library) {
        return areDue(library.isText(), Optional.empty());
    }

    @Override
    public boolean areDueForParameters() {
        return areDueForParameters(Optional.empty());
    }

    /** Returns whether new parameters of a loaded library are tried first. */
    boolean areDueForParameters(Optional<LawSwap> asked) {
        return plan.areParametersShadowed(asked);
    }

    @Override
    public void begin(long frame, List<NewVersion> versions) {
        versions.forEach(version -> cancel(frame, version.libraryId()));
        waiting.add(new Trial(versions));
    }

    @Override
    public void cancel(long frame, int libraryId) {
        List<Trial> trials = new ArrayList<>(waiting);
        Optional.ofNullable(current).ifPresent(trials::add);
        for (Trial trial : trials) {
            for (NewVersion version : List.copyOf(trial.versions)) {
                if (version.libraryId() == libraryId) {
                    refuse(
                            frame,
                            trial,
                            version,
                            new PhysicsException(
                                    Status.NOT_FOUND, "another change of the law came first"));
                    trial.versions.remove(version);
                    lawsChanged = true; // a new copy begins without this version
                }
            }
            if (trial.versions.isEmpty()) {
                end(trial);
            }
        }
    }

    /** Returns the trials for operators, the running one first. */
    List<Map<String, Object>> report() {
        List<Map<String, Object>> trials = new ArrayList<>();
        Trial running = current;
        if (running != null) {
            running.versions.forEach(version -> trials.add(report(running, version)));
        }
        for (Trial trial : waiting) {
            trial.versions.forEach(version -> trials.add(report(trial, version)));
        }
        return trials;
    }

    private Map<String, Object> report(Trial trial, NewVersion version) {
        Map<String, Object> fields =
                fields(trial, version, trial.begunFrame < 0 ? "waits" : "runs");
        fields.put(
                "items",
                progress(trial).divergence().items().stream()
                        .map(ShadowDivergence.OfItem::fields)
                        .toList());
        return fields;
    }

    private static Shadow.Progress progress(Trial trial) {
        Shadow shadow = trial.shadow;
        return shadow == null ? Shadow.Progress.NONE : shadow.progress();
    }

    private Map<String, Object> fields(Trial trial, NewVersion version, String stage) {
        Shadow.Progress progress = progress(trial);
        LawLibrary library = version.library();
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", "physics");
        fields.put("library", library.name());
        fields.put("stage", stage);
        fields.put("sha256", library.sha256());
        if (version.parametersOnly()) {
            fields.put(
                    "parameters",
                    library.parameters().entrySet().stream()
                            .map(each -> each.getKey() + " = " + each.getValue())
                            .collect(Collectors.joining(", ")));
        }
        fields.put("frames", progress.frames());
        fields.put("of", frames);
        fields.putAll(progress.divergence().fields());
        Double energy = progress.energy();
        Double most = progress.mostEnergy();
        if (energy != null && most != null) {
            fields.put("energy", energy);
            fields.put("mostEnergy", most);
        }
        return fields;
    }

    private void raise(long frame, Trial trial, NewVersion version, String stage) {
        simulation.world().raise(new WorldEvent(frame, EVENT, fields(trial, version, stage)));
    }

    private void refuse(long frame, Trial trial, NewVersion version, PhysicsException why) {
        Map<String, Object> fields = fields(trial, version, "refused");
        fields.put("status", why.status().name());
        fields.put(
                "message",
                "library "
                        + version.library().name()
                        + " stays as it is; its new "
                        + (version.parametersOnly() ? "parameters are" : "version is")
                        + " refused: "
                        + why.getMessage());
        simulation.world().raise(new WorldEvent(frame, EVENT, fields));
        version.ended().ended(frame, Optional.of(why));
        version.close();
    }

    private void follow(LawChange change) {
        if (change instanceof LawChange.Arrested arrested) {
            arrests.add(arrested.item());
        } else {
            lawsChanged |= !(change instanceof LawChange.Released);
        }
    }

    private void onAct(FrameEvent event) {
        Trial trial = current;
        if (trial == null) {
            return;
        }
        Shadow shadow = trial.shadow;
        if (shadow != null) {
            Optional<Shadow.Verdict> verdict = shadow.verdict();
            if (verdict.isPresent()) {
                finish(event.frame(), trial, verdict.get());
                return;
            }
            report(event.frame(), trial, shadow);
        }
        List<WorldChange> changes = simulation.world().changes();
        early = ShadowFrame.noted(simulation.world(), changes, 0);
        earlyCount = changes.size();
    }

    private void report(long frame, Trial trial, Shadow shadow) {
        int due = (int) ((long) shadow.progress().frames() * REPORTS / frames);
        if (due > trial.reported) {
            trial.reported = due;
            trial.versions.forEach(version -> raise(frame, trial, version, "runs"));
        }
    }

    /** Ends the trial. The versions that are not refused take over in this frame. */
    private void finish(long frame, Trial trial, Shadow.Verdict verdict) {
        try {
            take(frame, trial, verdict);
        } finally {
            end(trial);
        }
    }

    private void take(long frame, Trial trial, Shadow.Verdict verdict) {
        verdict.refused().forEach((version, why) -> refuse(frame, trial, version, why));
        List<NewVersion> taking = new ArrayList<>(trial.versions);
        taking.removeAll(verdict.refused().keySet());
        Map<NewVersion, PhysicsException> again = new LinkedHashMap<>();
        for (NewVersion version : taking) {
            taken(frame, trial, version).ifPresent(why -> again.put(version, why));
        }
        again.forEach(
                (version, first) -> {
                    Optional<PhysicsException> why =
                            taking.size() > 1 ? taken(frame, trial, version) : Optional.of(first);
                    why.ifPresent(each -> refuse(frame, trial, version, each));
                });
    }

    /** Makes a version take over. Returns the reason if the world's engine refuses it. */
    private Optional<PhysicsException> taken(long frame, Trial trial, NewVersion version) {
        try {
            version.take(frame);
        } catch (PhysicsException refused) {
            return Optional.of(refused);
        } catch (IllegalArgumentException | IllegalStateException gone) {
            return Optional.of(
                    new PhysicsException(Status.NOT_FOUND, String.valueOf(gone.getMessage())));
        }
        raise(frame, trial, version, "accepted");
        version.ended().ended(frame, Optional.empty());
        version.close();
        return Optional.empty();
    }

    private void onPublish(FrameEvent event) {
        published++;
        Set<ItemId> arrested = Set.copyOf(arrests);
        arrests.clear();
        ended.removeIf(shadow -> !shadow.isAlive());
        boolean mayBegin = ended.isEmpty() && published >= nextCopyFrom;
        if (current == null) {
            current = mayBegin ? waiting.poll() : null;
            if (current != null) {
                begin(event.frame(), current, true);
            }
            return;
        }
        Trial trial = current;
        if (trial.shadow != null && trial.given < frames) {
            give(event.frame(), trial, arrested);
        }
        if (current == trial && isTooLong(event.frame(), trial)) {
            PhysicsException why = tooLong(event.frame(), trial);
            trial.versions.forEach(version -> refuse(event.frame(), trial, version, why));
            end(trial);
        } else if (current == trial && trial.shadow == null) {
            begin(event.frame(), trial, mayBegin);
        }
    }

    /** Passes this frame to the copy, or abandons the copy. */
    private void give(long frame, Trial trial, Set<ItemId> arrested) {
        List<WorldChange> changes = simulation.world().changes();
        boolean isRewound = changes.stream().anyMatch(WorldChange.Restored.class::isInstance);
        if (lawsChanged) {
            interrupt(trial, "laws changed");
        } else if (isRewound) {
            interrupt(trial, "the world was rewound");
        } else if (simulation.world().changesLost() > 0) {
            interrupt(trial, "a frame had too many changes");
        } else {
            boolean hasRows = trial.given + 1 == frames || Shadow.hasRoom(rowBytes());
            ShadowFrame made =
                    new ShadowFrame(
                            early,
                            ShadowFrame.noted(simulation.world(), changes, earlyCount),
                            hasRows ? rows(ShadowFrame.POSITION) : new byte[0],
                            hasRows ? rows(ShadowFrame.VELOCITY) : new byte[0],
                            arrested);
            if (Objects.requireNonNull(trial.shadow).give(made)) {
                trial.given++;
            } else {
                interrupt(trial, "its copy was too far behind the world");
            }
        }
    }

    private long rowBytes() {
        return ShadowFrame.rows(simulation.world(), ShadowFrame.POSITION).byteSize()
                + ShadowFrame.rows(simulation.world(), ShadowFrame.VELOCITY).byteSize();
    }

    private byte[] rows(String property) {
        return ShadowFrame.rows(simulation.world(), property).toArray(ValueLayout.JAVA_BYTE);
    }

    private void interrupt(Trial trial, String why) {
        trial.interruption = why;
        stop(trial);
    }

    private boolean isTooLong(long frame, Trial trial) {
        return frame - trial.begunFrame > (long) MOST_TIMES * frames
                && System.nanoTime() - trial.begunNanos
                        > Math.max(MOST_TIMES * plan.seconds() * 1e9, LEAST_NANOS);
    }

    private PhysicsException tooLong(long frame, Trial trial) {
        return new PhysicsException(
                Status.LAW_TIMED_OUT,
                "its shadow made "
                        + progress(trial).frames()
                        + " of "
                        + frames
                        + " frames while the world made "
                        + (frame - trial.begunFrame)
                        + (trial.copies > 1
                                ? "; it began again "
                                        + (trial.copies - 1)
                                        + " times, at last because "
                                        + trial.interruption
                                : "")
                        + "; make the law faster, or load it with swap at-once");
    }

    /**
     * Starts a copy of the world as it is at the end of this frame.
     *
     * @param mayBegin false to start no copy, and only refuse versions whose library was unloaded
     */
    private void begin(long frame, Trial trial, boolean mayBegin) {
        boolean isFirst = trial.begunFrame < 0;
        if (isFirst) {
            trial.begunFrame = frame;
            trial.begunNanos = System.nanoTime();
        }
        Laws laws = simulation.physics().laws();
        List<Integer> ids = List.copyOf(laws.byId().keySet());
        List<LawChange> changes = new ArrayList<>();
        for (NewVersion version : List.copyOf(trial.versions)) {
            int place = ids.indexOf(version.libraryId());
            if (place < 0) {
                refuse(
                        frame,
                        trial,
                        version,
                        new PhysicsException(
                                Status.NOT_FOUND, "the library was unloaded meanwhile"));
                trial.versions.remove(version);
            } else {
                changes.add(version.change(place));
            }
        }
        if (trial.versions.isEmpty()) {
            end(trial);
            return;
        }
        if (!mayBegin) {
            return;
        }
        SimulationImage image = new SimulationImage(simulation.world());
        boolean isCopied = false;
        try {
            image.copyFrom(simulation.world(), simulation.physics(), frame);
            isCopied = true;
        } catch (PhysicsException | IllegalStateException lost) {
            trial.interruption = "the world could not be copied: " + lost.getMessage();
        } finally {
            if (!isCopied) {
                image.close();
            }
        }
        if (isCopied) {
            lawsChanged = false;
            trial.given = 0;
            trial.reported = 0;
            trial.copies++;
            nextCopyFrom = published + frames;
            trial.shadow = new Shadow(simulation, image, trial.versions, changes, plan, frames);
            if (isFirst) {
                trial.versions.forEach(version -> raise(frame, trial, version, "begins"));
            }
        }
    }

    private void stop(Trial trial) {
        Shadow shadow = trial.shadow;
        if (shadow != null) {
            shadow.close();
            ended.add(shadow);
            trial.shadow = null;
        }
    }

    private void end(Trial trial) {
        stop(trial);
        waiting.remove(trial);
        if (current == trial) {
            current = null;
        }
    }

    /**
     * Waits until the copy of the running trial has made all frames that were passed to it, or has
     * ended. Also waits until all earlier copies have ended. For tests.
     */
    void await() throws InterruptedException {
        for (Shadow shadow : ended) {
            shadow.join(0);
        }
        Trial trial = current;
        Shadow shadow = trial == null ? null : trial.shadow;
        while (trial != null
                && shadow != null
                && shadow.isAlive()
                && shadow.progress().frames() < trial.given) {
            Thread.sleep(1);
        }
        if (trial != null && shadow != null && trial.given == frames) {
            shadow.join(0);
        }
    }

    /** Ends all trials, after the last frame; waits for their copies. Idempotent. */
    @Override
    public void close() {
        subscriptions.forEach(Subscription::close);
        subscriptions.clear();
        simulation.physics().laws().removeListener(lawListener);
        List<Trial> trials = new ArrayList<>(waiting);
        Optional.ofNullable(current).ifPresent(trials::add);
        for (Trial trial : trials) {
            trial.versions.forEach(NewVersion::close);
            end(trial);
        }
        try {
            for (Shadow shadow : ended) {
                shadow.join(CLOSE_MILLISECONDS);
            }
        } catch (InterruptedException stopped) {
            Thread.currentThread().interrupt();
        }
        ended.clear();
    }
}
