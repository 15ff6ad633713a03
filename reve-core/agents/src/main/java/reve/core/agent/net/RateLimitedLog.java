// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import java.util.concurrent.TimeUnit;
import java.util.function.Supplier;

/**
 * A log that clients cannot flood: so many lines a second, then one that says how many were left
 * out. Any thread.
 */
public final class RateLimitedLog {

    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");
    private static final long SECOND_NANOS = TimeUnit.SECONDS.toNanos(1);

    private final int linesPerSecond;
    private final String who;
    private long secondBegan = System.nanoTime();
    private int lines;
    private int leftOut;

    /**
     * @param who the lines are about, as in "7 more lines about WHO"
     */
    public RateLimitedLog(int linesPerSecond, String who) {
        this.linesPerSecond = linesPerSecond;
        this.who = who;
    }

    /** Logs a line that informs. */
    public void info(String message) {
        info(() -> message);
    }

    /** Logs a line that warns. */
    public void warn(String message) {
        warn(() -> message);
    }

    /**
     * @param message put together only where it is written
     */
    public void info(Supplier<String> message) {
        if (mayLog()) {
            LOG.info(message.get());
        }
    }

    /**
     * @param message put together only where it is written
     */
    public void warn(Supplier<String> message) {
        if (mayLog()) {
            LOG.warn(message.get());
        }
    }

    /** Logs an error with its cause. */
    public void error(String message, Throwable cause) {
        if (mayLog()) {
            LOG.error(message, cause);
        }
    }

    private synchronized boolean mayLog() {
        long now = System.nanoTime();
        if (now - secondBegan >= SECOND_NANOS) {
            if (leftOut > 0) {
                LOG.warn("{} more lines about {} were left out", leftOut, who);
            }
            secondBegan = now;
            lines = 0;
            leftOut = 0;
        }
        boolean may = lines < linesPerSecond;
        if (may) {
            lines++;
        } else {
            leftOut++;
        }
        return may;
    }
}
