// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.world.ColumnArena;
import reve.core.world.FrameControl;
import reve.core.world.Item;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.LedgerLine;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyDescriptor;
import reve.pe.PropertyUse;
import reve.pe.Status;

import java.util.ArrayList;
import java.util.Collections;
import java.util.Comparator;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.function.LongSupplier;
import java.util.stream.Collectors;

/**
 * The listener of phase PHYSICS, which moves a world by the laws of a physics engine. The engine
 * uses the world's columns in place, and a frame is one native call.
 *
 * <p>A failing law costs one repeated frame. The adapter restores the columns, quarantines the
 * law's library, reports a "fault" event, and repeats the frame without this library. The world has
 * the same bits as a world without that law from that frame on. A law may fail because another law
 * made extreme numbers. The library of the other law is then quarantined.
 *
 * <p>The cause of a failure may be no loaded law. The adapter then restores the columns and throws
 * the failure, so that this frame has no physics. It also reports a {@link LawChange}, so that a
 * replay of the journal does the same. The frame is repeated if the engine's process was lost while
 * no law ran. The library that was loaded last is quarantined if the process is lost again.
 *
 * <p>The adapter tries to arrest items before it quarantines a law. Laws do not act on arrested
 * items. Only items that actions or edits changed may be arrested. The adapter begins with the item
 * at which the law failed, or else with the item with the most extreme numbers. It finally tries
 * all of these items together. The items stay arrested if the frame succeeds without them, and a
 * "fault" event reports the arrest. Otherwise the items are restored.
 *
 * <p>If a loaded law declares that it writes {@code size}, the shapes of bodies follow this column
 * after the laws of each frame, see {@link FrameControl#followSizes}. If a body cannot have the
 * size that laws wrote, the body keeps its shape, and a "fault" event reports this once for each
 * set of laws.
 *
 * <p>For the world's thread only. The caller owns the engine and the arena, which must outlive the
 * adapter. The caller must not call the engine itself while the adapter exists.
 */
public final class PhysicsAdapter implements FrameListener, AutoCloseable {
    /**
     * Number of items that are arrested one by one before all suspect items are arrested together.
     * This number limits the repetitions of a frame.
     */
    private static final int MOST_ARRESTS_ONE_BY_ONE = 2;

    /** Maximum number of repetitions of a frame because the engine's process was lost. */
    private static final int MOST_LOSSES = 5;

    private static final Set<Status> CRASHES = Set.of(Status.LAW_CRASHED, Status.LAW_TIMED_OUT);

    private final World world;
    private final PhysicsEngine engine;
    private final BoundWorld bound;
    private final Laws laws;
    private final Blame blame;
    private final LawTimes times;
    private final BudgetWatch budgets;
    private final OwnColumns ownColumns;
    private final RollbackCopy rollback = new RollbackCopy();
    private final Set<String> accumulators = new HashSet<>();
    private final List<Arrested> arrests = new ArrayList<>();

    /** Names of the loaded laws that write the sizes of bodies; empty for none. */
    private String resizing = "";

    /** Version of the laws at the last report of a refused size. */
    private long refusedLaws = -1;

    private long keptLayout = -1;
    private long keptLaws = -1;
    private long lentLaws = -1;

    /** Names of the properties that the laws of the version {@link #usedLaws} use. */
    private Set<String> used = Set.of();

    private long usedLaws = -1;

    /** Description of the work of the world's thread while it is in the engine, for reports. */
    private String advancing = "";

    /**
     * Number of times that the engine's process was lost in this frame without a law as the cause.
     */
    private int losses;

    private Runnable beforeRepetition = () -> {};
    private long frames;
    private long redoneFrames;
    private long bindNanoseconds;
    private long copyNanoseconds;
    private long advanceNanoseconds;

    /**
     * An item that was arrested for a repetition of the frame. The function {@code release} undoes
     * the arrest.
     */
    private record Arrested(Item item, PhysicsException failure, Runnable release) {}

