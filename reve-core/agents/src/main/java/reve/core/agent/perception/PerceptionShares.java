// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import java.util.ArrayList;
import java.util.Collection;
import java.util.Comparator;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Divides the event loop's time among sessions that perceive in real time, so that costly
 * perceptions of some do not delay the others. Each token has an account, and so has each session
 * without a token. The time to compute and to write perceptions is charged to the account; equal
 * shares of elapsed time reduce it. A session without debt and with cheap perceptions is served at
 * once. The other sessions wait and are served in slices of time, the lowest debt first; between
 * two slices the event loop does its other work. Sessions in lock-step are charged but served at
 * once, because the world waits for them. See docs/decisions/0006. The event loop's thread, except
 * {@link Cost#wrote}.
 *
 * @param <C> a client
 */
public final class PerceptionShares<C extends PerceptionShares.Client> {

    /** Duration of a slice for waiting sessions [ns]. */
    private static final double SLICE_NANOS = 10e6;

    /** Estimated cost of a session's first perception before one was measured [ns]. */
    private static final double FIRST_NANOS = 1e6;

    /** Weight of the former estimate in the average of first perceptions. */
    private static final double MEMORY = 0.9;

    /** A perception is cheap if it costs at most an equal share of this time [ns]. */
    private static final double CHEAP_NANOS = 50e6;

    /** A perception is also cheap if it costs at most this, for any number of sessions [ns]. */
    private static final double CHEAP_FOR_ALL_NANOS = 30e3;

    private final Map<String, Account> byToken = new HashMap<>();
    private final List<Account> active = new ArrayList<>();
    private final List<C> waiting = new ArrayList<>();
    private long round;
    private long paidNanos;

    /** Time left in this slice. */
    private double sliceNanos;

    /** Sessions with a higher cost wait. */
    private double cheapNanos;

    private double firstNanos = FIRST_NANOS;

    /** A client with perceptions. */
    public interface Client {
        /** Returns the cost of the client's perceptions. */
        Cost perceptionCost();

        /** Returns whether the world waits for the client. */
        boolean isInLockStep();

        /** Returns whether the client perceives a frame. */
        boolean perceives(long frame);
    }

    /** Cost of a token's sessions that is not paid yet. */
    private static final class Account {
        private double owedNanos;
        private long round;
    }

    /** Cost of one session's perceptions. */
    public static final class Cost {
        private final Account account;

        /** Time spent since the session was served last. */
        private double spentNanos;

        /** Cost of its last perception. */
        private double expectedNanos;

        /** True if a perception was measured. */
        private boolean known;

        /** Written by the thread that writes to the session while the event loop waits for it. */
        private long writtenNanos;

        private Cost(Account account) {
            this.account = account;
        }

        /** Adds the time for writing a perception. */
        public void wrote(long nanos) {
            writtenNanos += nanos;
        }
    }

    /** Creates shares without sessions. */
    public PerceptionShares(long nowNanos) {
        paidNanos = nowNanos;
    }

    /**
     * @param tokenName name of the client's token, if the server uses tokens
     */
    public Cost cost(Optional<String> tokenName) {
        return new Cost(
                tokenName
                        .map(name -> byToken.computeIfAbsent(name, unknown -> new Account()))
                        .orElseGet(Account::new));
    }

    /**
     * Begins a slice. Reduces all accounts by their shares of the time since the previous slice.
     *
     * @param frame the frame to perceive
     */
    public void begin(Collection<? extends C> members, long frame, long nowNanos) {
        round++;
        active.clear();
        waiting.clear();
        for (C member : members) {
            Cost cost = member.perceptionCost();
            settle(cost);
            if (cost.account.round != round
                    && (cost.account.owedNanos > 0 || member.perceives(frame))) {
                cost.account.round = round;
                active.add(cost.account);
            }
        }
        int shares = Math.max(1, active.size());
        double share = (double) (nowNanos - paidNanos) / shares;
        paidNanos = nowNanos;
        active.forEach(account -> account.owedNanos = Math.max(0, account.owedNanos - share));
        cheapNanos = Math.max(CHEAP_FOR_ALL_NANOS, CHEAP_NANOS / shares);
        sliceNanos = SLICE_NANOS;
    }

    /** Charges the writing time since the last call. */
    private void settle(Cost cost) {
        if (cost.writtenNanos == 0) {
            return;
        }
        charge(cost, cost.writtenNanos);
        cost.writtenNanos = 0;
        if (!cost.known) {
            firstNanos = Math.max(cost.spentNanos, MEMORY * firstNanos);
        }
        cost.expectedNanos = cost.spentNanos;
        cost.known = true;
    }

    /** Returns whether a session is served at once; otherwise it waits. */
    public boolean isServedNow(C client) {
        Cost cost = client.perceptionCost();
        if (client.isInLockStep()
                || cost.known && cost.account.owedNanos == 0 && cost.expectedNanos <= cheapNanos) {
            return true;
        }
        waiting.add(client);
        return false;
    }

    /**
     * Returns the waiting sessions: the lowest debt first, and without debt those that have
     * perceived before. Serve them while {@link #isTimeLeft} is true.
     */
    public List<C> waiting() {
        waiting.sort(
                Comparator.comparingDouble((C client) -> client.perceptionCost().account.owedNanos)
                        .thenComparing(client -> !client.perceptionCost().known));
        return waiting;
    }

    /** Returns whether the slice is not used up. */
    public boolean isTimeLeft() {
        return sliceNanos > 0;
    }

    /** Charges the time for a session that could not be served yet. */
    public void spend(Cost cost, long nanos) {
        sliceNanos -= nanos;
        charge(cost, nanos);
    }

    /** Charges the time for a session that was served; its writing time is added later. */
    public void serve(Cost cost, long nanos) {
        sliceNanos -= Math.max(nanos, cost.known ? cost.expectedNanos : firstNanos);
        cost.spentNanos = 0;
        charge(cost, nanos);
    }

    private static void charge(Cost cost, double nanos) {
        cost.spentNanos += nanos;
        cost.account.owedNanos += nanos;
    }
}
