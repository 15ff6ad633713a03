// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

/**
 * Limit on how often new connections may resume a session. A burst of resumes is allowed. After the
 * burst, {@value #PER_SECOND} resumes per second are allowed. Guarded by the lock of its session.
 */
public final class Resumes {

    static final int PER_SECOND = 4;

    private final int most;
    private double left;
    private long countedNanos;

    /**
     * @param most size of the burst
     */
    Resumes(int most, long nowNanos) {
        this.most = most;
        this.left = most;
        this.countedNanos = nowNanos;
    }

    /**
     * Counts a resume.
     *
     * @return false if the limit is exceeded
     */
    boolean take(long nowNanos) {
        left = Math.min(most, left + (nowNanos - countedNanos) * PER_SECOND / 1e9);
        countedNanos = nowNanos;
        if (left < 1) {
            return false;
        }
        left--;
        return true;
    }
}
