// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.io.IOException;
import java.time.Duration;
import java.util.Optional;

/** The data of a {@link FrameFeed}, on the server that reads it. For one thread. */
public interface FrameSource extends AutoCloseable {
    /**
     * Waits for the next data.
     *
     * @return empty if there is none in this time
     * @throws IOException if the feed has ended, or the other server cannot be reached
     */
    Optional<byte[]> next(Duration timeout) throws IOException, InterruptedException;

    @Override
    void close();

    /** A function that connects to the server that runs a world. */
    interface Connector {
        /**
         * Opens a feed of the world.
         *
         * @throws IOException with the reason, if no server runs the world now or it cannot be
         *     reached
         */
        FrameSource connect(String world) throws IOException, InterruptedException;
    }
}
