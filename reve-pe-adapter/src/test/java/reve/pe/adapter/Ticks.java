// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import java.util.concurrent.locks.LockSupport;

/**
 * Frames of a world at 60 Hz, and their number in the last second. If a frame begins late, the next
 * frames do not make up for it.
 */
final class Ticks {
    private static final long FRAME_NANOS = 1_000_000_000L / 60;

    private long next = System.nanoTime();

    /** Waits for the time of the next frame, and makes it. */
    void run(AdapterFixture world) {
        for (long wait = next - System.nanoTime(); wait > 0; wait = next - System.nanoTime()) {
            LockSupport.parkNanos(wait);
        }
        next = Math.max(next, System.nanoTime() - FRAME_NANOS) + FRAME_NANOS;
        world.run(1);
    }

    /** Makes frames for a second, and returns their number as a fraction of 60. */
    double second(AdapterFixture world) {
        long end = System.nanoTime() + 1_000_000_000L;
        int frames = 0;
        while (System.nanoTime() < end) {
            run(world);
            frames++;
        }
        return frames / 60.0;
    }
}
