// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/** Source of pictures from the cameras of agents' bodies. */
public interface Cameras {

    /**
     * A picture. Its layers contain the rows of pixels from top to bottom. Numbers are
     * little-endian.
     *
     * @param time simulated time of the world [s]
     * @param width [px]
     * @param height [px]
     * @param colour red, green and blue in sRGB, one byte each
     * @param depth along the view axis [m], f32; 0 if no surface is in range
     * @param items u16; 0 if no item is in range, otherwise the index of the item's name, counted
     *     from 1
     * @param names the names of the visible items
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

    /** Receiver of the result of a request. One of its methods is called once, on any thread. */
    interface Answer {
        /** Receives the picture. */
        void taken(Photo photo);

        /**
         * Receives a refusal.
         *
         * @param reason why no picture was taken, for the agent
         */
        void refused(String reason);

        /**
         * Receives a failure.
         *
         * @param cause the error, for the log only; internal errors are not sent to the agent
         */
        void failed(RuntimeException cause);
    }

    /** Takes a picture of the newest frame. For any thread; returns at once. */
    void take(ItemId body, Sensor camera, Answer answer);

    /** Returns an implementation that takes no pictures. */
    static Cameras none() {
        return (body, camera, answer) -> answer.refused("this server takes no pictures");
    }
}
