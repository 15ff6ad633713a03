// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.world.ColumnArena;
import reve.core.world.Item;
import reve.core.world.World;
import reve.pe.Access;
import reve.pe.LedgerLine;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyDescriptor;
import reve.pe.PropertyUse;

import java.util.ArrayList;
import java.util.Collections;
import java.util.Comparator;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.stream.Collectors;

/**
 * Moves a world by the laws of a physics engine: the listener of phase PHYSICS. The engine works in
 * place on the world's columns, and a frame is one native call.
 *
 * <p>A law that fails costs one redone frame: the columns are put back, the law's library is
 * quarantined and told as a "fault" event, and the frame is done over without it. From that frame
 * on the world is, to the bit, one that runs without that law. A failure that no loaded law is to
 * blame for is thrown after the columns were put back: that frame has no physics.
 *
 * <p>Before a law is blamed, items are that actions and edits changed: the one at which the law
 * failed, else the one with the most extreme numbers, then all of them. Where the frame succeeds
 * without them they stay arrested, which is told as a "fault" event; else they are as they were.
 *
 * <p>World's thread only. The engine and the arena belong to the caller, outlive the adapter, and
 * the engine is used for nothing else meanwhile.
 */
public final class PhysicsAdapter implements FrameListener, AutoCloseable {
    /** Bounds how often a frame is redone. */
    private static final int MOST_ARRESTS_ONE_BY_ONE = 2;

    private final World world;
    private final PhysicsEngine engine;
    private final LentWorld lent;
    private final Laws laws;
    private final RollbackCopy rollback = new RollbackCopy();
    private final Set<String> accumulators = new HashSet<>();
    private final List<Arrested> arrests = new ArrayList<>();
    private long keptLayout = -1;
    private long keptLaws = -1;

    /** What the world's thread does in the engine, for people. */
    private String advancing = "";

    private long frames;
    private long redoneFrames;
    private long bindNanoseconds;
    private long copyNanoseconds;
    private long advanceNanoseconds;

    /** An item without which the frame is tried. */
    private record Arrested(Item item, PhysicsException failure, Runnable release) {}

    /**
     * Lends the world's columns to the engine.
     *
     * @param engine made for {@link PropertyNames#prototype} of the world's prototype
     * @param arena gives the memory of the index columns
     * @throws IllegalStateException naming item and property if a reference leads nowhere
     * @throws PhysicsException if the engine refuses a column
     */
    public PhysicsAdapter(World world, PhysicsEngine engine, ColumnArena arena) {
        this.world = world;
        this.engine = engine;
        this.lent = new LentWorld(world, engine, arena);
        this.laws = new Laws(world, engine);
        for (PropertyDescriptor property : engine.prototype().properties()) {
            if (property.lawAccess().contains(Access.ACCUMULATE)) {
                accumulators.add(property.name());
            }
        }
        lent.update();
    }

    /** The laws of this world. */
    public Laws laws() {
        return laws;
    }

    @Override
    public void onFrame(FrameEvent frame) {
        long start = System.nanoTime();
        lent.update();
        keepWhatLawsMayWrite();
        long bound = System.nanoTime();
        rollback.save();
        long copied = System.nanoTime();
        bindNanoseconds += bound - start;
        copyNanoseconds += copied - bound;
        while (!advanced(frame)) {
            redoneFrames++;
        }
        if (!arrests.isEmpty()) {
            arrests.forEach(one -> laws.arrested(frame.frame(), one.item, one.failure));
            arrests.clear();
        }
        advanceNanoseconds += System.nanoTime() - copied;
        frames++;
    }

    /** Hash of the engine's step count and of all columns lent to it. Between frames. */
    public long stateHash() {
        lent.update();
        return engine.stateHash();
    }

    /** What it takes, with an image of the world, to go on to the bit. Between frames. */
    public PhysicsImage save() {
        lent.update();
        return new PhysicsImage(laws.libraries(), laws.quarantined(), engine.saveState());
    }

    /**
     * Goes on as the adapter did whose image this is; the world was restored before. Between
     * frames.
     *
     * @param frame the frame that the world is in now
     * @throws PhysicsException if the engine refuses a library or the state
     */
    public void restore(long frame, PhysicsImage image) {
        laws.restore(frame, image.libraries(), image.quarantined());
        lent.update();
        engine.loadState(image.engineState());
    }

    /** Opens or closes the engine's ledger. Between frames. */
    public void setLedger(boolean on) {
        engine.setLedger(on);
    }

    /** The engine's open ledger; what no law did is the client's. Between frames. */
    public List<LedgerLine> ledger() {
        lent.update();
        return engine.ledger();
    }

    /** Where the time went. */
    public AdapterProfile profile() {
        return new AdapterProfile(
                frames, redoneFrames, bindNanoseconds, copyNanoseconds, advanceNanoseconds);
    }

    /** Frees the rollback copy; the engine still borrows the columns until it is closed. */
    @Override
    public void close() {
        rollback.close();
    }

    private boolean advanced(FrameEvent frame) {
        try {
            world.activity().begin(advancing);
            engine.advance(frame.dtSeconds(), frame.steps());
            return true;
        } catch (PhysicsException failure) {
            List<Arrested> tried = List.copyOf(arrests);
            tried.forEach(one -> one.release.run());
            arrests.clear();
            rollback.restore();
            engine.clearFault();
            if (!arrestFor(failure, tried)) {
                laws.quarantine(frame.frame(), failure, itemOf(failure));
            }
            return false;
        } finally {
            world.activity().end();
        }
    }

    /**
     * Arrests those that were arrested before and one more, or all that may be to blame.
     *
     * @return false if none is left, or no law is to blame
     */
    private boolean arrestFor(PhysicsException failure, List<Arrested> tried) {
        Optional<Item> failed = itemOf(failure);
        List<Item> suspects = new ArrayList<>(world.arrests().suspects(failed));
        suspects.removeAll(tried.stream().map(Arrested::item).toList());
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
                : kindOf(failure).flatMap(kind -> lent.item(kind, failure.row().getAsLong()));
    }

    /** Whose rows a failure counts: what a law remembers of each row is a property of its own. */
    private Optional<String> kindOf(PhysicsException failure) {
        return laws.loaded().stream()
                .filter(law -> law.libraryId() == failure.libraryId())
                .flatMap(law -> law.uses().stream())
                .filter(use -> use.name().equals(failure.property()))
                .map(PropertyUse::kind)
                .findFirst();
    }

    private void keepWhatLawsMayWrite() {
        if (keptLayout != lent.lentLayout() || keptLaws != laws.version()) {
            rollback.keep(lent.columns(writtenProperties()));
            keptLayout = lent.lentLayout();
            keptLaws = laws.version();
            advancing =
                    "native code (advance) of the laws "
                            + laws.loaded().stream()
                                    .map(PhysicsLaw::name)
                                    .collect(Collectors.joining(", "));
        }
    }

    /** What laws write, and all accumulators: these the engine itself sets. */
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
