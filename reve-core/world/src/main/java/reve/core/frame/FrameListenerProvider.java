// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import reve.core.world.World;

/**
 * A maker of frame listeners. A plugin lists its providers in {@code
 * META-INF/services/reve.core.frame.FrameListenerProvider}. Each world that makes frames has its
 * own listener of each provider. All worlds of a process share the provider.
 */
public interface FrameListenerProvider {
    /** Returns the name of the listener for messages, for example {@code example.counter}. */
    String name();

    /** Returns one sentence that describes what the listener does. */
    String doc();

    /**
     * Returns the listener for a world. Called once for each world, on the world's thread, before
     * the first frame that this process makes.
     *
     * <p>The world calls the listener once in each frame, on the world's thread, in the phase ACT:
     * after the commands of the frame, and before the laws. The listener may read and change the
     * world, add and remove items, and raise events. The listener must make the same changes in the
     * same state of the world, so it must not use a clock or random numbers. A recording contains
     * its changes, so {@code replay} repeats them without the listener.
     *
     * <p>A rewind or the end of the process loses the data in the fields of the listener. The
     * listener must therefore store all data that it needs later in the world, for example as
     * symbols of items.
     *
     * <p>The frame waits for the listener without a time limit, so the listener must not sleep or
     * block. If it throws an exception, the world raises an event {@code fault} and does not call
     * it again. Changes that it made before the exception remain.
     */
    FrameListener listen(World world);
}
