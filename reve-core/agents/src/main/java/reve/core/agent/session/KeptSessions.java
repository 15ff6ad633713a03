// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.net.Client;
import reve.core.agent.net.RateLimitedLog;

import java.util.HashSet;
import java.util.Set;

/** Sessions without a token that wait for their client to come back. Any thread. */
public final class KeptSessions {

    private final int most;
    private final RateLimitedLog log;
    private final Set<Client> kept = new HashSet<>();

    /** Keeps no session yet. */
    public KeptSessions(int most, RateLimitedLog log) {
        this.most = most;
        this.log = log;
    }

    /** Keeps a session without a token for its client. @return false if there are too many */
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

    /** Its client is back, or its time is over. Does nothing if it was not kept. */
    void keepNoLonger(Client session) {
        synchronized (kept) {
            kept.remove(session);
        }
    }
}
