// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import java.util.concurrent.TimeUnit;
import java.util.function.Consumer;
import java.util.function.Supplier;

/**
 * A log with a limit on lines per second, so that clients cannot flood it. One more line reports
 * how many lines were suppressed. For any thread.
 */
public final class RateLimitedLog {

    private static final long SECOND_NANOS = TimeUnit.SECONDS.toNanos(1);

    private final Logger logger;
    private final int linesPerSecond;
    private final String subject;
    private boolean isLost;
    private long secondBegan = System.nanoTime();
    private int lines;
    private int leftOut;

    /**
     * @param subject the subject of the lines, for the report "7 more lines about SUBJECT"
     */
    public RateLimitedLog(int linesPerSecond, String subject) {
        this(LoggerFactory.getLogger("reve.agents"), linesPerSecond, subject);
    }

    RateLimitedLog(Logger logger, int linesPerSecond, String subject) {
        this.logger = logger;
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
     * Logs a line at level info.
     *
     * @param message evaluated only if the line is written
     */
    public void info(Supplier<String> message) {
        if (mayLog()) {
            write(logger::info, message.get());
        }
    }

    /**
     * Logs a line at level warning.
     *
     * @param message evaluated only if the line is written
     */
    public void warn(Supplier<String> message) {
        if (mayLog()) {
            write(logger::warn, message.get());
        }
    }

    /** Logs an error with its cause. */
    public void error(String message, Throwable cause) {
        if (mayLog()) {
            write(line -> logger.error(line, cause), message);
        }
    }

    /**
     * Writes a line. A class of the logging library may be missing, for example if the files of the
     * program were replaced while it runs. The caller must not end because of it.
     */
    private void write(Consumer<String> to, String line) {
        try {
            to.accept(line);
        } catch (LinkageError missing) {
            if (!isLost) {
                isLost = true;
                System.err.println(
                        "reve: the log cannot be written, because the program's files have changed; end"
                                + " this server and start it again");
            }
        }
    }

    private synchronized boolean mayLog() {
        long now = System.nanoTime();
        if (now - secondBegan >= SECOND_NANOS) {
            if (leftOut > 0) {
                write(logger::warn, leftOut + " more lines about " + subject + " were suppressed");
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
