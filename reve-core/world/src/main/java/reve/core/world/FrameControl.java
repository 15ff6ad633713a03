// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Map;
import java.util.Optional;
import java.util.SortedSet;

/**
 * The operations on a world that only few callers need. These callers are the frame loop, the first
 * listener of the phase DERIVE, and tests that make frames themselves. For the world's thread only.
 */
public final class FrameControl {

    private final WorldData data;
    private final Forces forces;
    private final LawSizes sizes;

    FrameControl(WorldData data, Forces forces, Items items) {
        this.data = data;
        this.forces = forces;
        this.sizes = new LawSizes(data, items);
    }

    /** Returns the frame control of a world. */
    public static FrameControl of(World world) {
        return world.frameControl();
    }

    /** Sets the number of frames per second of world time. */
    public void setFramesPerSecond(int framesPerSecond) {
        forces.setFramesPerSecond(framesPerSecond);
    }

    /** Begins a frame: increments the age of the world. */
    public void begin() {
        data.guard.checkOwner();
        data.age++;
    }

    /**
     * Refuses to add or remove items until {@link #unlock()}. Messages of refusals name the phase.
     */
    public void lock(String phase) {
        data.guard.lockStructure(phase);
    }

    /** Permits adding and removing items again. */
    public void unlock() {
        data.guard.unlockStructure();
    }

    /** Adds the forces of actions to the column {@code appliedForce}, before the phase PHYSICS. */
    public void applyForces() {
        forces.apply();
    }

    /**
     * Makes the shapes of bodies follow the column {@code size}. Called after laws that may write
     * this column, in the phase PHYSICS. Allocates memory only for shapes that change. These
     * changes are not recorded, like other changes by laws.
     *
     * <p>A sphere takes its diameter from the first component. A capsule or cylinder takes its
     * diameter from the first and its height from the second component. A capsule is at least as
     * high as wide. A box or ellipsoid takes all three. A plane takes its edges from the first and
     * the third component. Meshes and bodies without a shape keep their size. The other components
     * of the column are set to the size of the shape.
     *
     * <p>If a shape cannot have the size, because a length is not within 1e-100 m to 1e12 m, the
     * body keeps its shape, and its numbers in the column are set to the size of this shape.
     *
     * @return the refused size of the body in the first row that has one
     */
    public Optional<RefusedSize> followSizes() {
        data.guard.requireEditable();
        return sizes.follow();
    }

    /**
     * Ends the phase PHYSICS. Removes the forces of actions from {@code appliedForce}, which then
     * has the same bits as before the phase. Frees replaced column memory, because the engine uses
     * the new memory by then.
     */
    public void endPhysics() {
        data.guard.checkOwner();
        forces.withdraw();
        data.layout.releaseReplaced();
    }

    /**
     * Computes the places of attached items from those of their parents. Called in the phase
     * DERIVE, before other listeners.
     */
    public void placeAttached() {
        data.guard.checkOwner();
        data.hierarchy.place();
    }

    /**
     * Records that the boxes around bodies were computed in the phase DERIVE, so that spatial
     * searches use them.
     */
    public void boundsDerived() {
        data.guard.checkOwner();
        data.boundsChanged();
    }

    /**
     * Returns a view of the ids of the items with an {@link Instrument.Imu}, in ascending order.
     */
    public SortedSet<ItemId> withImu() {
        data.guard.checkOwner();
        return data.symbols.withImu();
    }

    /**
     * Returns a view of the ids of the items whose levels have conditions, in ascending order; see
     * {@link LevelCondition}.
     */
    public SortedSet<ItemId> withLevelConditions() {
        data.guard.checkOwner();
        return data.symbols.withConditions();
    }

    /**
     * Returns a view of the ids of the items with an {@link Instrument.Provided}, in ascending
     * order.
     */
    public SortedSet<ItemId> withProvided() {
        data.guard.checkOwner();
        return data.symbols.withProvided();
    }

    /**
     * Sets the numbers that the providers of sensors have measured in this frame. Snapshots contain
     * them.
     *
     * @param readings numbers by item and name of the sensor; the maps and arrays must not change
     *     afterwards
     */
    public void setReadings(Map<ItemId, Map<String, double[]>> readings) {
        data.guard.checkOwner();
        data.readings = readings;
    }

    /**
     * Writes three numbers that were computed in the phase DERIVE into a column of bodies.
     *
     * @param property name of a property of bodies with three components
     */
    public void derive(String property, int row, double x, double y, double z) {
        data.guard.checkOwner();
        Table bodies = data.table(WorldPrototype.BODY);
        Column column = bodies.column(property);
        boolean seenByLaws = row < bodies.physicsRowCount();
        column.derive(row, 0, x, seenByLaws);
        column.derive(row, 1, y, seenByLaws);
        column.derive(row, 2, z, seenByLaws);
    }

    /** Begins the phase PUBLISH. Events and changes from now on belong to the next frame. */
    public void publish() {
        data.guard.checkOwner();
        data.record.fix();
    }

    /** Ends a frame: discards its events and changes, and permits adding and removing items. */
    public void end() {
        data.guard.checkOwner();
        data.record.end();
        data.guard.unlockStructure();
    }
}
