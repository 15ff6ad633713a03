// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.agent.port.CarriedSession;

import java.io.IOException;
import java.util.List;
import java.util.OptionalLong;

/**
 * A store that this process has taken in order to continue its world. For one thread. Closing this
 * object releases the store for other processes. After {@link #open}, closing the sink releases the
 * store instead.
 */
public interface TakenStore extends AutoCloseable {
    /** Returns the content of the store. */
    StoreReading contents();

    /**
     * Returns the epoch in which this process writes; empty if only one process can open the store.
     */
    OptionalLong epoch();

    /**
     * Returns the sessions that this process can continue. If the previous server of the world
     * ended regularly, these are the sessions that it handed over after its last frame. If it was
     * lost, they are the sessions of its last frame.
     */
    default List<CarriedSession> sessions() {
        return List.of();
    }

    /**
     * Opens the store for writing. Call this method once, after a check that the content is
     * complete.
     *
     * @throws IOException if the store cannot be opened, or another process has it
     */
    JournalSink open() throws IOException;

    @Override
    void close();
}
