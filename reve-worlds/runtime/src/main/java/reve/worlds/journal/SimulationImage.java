// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.world.World;
import reve.core.world.WorldImage;
import reve.pe.adapter.PhysicsAdapter;
import reve.pe.adapter.PhysicsImage;

import java.util.List;
import java.util.function.Consumer;

/**
 * The complete state of a simulation at the end of a frame. Any number of threads may read a filled
 * image and build simulations from it.
 */
public final class SimulationImage implements AutoCloseable {
    private final WorldImage world;
    private final Consumer<SimulationImage> whenClosed;
    private PhysicsImage physics = new PhysicsImage(List.of(), List.of(), new byte[0]);

    /**
     * Allocates an empty image for worlds of the same prototype as {@code like}. For the world's
     * thread only.
     */
    public SimulationImage(World like) {
        this(like, image -> {});
    }

    /**
     * Allocates an image like {@link #SimulationImage(World)}.
     *
     * @param whenClosed called when the image is closed
     */
    public SimulationImage(World like, Consumer<SimulationImage> whenClosed) {
        this.world = new WorldImage(like);
        this.whenClosed = whenClosed;
    }

    /**
     * Copies into this image a world of the same prototype and its physics at the end of a frame.
     * For the world's thread, between frames or in PUBLISH.
     */
    public void copyFrom(World from, PhysicsAdapter itsPhysics, long frame) {
        world.copyFrom(from, frame);
        physics = itsPhysics.save();
    }

    /** Sets the physics part of the image; its world part was filled separately. */
    void setPhysics(PhysicsImage newPhysics) {
        physics = newPhysics;
    }

    /** Returns the number of the frame at whose end the state was copied. */
    public long frame() {
        return world.frame();
    }

    /** Returns the world's part of the image. */
    public WorldImage world() {
        return world;
    }

    /** Returns the engine's part of the image. */
    public PhysicsImage physics() {
        return physics;
    }

    /** Returns the size of the columns and of the laws' own state [bytes]. */
    public long bytes() {
        return world.bytes() + physics.engineState().length;
    }

    /** Frees the memory of the columns. Idempotent. */
    @Override
    public void close() {
        whenClosed.accept(this);
        world.close();
    }
}
