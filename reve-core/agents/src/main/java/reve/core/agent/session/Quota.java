// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

/**
 * How many messages of a client may still be taken: at most as many as in a second, which come back
 * with time. A second is one of the clock, or of the frames that are counted if these go faster. It
 * begins with few, so that nobody gains by coming anew. The event loop's thread.
 */
public final class Quota {

    /** What it begins with. */
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

    /** True if one more message may be taken. */
    boolean hasLeft(long nowNanos, long nowFrame) {
        double seconds =
                Math.max((nowNanos - nanos) * 1e-9, (double) (nowFrame - frame) / framesPerSecond);
        nanos = nowNanos;
        frame = nowFrame;
        left = Math.min(messagesPerSecond, left + seconds * messagesPerSecond);
        return left >= 1;
    }

    /** One that {@link #hasLeft} let through is taken. */
    void take() {
        left--;
    }
}
