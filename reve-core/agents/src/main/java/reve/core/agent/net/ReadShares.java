// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

/**
 * Shares of the event loop's time for decoding messages. The cost of a message is its size, because
 * the time to decode a message is at most proportional to its size. Each connection has a small
 * allowance, which suffices for an agent that acts in every frame. Longer messages and faster
 * agents share a pool, so that they leave most of the loop's time to others. For the event loop's
 * thread only.
 */
final class ReadShares {

    /** Allowance of each connection [bytes/s]. */
    static final double OWN_PER_SECOND = 16 * 1024;

    /** Largest unused allowance of a connection [bytes]. */
    static final int OWN_MOST = 4 * 1024;

    /**
     * Size of the pool that all connections share in each window, in addition to their allowances
     * [bytes].
     */
    static final int POOL = 128 * 1024;

    /**
     * Largest part of the pool that one connection may take per window with several messages
     * [bytes]. A single message may take more.
     */
    static final int MOST_OF_POOL = POOL / 2;

    /** Duration of a window, after which the pool is full again [ns]. */
    static final long WINDOW_NANOS = 10_000_000;

    private long windowNanos;
    private long window;
    private long pool = POOL;

    /** The unused allowance of one connection, and its use of the pool. */
    static final class Share {
        private double own = OWN_MOST;
        private long nanos;
        private long window = -1;
        private long pooled;
    }

    /** Returns the share of a new connection. */
    Share open(long nowNanos) {
        var share = new Share();
        share.nanos = nowNanos;
        return share;
    }

    /**
     * Takes the size of a message from the connection's allowance. Takes the size from the pool if
     * the allowance is too small.
     *
     * @return false if the message must wait for a later window
     */
    boolean take(Share share, int bytes, long nowNanos) {
        share.own =
                Math.min(OWN_MOST, share.own + (nowNanos - share.nanos) * 1e-9 * OWN_PER_SECOND);
        share.nanos = nowNanos;
        if (bytes <= share.own) {
            share.own -= bytes;
            return true;
        }
        begin(nowNanos);
        if (share.window != window) {
            share.window = window;
            share.pooled = 0;
        }
        boolean fits = share.pooled == 0 || share.pooled + bytes <= MOST_OF_POOL;
        if (pool <= 0 || !fits) {
            return false;
        }
        share.pooled += bytes;
        pool -= bytes;
        return true;
    }

    /** Returns whether the pool of this window is not used up. */
    boolean hasLeft(long nowNanos) {
        begin(nowNanos);
        return pool > 0;
    }

    /** Begins a new window if the last one is over. */
    private void begin(long nowNanos) {
        if (nowNanos - windowNanos >= WINDOW_NANOS) {
            windowNanos = nowNanos;
            window++;
            pool = POOL;
        }
    }
}
