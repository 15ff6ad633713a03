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
 * Shares the event loop's time among the sessions that perceive in real time, so that costly
 * perceptions of some do not delay the perceptions of others. Each token has an account, and so has
 * each session without a token. The time to find and to write perceptions is charged to the
 * account; equal shares of the time that passes reduce it. A session without debts whose
 * perceptions are cheap is served at once. The other sessions wait and are served in slices of
 * time, the least indebted first; between two slices the event loop does its other work. Sessions
 * in lock-step are charged, too, but served at once, because the world waits for them. See
 * docs/decisions/0006. The event loop's thread, but for {@link Cost#wrote}.
 *
 * @param <C> who perceives
 */
public final class PerceptionShares<C extends PerceptionShares.Client> {

    /** A slice of the time of those who wait [ns]. */
    private static final double SLICE_NANOS = 10e6;

    /** What a first perception is taken to cost before one has been seen [ns]. */
    private static final double FIRST_NANOS = 1e6;

    /** What the last first perceptions cost weighs in what the next is taken to cost. */
    private static final double MEMORY = 0.9;

    /** A perception is cheap if it costs no more than an equal share of so much time [ns]. */
    private static final double CHEAP_NANOS = 50e6;

    /** Or no more than this, however many there are [ns]. */
    private static final double CHEAP_FOR_ALL_NANOS = 30e3;

    private final Map<String, Account> byToken = new HashMap<>();
    private final List<Account> active = new ArrayList<>();
    private final List<C> waiting = new ArrayList<>();
    private long round;
    private long paidNanos;

    /** Left of this slice. */
    private double sliceNanos;

    /** What costs more waits. */
    private double cheapNanos;

    private double firstNanos = FIRST_NANOS;

    /** A client that perceives. */
    public interface Client {
        /** Returns what its perceptions cost. */
        Cost perceptionCost();

        /** Returns whether the world waits for it. */
        boolean isInLockStep();

        /** Returns whether it perceives a frame. */
        boolean perceives(long frame);
    }

    /** What its sessions perceived and have not paid for. */
    private static final class Account {
        private double owedNanos;
        private long round;
    }

    /** What a session's perceptions cost. */
    public static final class Cost {
        private final Account account;

        /** Since it was served last. */
        private double spentNanos;

        /** What its last perception cost. */
        private double expectedNanos;

        /** It has perceived. */
        private boolean known;

        /** By whichever thread writes to the session while the event loop waits for it. */
        private long writtenNanos;

        private Cost(Account account) {
            this.account = account;
        }

        /** A perception was written in so much time. */
        public void wrote(long nanos) {
            writtenNanos += nanos;
        }
    }

    /** Shares without sessions. */
    public PerceptionShares(long nowNanos) {
        paidNanos = nowNanos;
    }

    /**
     * @param tokenName name of the client's token, if the server takes tokens
     */
    public Cost cost(Optional<String> tokenName) {
        return new Cost(
                tokenName
                        .map(name -> byToken.computeIfAbsent(name, unknown -> new Account()))
                        .orElseGet(Account::new));
    }

    /**
     * A slice begins: accounts pay their shares of the time since the one before.
     *
     * @param frame that the members perceive if it is due for them
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

    /** Charges what was written since. */
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

    /** Whether a session is served whoever else is; if not, it waits. */
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
     * Those who wait: the least indebted first, and of those without debts who has perceived
     * before. They are served as long as {@link #isTimeLeft}.
     */
    public List<C> waiting() {
        waiting.sort(
                Comparator.comparingDouble((C client) -> client.perceptionCost().account.owedNanos)
                        .thenComparing(client -> !client.perceptionCost().known));
        return waiting;
    }

    /** Returns true if the slice is not used up. */
    public boolean isTimeLeft() {
        return sliceNanos > 0;
    }

    /** So much time was spent for a session that could not be served yet. */
    public void spend(Cost cost, long nanos) {
        sliceNanos -= nanos;
        charge(cost, nanos);
    }

    /** A session was served in so much time; what is to be written then comes later. */
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