    /**
     * Binds the world's columns to the engine.
     *
     * @param engine created for {@link PropertyNames#prototype} of the world's prototype
     * @param arena allocates the memory of the index columns
     * @throws IllegalStateException naming item and property if a reference is invalid
     * @throws PhysicsException if the engine refuses a column
     */
    public PhysicsAdapter(World world, PhysicsEngine engine, ColumnArena arena) {
        this.world = world;
        this.engine = engine;
        this.bound = new BoundWorld(world, engine, arena);
        this.laws = new Laws(world, engine);
        this.blame = new Blame(engine, laws, bound, rollback);
        this.times =
                new LawTimes(
                        engine, laws, () -> bindNanoseconds + copyNanoseconds + advanceNanoseconds);
        this.budgets = new BudgetWatch(engine, laws, times);
        this.ownColumns = new OwnColumns(engine, laws);
        for (PropertyDescriptor property : engine.prototype().properties()) {
            if (property.lawAccess().contains(Access.ACCUMULATE)) {
                accumulators.add(property.name());
            }
        }
        bound.update();
    }

    /**
     * Sets what runs on the world's thread before a frame is repeated, because a law failed. The
     * world then has the state from which the laws of the frame begin, without the numbers of
     * arrested items and without quarantined laws. A replay has this state from the start of the
     * frame.
     */
    public void beforeRepetition(Runnable action) {
        beforeRepetition = action;
    }

    /** Returns the laws of this world. */
    public Laws laws() {
        return laws;
    }

    @Override
    public void onFrame(FrameEvent frame) {
        boolean moved = false;
        try {
            budgets.carryOut(frame.frame());
            if (laws.takeUnmoved()) {
                bind();
            } else {
                move(frame);
            }
            moved = true;
        } finally {
            if (!moved) {
                laws.failed();
            }
        }
    }

    private void move(FrameEvent frame) {
        long start = System.nanoTime();
        bind();
        keepWhatLawsMayWrite();
        long bound = System.nanoTime();
        rollback.save();
        long copied = System.nanoTime();
        bindNanoseconds += bound - start;
        copyNanoseconds += copied - bound;
        losses = 0;
        long redone = redoneFrames;
        times.begin();
        while (!advanced(frame)) {
            redoneFrames++;
            beforeRepetition.run();
        }
        if (!resizing.isEmpty()) {
            followSizes(frame.frame());
        }
        if (times.end(redoneFrames == redone)) {
            budgets.check(frame.frame());
        }
        if (!arrests.isEmpty()) {
            arrests.forEach(one -> laws.arrested(frame.frame(), one.item, one.failure));
            arrests.clear();
        }
        advanceNanoseconds += System.nanoTime() - copied;
        frames++;
    }

    /**
     * Sets the clock with which {@link #lawTimes} compares the times of laws. The times of laws are
     * compared with the time of the phase PHYSICS if this clock is not set.
     *
     * @param nanoseconds returns the time of all frames so far [ns]
     */
    public void measureFrames(LongSupplier nanoseconds) {
        times.measureFrames(nanoseconds);
    }

    /**
     * Returns the times of the loaded laws in the last frames, at most 1,024, in the order of
     * {@link Laws#loaded}. Call it between frames.
     */
    public List<LawTime> lawTimes() {
        return times.report();
    }

    /**
     * Returns the number of loaded laws whose times in the last frame are known: all of them, or 0
     * if laws were loaded or unloaded since this frame. Call it between frames.
     */
    public int timedLaws() {
        return times.timed();
    }

    /**
     * Returns the time of a law in the last frame [ns]. Call it between frames.
     *
     * @param law index in {@link Laws#loaded}, below {@link #timedLaws}
     */
    public long newestLawTime(int law) {
        return times.newest(law);
    }

    /**
     * Sets whether the budgets of libraries have an effect. Initially they have no effect. The
     * clock then decides which laws act, and journals record each decision. A replay must not
     * enforce them.
     */
    public void enforceBudgets(boolean on) {
        budgets.enforce(on);
    }

    /**
     * Returns a hash of the engine's step count and of all bound columns. Call it between frames.
     */
    public long stateHash() {
        bind();
        return engine.stateHash();
    }

    /**
     * Returns the physics part of an image (saved state). This part and the world's part together
     * continue the run with equal bits. Call it between frames.
     */
    public PhysicsImage save() {
        bind();
        return new PhysicsImage(laws.libraries(), laws.quarantined(), engine.saveState());
    }

