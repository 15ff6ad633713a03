// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.net.Client;
import reve.core.agent.net.RateLimitedLog;

import java.util.HashSet;
import java.util.Set;

/**
 * The sessions of clients without a token that wait for a new connection. Their number is limited.
 * For any thread.
 */
public final class KeptSessions {

    private final int most;
    private final RateLimitedLog log;
    private final Set<Client> kept = new HashSet<>();

    /** Creates an empty collection for at most {@code most} sessions. */
    public KeptSessions(int most, RateLimitedLog log) {
        this.most = most;
        this.log = log;
    }

    /**
     * Adds a session without a token.
     *
     * @return false if the limit is reached
     */
    boolean keep(Client session) {
        synchronized (kept) {
            if (kept.size() < most) {
                kept.add(session);
                return true;
            }
        }
        log.warn(
                () ->
                        session
                                + " leaves at once: "
                                + most
                                + " sessions without a token wait for their clients already");
        return false;
    }

    /** Removes a session that was resumed or has ended. Does nothing if the session is absent. */
    void keepNoLonger(Client session) {
        synchronized (kept) {
            kept.remove(session);
        }
    }
}
