// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/** Takes the pictures of cameras that bodies carry. */
public interface Cameras {

    /**
     * What a camera saw, row by row from the top; numbers are little-endian.
     *
     * @param time of the world [s]
     * @param width [px]
     * @param height [px]
     * @param colour red, green and blue in sRGB, a byte each
     * @param depth along the view [m], f32; 0 where nothing is in range
     * @param items u16; 0 where no item is in range, else its place in the names, from 1
     * @param names of the items that are seen
     */
    record Photo(
            long frame,
            double time,
            int width,
            int height,
            Optional<byte[]> colour,
            Optional<byte[]> depth,
            Optional<byte[]> items,
            List<String> names) {}

    /** Told once how it went, on any thread. */
    interface Answer {
        /** The picture is there. */
        void taken(Photo photo);

        /** There is none now. @param reason for the agent */
        void refused(String reason);

        /**
         * It could not be drawn.
         *
         * @param cause for the log; the agent is not told of what is inside the server
         */
        void failed(RuntimeException cause);
    }

    /** Takes a picture of the newest frame. Any thread; returns at once. */
    void take(ItemId body, Sensor camera, Answer answer);

    /** None at all. */
    static Cameras none() {
        return (body, camera, answer) -> answer.refused("this server takes no pictures");
    }
}
