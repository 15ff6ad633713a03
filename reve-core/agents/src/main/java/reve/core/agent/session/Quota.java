// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

/**
 * The number of messages that a client may still send. It is at most the number for one second, and
 * grows again over time. Seconds are counted in elapsed time, or in world time if the world is
 * faster. A new quota begins with few messages, so that a client gains nothing by reconnecting. For
 * the event loop's thread only.
 */
public final class Quota {

    /** Initial number of messages. */
    static final int FIRST = 64;

    private final int messagesPerSecond;
    private final int framesPerSecond;
    private double left;
    private long nanos;
    private long frame;

    Quota(int messagesPerSecond, int framesPerSecond, long nowNanos, long frame) {
        this.messagesPerSecond = messagesPerSecond;
        this.framesPerSecond = framesPerSecond;
        this.left = Math.min(FIRST, messagesPerSecond);
        this.nanos = nowNanos;
        this.frame = frame;
    }

    /** Returns whether one more message is allowed. */
    boolean hasLeft(long nowNanos, long nowFrame) {
        double seconds =
                Math.max((nowNanos - nanos) * 1e-9, (double) (nowFrame - frame) / framesPerSecond);
        nanos = nowNanos;
        frame = nowFrame;
        left = Math.min(messagesPerSecond, left + seconds * messagesPerSecond);
        return left >= 1;
    }

    /** Subtracts a message that {@link #hasLeft} allowed. */
    void take() {
        left--;
    }
}
