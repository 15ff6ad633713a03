// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/** Pictures from the cameras of bodies. */
public interface Cameras {

    /**
     * A picture, in rows from the top; numbers are little-endian.
     *
     * @param time of the world [s]
     * @param width [px]
     * @param height [px]
     * @param colour red, green and blue in sRGB, one byte each
     * @param depth along the view axis [m], f32; 0 where nothing is in range
     * @param items u16; 0 where no item is in range, else the index of its name, from 1
     * @param names of the visible items
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

    /** Receives the result once, on any thread. */
    interface Answer {
        /** Receives the picture. */
        void taken(Photo photo);

        /**
         * Receives a refusal.
         *
         * @param reason for the agent
         */
        void refused(String reason);

        /**
         * Receives a failure.
         *
         * @param cause for the log only; the agent is not sent internal errors
         */
        void failed(RuntimeException cause);
    }

    /** Takes a picture of the newest frame. Any thread; returns at once. */
    void take(ItemId body, Sensor camera, Answer answer);

    /** Returns an implementation that takes no pictures. */
    static Cameras none() {
        return (body, camera, answer) -> answer.refused("this server takes no pictures");
    }
}