    /**
     * Restores the physics part of an image, and calls {@code world}, which restores the rest.
     * Nothing has changed if the engine or {@code world} refuses the image. Call it between frames.
     *
     * @param frame the world's current frame
     * @param world restores the world from the same image, or throws before it has changed anything
     * @throws PhysicsException if the engine refuses a library or the state
     * @throws IllegalStateException if no process can be started for the engine
     */
    public void restore(long frame, PhysicsImage image, Runnable world) {
        bind();
        laws.restore(frame, image, world);
        budgets.forget();
        bind();
        engine.loadState(image.engineState());
    }

    /**
     * Returns the columns that the loaded laws have of their own for an item, with its values; none
     * for an item without physics. Call it between frames.
     *
     * @throws PhysicsException if the engine cannot be asked
     */
    public LawColumns lawColumns(Item item) {
        if (item.physics().isEmpty()) {
            return LawColumns.NONE;
        }
        bind();
        return ownColumns.of(item.kind(), world.table(item.kind()).rowOf(item.id()));
    }

    /** Opens or closes the engine's ledger. Call it between frames. */
    public void setLedger(boolean on) {
        engine.setLedger(on);
    }

    /**
     * Returns the lines of the engine's ledger, which must be open. The line "client" contains the
     * changes that laws did not make. Call it between frames.
     */
    public List<LedgerLine> ledger() {
        bind();
        return engine.ledger();
    }

    /** Returns the adapter's times so far. */
    public AdapterProfile profile() {
        return new AdapterProfile(
                frames, redoneFrames, bindNanoseconds, copyNanoseconds, advanceNanoseconds);
    }

    /** Frees the rollback copy; the engine still uses the columns until it is closed. */
    @Override
    public void close() {
        rollback.close();
    }

    /**
     * Passes changes of the world's columns to the engine. Also binds the columns that the loaded
     * laws use.
     */
    private void bind() {
        if (lentLaws != laws.version()) {
            bound.setUsed(usedProperties());
            lentLaws = laws.version();
        }
        bound.update();
    }

    /**
     * Returns the names of the properties that the loaded laws use. Calls the engine only after a
     * library was loaded or unloaded. For the world's thread only.
     */
    public Set<String> usedProperties() {
        if (usedLaws != laws.version()) {
            used =
                    laws.loaded().stream()
                            .flatMap(law -> law.uses().stream())
                            .map(PropertyUse::name)
                            .collect(Collectors.toUnmodifiableSet());
            usedLaws = laws.version();
        }
        return used;
    }

    private boolean advanced(FrameEvent frame) {
        try {
            world.activity().begin(advancing);
            engine.advance(frame.dtSeconds(), frame.steps());
            return true;
        } catch (PhysicsException failure) {
            List<Arrested> tried = List.copyOf(arrests);
            boolean hasReadExtremes = blame.hasReadExtremes(failure);
            undo();
            engine.clearFault();
            if (failure.status() == Status.ENGINE_LOST && losses++ < MOST_LOSSES) {
                tried.forEach(one -> arrest(one.item, one.failure));
            } else if (!arrestFor(failure, tried)) {
                Optional<Item> item = itemOf(failure);
                PhysicsException cause =
                        hasReadExtremes ? blame.cause(frame, failure) : blamed(failure);
                if (laws.quarantine(frame.frame(), cause, item)) {
                    bind(); // the restored version may use and write other columns
                    keepWhatLawsMayWrite();
                    rollback.save();
                }
                losses = 0;
            }
            return false;
        } catch (RuntimeException failure) {
            undo();
            throw failure;
        } finally {
            world.activity().end();
        }
    }

    private void undo() {
        arrests.forEach(one -> one.release.run());
        arrests.clear();
        rollback.restore();
    }

    /**
     * Returns the failure; if the engine does not know which library caused it, the failure names
     * the library that was loaded last.
     */
    private PhysicsException blamed(PhysicsException failure) {
        return failure.status() == Status.ENGINE_LOST
                ? laws.latest()
                        .map(
                                latest ->
                                        new PhysicsException(
                                                failure.status(),
                                                latest.getKey(),
                                                latest.getValue().name(),
                                                "",
                                                "",
                                                -1,
                                                failure.getMessage()
                                                        + ", "
                                                        + (MOST_LOSSES + 1)
                                                        + " times in this frame; the library that"
                                                        + " was loaded last is unloaded"))
                        .orElse(failure)
                : failure;
    }

