// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import java.util.concurrent.TimeUnit;
import java.util.function.Supplier;

/**
 * A log with a limit on lines per second, so that clients cannot flood it. One more line reports
 * how many lines were suppressed. For any thread.
 */
public final class RateLimitedLog {

    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");
    private static final long SECOND_NANOS = TimeUnit.SECONDS.toNanos(1);

    private final int linesPerSecond;
    private final String subject;
    private long secondBegan = System.nanoTime();
    private int lines;
    private int leftOut;

    /**
     * @param subject the subject of the lines, for the report "7 more lines about SUBJECT"
     */
    public RateLimitedLog(int linesPerSecond, String subject) {
        this.linesPerSecond = linesPerSecond;
        this.subject = subject;
    }

    /** Logs a line at level info. */
    public void info(String message) {
        info(() -> message);
    }

    /** Logs a line at level warning. */
    public void warn(String message) {
        warn(() -> message);
    }

    /**
     * @param message evaluated only if the line is written
     */
    public void info(Supplier<String> message) {
        if (mayLog()) {
            LOG.info(message.get());
        }
    }

    /**
     * @param message evaluated only if the line is written
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
                LOG.warn("{} more lines about {} were suppressed", leftOut, subject);
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
