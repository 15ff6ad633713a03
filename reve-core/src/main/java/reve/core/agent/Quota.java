package reve.core.agent;

/**
 * How many messages a client may still send: at most as many as in a second, which come back with time. A second is
 * one of the clock, or of the world if that goes faster. The event loop's thread.
 */
final class Quota {

    private final int messagesPerSecond;
    private final int framesPerSecond;
    private double left;
    private long nanos;
    private long frame;

    Quota(int messagesPerSecond, int framesPerSecond, long nowNanos, long frame) {
        this.messagesPerSecond = messagesPerSecond;
        this.framesPerSecond = framesPerSecond;
        this.left = messagesPerSecond;
        this.nanos = nowNanos;
        this.frame = frame;
    }

    /** One more message. @return false if it is too many */
    boolean take(long nowNanos, long nowFrame) {
        double seconds = Math.max((nowNanos - nanos) * 1e-9, (double) (nowFrame - frame) / framesPerSecond);
        nanos = nowNanos;
        frame = nowFrame;
        left = Math.min(messagesPerSecond, left + seconds * messagesPerSecond);
        if (left < 1) {
            return false;
        }
        left--;
        return true;
    }
}