    /**
     * Arrests the items of the earlier attempts and one more item, or all items that may have
     * caused the failure.
     *
     * @return false if no item is left to arrest, or no law caused the failure
     */
    private boolean arrestFor(PhysicsException failure, List<Arrested> tried) {
        Optional<Item> failed = itemOf(failure);
        List<Item> suspects = new ArrayList<>(world.arrests().suspects(failed));
        suspects.removeAll(tried.stream().map(Arrested::item).toList());
        if (CRASHES.contains(failure.status())) {
            // A crash of a law does not depend on extreme numbers. An item is therefore suspect
            // only if its numbers are extreme.
            suspects.removeIf(item -> !world.arrests().isExtreme(item));
        }
        if (suspects.isEmpty() || !laws.isLoaded(failure.libraryId())) {
            return false;
        }
        if (tried.size() < MOST_ARRESTS_ONE_BY_ONE) {
            suspects =
                    List.of(
                            failed.filter(suspects::contains)
                                    .orElse(
                                            Collections.max(
                                                    suspects,
                                                    Comparator.comparingDouble(
                                                            world.arrests()::excess))));
        }
        tried.forEach(one -> arrest(one.item, one.failure));
        suspects.forEach(item -> arrest(item, failure));
        return true;
    }

    private void arrest(Item item, PhysicsException failure) {
        arrests.add(new Arrested(item, failure, world.arrests().arrest(item)));
    }

    private Optional<Item> itemOf(PhysicsException failure) {
        return failure.row().isEmpty()
                ? Optional.empty()
                : kindOf(failure).flatMap(kind -> bound.item(kind, failure.row().getAsLong()));
    }

    /**
     * Returns the kind (such as "body") of the property at which a law failed. The property may
     * also be SCRATCH memory of the law. Empty if the failure names no property.
     */
    private Optional<String> kindOf(PhysicsException failure) {
        return laws.loaded().stream()
                .filter(law -> law.libraryId() == failure.libraryId())
                .flatMap(law -> law.uses().stream())
                .filter(use -> use.name().equals(failure.property()))
                .map(PropertyUse::kind)
                .findFirst();
    }

    private void keepWhatLawsMayWrite() {
        if (keptLayout != bound.boundLayout() || keptLaws != laws.version()) {
            rollback.keep(bound.columns(writtenProperties()));
            keptLayout = bound.boundLayout();
            keptLaws = laws.version();
            resizing =
                    laws.loaded().stream()
                            .filter(PhysicsAdapter::writesSizes)
                            .map(PhysicsLaw::name)
                            .collect(Collectors.joining(", "));
            advancing =
                    "native code (advance) of the laws "
                            + laws.loaded().stream()
                                    .map(PhysicsLaw::name)
                                    .collect(Collectors.joining(", "));
        }
    }

    private static boolean writesSizes(PhysicsLaw law) {
        return law.uses().stream()
                .anyMatch(
                        use ->
                                use.kind().equals(WorldPrototype.BODY)
                                        && use.name().equals(PropertyNames.SIZE)
                                        && use.access().contains(Access.WRITE));
    }

    /**
     * Makes the shapes of bodies follow the sizes that laws wrote. Reports the first size that a
     * shape cannot have, once for each set of laws.
     */
    private void followSizes(long frame) {
        FrameControl.of(world)
                .followSizes()
                .filter(refused -> refusedLaws != laws.version())
                .ifPresent(
                        refused -> {
                            refusedLaws = laws.version();
                            laws.refusedSize(frame, resizing, refused);
                        });
    }

    /**
     * Returns the properties that laws write, and all accumulators, which the engine itself writes.
     */
    private Set<String> writtenProperties() {
        Set<String> written = new HashSet<>(accumulators);
        for (PhysicsLaw law : laws.loaded()) {
            for (PropertyUse use : law.uses()) {
                if (use.access().contains(Access.WRITE)) {
                    written.add(use.name());
                }
            }
        }
        return written;
    }
}
