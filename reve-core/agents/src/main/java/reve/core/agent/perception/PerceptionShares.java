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
 * The division of the event loop's time among the sessions that receive perceptions in real time.
 * Costly perceptions of some sessions do not delay the other sessions. Each token has an account
 * with a debt. Each session without a token has its own account. The time to compute and to write
 * perceptions increases the debt; equal shares of elapsed time reduce it. A session without debt
 * whose perceptions are cheap is served at once. The other sessions wait, and are served in slices
 * of time, in the order of increasing debt. Between two slices the event loop does its other work.
 * Sessions in lock-step are charged but served at once, because the world waits for them. See
 * docs/decisions/0006. For the event loop's thread only, except {@link Cost#wrote}.
 *
 * @param <C> type of a client
 */
public final class PerceptionShares<C extends PerceptionShares.Client> {

    /** Duration of a slice for waiting sessions [ns]. */
    private static final double SLICE_NANOS = 10e6;

    /** Estimated cost of a session's first perception, used until a cost is measured [ns]. */
    private static final double FIRST_NANOS = 1e6;

    /**
     * Factor by which the estimate for first perceptions decreases if the measured cost does not
     * exceed the estimate.
     */
    private static final double MEMORY = 0.9;

    /**
     * A perception is cheap if it costs at most this time divided by the number of accounts [ns].
     */
    private static final double CHEAP_NANOS = 50e6;

    /**
     * A perception is also cheap if it costs at most this time, for any number of accounts [ns].
     */
    private static final double CHEAP_FOR_ALL_NANOS = 30e3;

    private final Map<String, Account> byToken = new HashMap<>();
    private final List<Account> active = new ArrayList<>();
    private final List<C> waiting = new ArrayList<>();
    private long round;
    private long paidNanos;

    /** Time left in this slice [ns]. */
    private double sliceNanos;

    /** Maximum cost of a cheap perception in this slice [ns]. */
    private double cheapNanos;

    private double firstNanos = FIRST_NANOS;

    /** A client that receives perceptions. */
    public interface Client {
        /** Returns the cost of the client's perceptions. */
        Cost perceptionCost();

        /** Returns whether the client is in lock-step, which means that the world waits for it. */
        boolean isInLockStep();

        /** Returns whether the client is to receive a perception of a frame. */
        boolean perceives(long frame);
    }

    /**
     * The account of a token's sessions. Its debt is the part of the cost that the sessions' shares
     * of time have not covered yet [ns].
     */
    private static final class Account {
        private double owedNanos;
        private long round;
    }

    /** Cost of one session's perceptions. */
    public static final class Cost {
        private final Account account;

        /** Time spent since the session was last served [ns]. */
        private double spentNanos;

        /** Cost of the last perception [ns]. */
        private double expectedNanos;

        /** True after the cost of a perception was measured. */
        private boolean known;

        /**
         * Writing time that is not charged yet [ns]. Set by the writing thread, while the event
         * loop waits for it.
         */
        private long writtenNanos;

        private Cost(Account account) {
            this.account = account;
        }

        /** Adds the time for writing a perception [ns]. */
        public void wrote(long nanos) {
            writtenNanos += nanos;
        }
    }

    /** Creates shares without sessions. */
    public PerceptionShares(long nowNanos) {
        paidNanos = nowNanos;
    }

    /**
     * Returns the cost object of a new session.
     *
     * @param tokenName name of the client's token, if the server uses tokens
     */
    public Cost cost(Optional<String> tokenName) {
        return new Cost(
                tokenName
                        .map(name -> byToken.computeIfAbsent(name, unknown -> new Account()))
                        .orElseGet(Account::new));
    }

    /**
     * Begins a slice. Reduces the debt of each account by its share of the time since the previous
     * slice.
     *
     * @param frame number of the frame whose perceptions are sent
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

    /** Charges the writing time since the last call to the account. */
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

    /** Returns whether a session is served at once. If not, the session waits. */
    public boolean isServedNow(C client) {
        Cost cost = client.perceptionCost();
        if (client.isInLockStep()
                || cost.known && cost.account.owedNanos == 0 && cost.expectedNanos <= cheapNanos) {
            return true;
        }
        waiting.add(client);
        return false;
    }

    /** Makes a session wait, even if its perceptions are cheap. */
    public void postpone(C client) {
        waiting.add(client);
    }

    /**
     * Returns the waiting sessions, those with the lowest debt first. Among sessions with equal
     * debt, those that have received a perception before come first. The caller serves the sessions
     * while {@link #isTimeLeft} is true.
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

    /** Charges the time spent on a session whose perception is not complete yet [ns]. */
    public void spend(Cost cost, long nanos) {
        sliceNanos -= nanos;
        charge(cost, nanos);
    }

    /**
     * Charges the time for a session that was served [ns]. The time to write its perception is
     * charged later.
     */
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
