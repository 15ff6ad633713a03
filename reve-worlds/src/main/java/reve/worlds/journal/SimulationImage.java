// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.world.World;
import reve.core.world.WorldImage;
import reve.pe.adapter.PhysicsAdapter;
import reve.pe.adapter.PhysicsImage;

import java.util.List;
import java.util.function.Consumer;

/**
 * Everything a simulation is at the end of a frame. Any number of threads may read it and make
 * simulations from it, unless it is being filled.
 */
public final class SimulationImage implements AutoCloseable {
    private final WorldImage world;
    private final Consumer<SimulationImage> whenClosed;
    private PhysicsImage physics = new PhysicsImage(List.of(), List.of(), new byte[0]);

    /** Room for a world of this prototype; nothing in it yet. World's thread. */
    public SimulationImage(World like) {
        this(like, image -> {});
    }

    /**
     * @param whenClosed told when the image is closed
     */
    public SimulationImage(World like, Consumer<SimulationImage> whenClosed) {
        this.world = new WorldImage(like);
        this.whenClosed = whenClosed;
    }

    /**
     * Copies a world of the same prototype and its physics at the end of a frame. World's thread,
     * between frames or in PUBLISH.
     */
    public void copyFrom(World from, PhysicsAdapter itsPhysics, long frame) {
        world.copyFrom(from, frame);
        physics = itsPhysics.save();
    }

    /** For whoever fills the image of the world from elsewhere. */
    void setPhysics(PhysicsImage newPhysics) {
        physics = newPhysics;
    }

    /** The frame at whose end everything was like this. */
    public long frame() {
        return world.frame();
    }

    public WorldImage world() {
        return world;
    }

    public PhysicsImage physics() {
        return physics;
    }

    /** Size of the columns and of what the laws remember [bytes]. */
    public long bytes() {
        return world.bytes() + physics.engineState().length;
    }

    /** Frees the columns' memory. May be called twice. */
    @Override
    public void close() {
        whenClosed.accept(this);
        world.close();
    }
}
