// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.agent.lockstep.LockStep;
import reve.core.agent.net.EventLoop;
import reve.core.frame.FrameClock;

import java.util.function.BooleanSupplier;

/**
 * Runs the server's event loop on a world's thread while the world waits for agents in lock-step.
 * The thread would be idle otherwise.
 */
record LoopHelper(EventLoop loop) implements LockStep.Waiting {

    @Override
    public void await(long nanoseconds, BooleanSupplier enough, FrameClock clock) {
        loop.work(nanoseconds, enough);
    }

    @Override
    public void wake() {
        loop.wake();
    }
}
