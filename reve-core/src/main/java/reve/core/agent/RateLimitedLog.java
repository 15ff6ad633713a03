package reve.core.agent;

import java.util.concurrent.TimeUnit;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

/** A log that clients cannot flood: so many lines a second, then one that says how many were left out. Any thread. */
final class RateLimitedLog {

    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");
    private static final int LINES_PER_SECOND = 10;
    private static final long SECOND_NANOS = TimeUnit.SECONDS.toNanos(1);

    private long secondBegan = System.nanoTime();
    private int lines;
    private int leftOut;

    void info(String message) {
        if (mayLog()) {
            LOG.info(message);
        }
    }

    void warn(String message) {
        if (mayLog()) {
            LOG.warn(message);
        }
    }

    void error(String message, Throwable cause) {
        if (mayLog()) {
            LOG.error(message, cause);
        }
    }

    private synchronized boolean mayLog() {
        long now = System.nanoTime();
        if (now - secondBegan >= SECOND_NANOS) {
            if (leftOut > 0) {
                LOG.warn("{} more lines about agents were left out", leftOut);
            }
            secondBegan = now;
            lines = 0;
            leftOut = 0;
        }
        boolean may = lines < LINES_PER_SECOND;
        if (may) {
            lines++;
        } else {
            leftOut++;
        }
        return may;
    }
}
