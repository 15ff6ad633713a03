// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.util.OptionalLong;

/**
 * A store that this process has taken in order to continue its world. For one thread. Closing it
 * gives the store back, unless its sink was opened; the sink then does so.
 */
public interface TakenStore extends AutoCloseable {
    /** Returns the content of the store. */
    StoreReading contents();

    /**
     * Returns the epoch in which this process writes; empty if only one process can open the store.
     */
    OptionalLong epoch();

    /**
     * Opens the store for writing. Call it once, after the content was found whole.
     *
     * @throws IOException if the store cannot be opened, or another process has it
     */
    JournalSink open() throws IOException;

    @Override
    void close();
}
