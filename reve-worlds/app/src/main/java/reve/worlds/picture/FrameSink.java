// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import java.awt.image.BufferedImage;
import java.io.IOException;

/**
 * A video that receives its pictures in order. For one thread. The video appears at its place only
 * after {@link #finish()}.
 */
public interface FrameSink extends AutoCloseable {
    /**
     * Adds a picture. All pictures of a video have the same size.
     *
     * @throws IOException if it cannot be written
     */
    void add(BufferedImage picture) throws IOException;

    /**
     * Completes the video and moves it to its place.
     *
     * @throws IOException if it cannot be written or moved
     */
    void finish() throws IOException;

    /** Removes the written data unless the video is complete. */
    @Override
    void close() throws IOException;
}
