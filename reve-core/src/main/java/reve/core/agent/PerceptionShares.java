package reve.core.agent;

import java.util.ArrayList;
import java.util.Collection;
import java.util.Comparator;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Shares the event loop's time among those who perceive in real time, so that what some perceive
 * at great cost comes later and not what the others perceive. Each token has an account, each
 * session without a token has one. What perceptions cost, to find them and to write them, is
 * charged to it, and paid by equal shares of {@link #SHARE} of the time. While an account is
 * overdrawn, its sessions perceive only in the time that is left over. Who is in lock-step is
 * charged, too, but served at once: the world waits. See docs/decisions/0006. The event loop's
 * thread, but for {@link Cost#wrote}.
 */
final class PerceptionShares {

    /** Of the time, for perceptions. */
    private static final double SHARE = 0.75;
    /** What a first perception is taken to cost before one has been seen [ns]. */
    private static final double FIRST_NANOS = 1e6;
    /** What the last first perceptions cost weighs in what the next is taken to cost. */
    private static final double MEMORY = 0.9;
    /** A perception that costs more equal shares than this waits for time that is left over. */
    private static final double CHEAP = 4;
    /** Time that passed without perceptions counts up to this [ns]. */
    private static final double MOST_CREDIT_NANOS = 20e6;
    private static final double MOST_DEBT_NANOS = 1e9;

    private final Map<String, Account> byToken = new HashMap<>();
    private final List<Account> active = new ArrayList<>();
    private final List<Session> waiting = new ArrayList<>();
    private long round;
    private long paidNanos;
    private boolean paid;
    /** Time that is left over; negative if more was taken than there is. */
    private double credit;
    /** Each account's share of the time since the round before. */
    private double fairNanos;
    private double firstNanos = FIRST_NANOS;

    /** What its sessions perceived and have not paid for. */
    private static final class Account {
        private double owedNanos;
        private long round = -1;
    }

    /** What a session's perceptions cost. */
    static final class Cost {
        private final Account account;
        /** Since it was served last. */
        private double spentNanos;
        private double expectedNanos;
        private boolean known;
        /** Of what was taken from the credit in advance, what has not been spent. */
        private double reservedNanos;
        /** By whichever thread writes to the session while the event loop waits for it. */
        private long writtenNanos;

        private Cost(Account account) {
            this.account = account;
        }

        /** A perception was written in so much time. */
        void wrote(long nanos) {
            writtenNanos += nanos;
        }
    }

    /** @param token of who perceives, if the server takes tokens */
    Cost cost(Optional<AgentToken> token) {
        return new Cost(token.map(AgentToken::name)
                .map(name -> byToken.computeIfAbsent(name, unknown -> new Account()))
                .orElseGet(Account::new));
    }

    /**
     * A frame is here: accounts pay their shares.
     *
     * @param frame that the members perceive if it is due for them
     */
    void begin(Collection<Session> members, long frame, long nowNanos) {
        double earned = paid ? SHARE * Math.min(nowNanos - paidNanos, 1e9) : MOST_CREDIT_NANOS;
        paidNanos = nowNanos;
        paid = true;
        credit = Math.min(credit + earned, MOST_CREDIT_NANOS);
        round++;
        active.clear();
        for (Session member : members) {
            Cost cost = member.perceptionCost();
            charge(cost, cost.writtenNanos);
            cost.writtenNanos = 0;
            if (cost.account.round != round
                    && (cost.account.owedNanos > 0 || member.perceptions().isDue(frame))) {
                cost.account.round = round;
                active.add(cost.account);
            }
        }
        fairNanos = earned / Math.max(1, active.size());
        active.forEach(account -> account.owedNanos = Math.max(0, account.owedNanos - fairNanos));
    }

    /** Whether a session is served whoever else is; if not, it waits for what is left over. */
    boolean isServedNow(Session session) {
        Cost cost = session.perceptionCost();
        if (session.isInLockStep() || cost.known && cost.account.owedNanos == 0
                && cost.expectedNanos <= CHEAP * fairNanos) {
            return true;
        }
        waiting.add(session);
        return false;
    }

    /** Those who wait, the least indebted first, as long as {@link #isTimeLeft}. */
    List<Session> takeWaiting() {
        waiting.sort(Comparator.comparingDouble(
                session -> session.perceptionCost().account.owedNanos));
        List<Session> all = List.copyOf(waiting);
        waiting.clear();
        return all;
    }

    boolean isTimeLeft() {
        return credit > 0;
    }

    /** A session is served next: what that is expected to cost is set aside. */
    void reserve(Cost cost) {
        if (cost.known || cost.spentNanos > 0) {
            if (!cost.known) {
                firstNanos = Math.max(cost.spentNanos, MEMORY * firstNanos);
            }
            cost.expectedNanos = cost.spentNanos;
            cost.known = true;
        }
        credit += cost.reservedNanos;
        cost.reservedNanos = cost.known ? cost.expectedNanos : firstNanos;
        credit -= cost.reservedNanos;
        cost.spentNanos = 0;
    }

    /** A session's perception took so much time. */
    void charge(Cost cost, double nanos) {
        double covered = Math.min(cost.reservedNanos, nanos);
        cost.reservedNanos -= covered;
        cost.spentNanos += nanos;
        cost.account.owedNanos += nanos;
        credit = Math.max(credit - (nanos - covered), -MOST_DEBT_NANOS);
    }
}
