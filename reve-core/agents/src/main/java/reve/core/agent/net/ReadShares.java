// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

/**
 * Shares of the event loop's time for decoding messages. A message costs its bytes, because the
 * slowest ones take some 25 ns a byte. Each connection has a small allowance, which covers an agent
 * that acts in every frame; longer messages and faster agents share a pool, so that any number of
 * costly messages leaves most of the loop's time to others. The event loop's thread.
 */
final class ReadShares {

    /** Allowance of each connection [bytes/s]. */
    static final double OWN_PER_SECOND = 16 * 1024;

    /** Largest unused allowance of a connection [bytes]. */
    static final int OWN_MOST = 4 * 1024;

    /** What all connections share in a window, besides their allowances [bytes]. */
    static final int POOL = 128 * 1024;

    /** Largest part of the pool for one connection in a window, if it takes several messages. */
    static final int MOST_OF_POOL = POOL / 2;

    /** Length of a window. */
    static final long WINDOW_NANOS = 10_000_000;

    private long windowNanos;
    private long window;
    private long pool = POOL;

    /** What one connection may still send. */
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
     * Takes a message of this size.
     *
     * @return false if it must wait for a later window
     */
    boolean take(Share share, int bytes, long nowNanos) {
        share.own =
                Math.min(OWN_MOST, share.own + (nowNanos - share.nanos) * 1e-9 * OWN_PER_SECOND);
        share.nanos = nowNanos;
        if (bytes <= share.own) {
            share.own -= bytes;
            return true;
        }
        if (nowNanos - windowNanos >= WINDOW_NANOS) {
            windowNanos = nowNanos;
            window++;
            pool = POOL;
        }
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
}
