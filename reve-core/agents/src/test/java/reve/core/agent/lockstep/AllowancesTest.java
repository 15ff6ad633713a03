// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.protocol.ClientMessage;

import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.Random;

/**
 * The time for which agents in lock-step delay others, in a world of 60 frames a second whose clock
 * moves from one event to the next.
 */
class AllowancesTest {

    private static final long MILLISECOND = 1_000_000;
    private static final long SECOND = 1_000 * MILLISECOND;
    private static final long FRAME = SECOND / 60;
    private static final long DEADLINE = SECOND;
    private static final long LONG = 3600 * SECOND;
    private static final long NEVER = Long.MAX_VALUE;

    private final List<AgentInput.Late> late = new ArrayList<>();
    private final List<Boolean> spent = new ArrayList<>();
    private int backs;
    private final List<Player> players = new ArrayList<>();
    private Allowances allowances = allowances(Optional.of(Duration.ofSeconds(10)));
    private LockStep gate = gate();
    private boolean fast;
    private long now = 1;
    private long frame = 1;

    /** The pace of an agent's rounds. */
    private interface Thinking {
        /** Returns the time at which its next round is complete [ns], or {@link #NEVER}. */
        long next();

        /**
         * Returns whether the agent leaves instead of being ready, and reconnects under another
         * name.
         */
        default boolean leaves() {
            return false;
        }
    }

    private final class Player {
        private final Thinking thinking;
        private final Optional<String> token;
        private final int home;
        private Turn turn;
        private long readyNanos;

        Player(Thinking thinking, Optional<String> token, int home) {
            this.thinking = thinking;
            this.token = token;
            this.home = home;
            come();
        }

        private void come() {
            var allowance = allowances.of(token, ByteBuffer.wrap(new byte[] {(byte) home}), now);
            turn =
                    new Turn(
                            "agent " + players.size(),
                            new ClientMessage.LockStep(1, false, 1, Optional.empty()),
                            DEADLINE,
                            allowance);
            turn.begin(frame);
            gate.add(turn);
            think();
        }

        private void think() {
            long time = thinking.next();
            readyNanos = time == NEVER ? NEVER : now + time;
        }

        /**
         * Begins a frame. An agent that is about to leave is still present, and an agent that is
         * away continues to think.
         */
        void perceive() {
            if (!thinking.leaves() && turn.isHere() || readyNanos == NEVER) {
                think();
            }
        }

        void act() {
            if (thinking.leaves()) {
                gate.remove(turn, now);
                come();
            } else {
                turn.ready(frame, frame, now);
                readyNanos = NEVER;
            }
        }
    }

    private Allowances allowances(Optional<Duration> full) {
        return new Allowances(FRAME, full, allowance -> spent.add(allowance.isSpent()));
    }

    private LockStep gate() {
        return new LockStep(
                () -> {},
                news -> {
                    if (news instanceof AgentInput.Late missed) {
                        late.add(missed);
                    } else {
                        backs++;
                    }
                },
                allowances,
                LockStep.Waiting.IDLE);
    }

    private void join(Thinking thinking) {
        players.add(new Player(thinking, Optional.empty(), 0));
    }

    private void join(String token, int home, Thinking thinking) {
        players.add(new Player(thinking, Optional.of(token), home));
    }

    /**
     * Runs the world for that long.
     *
     * @return frames a second
     */
    private double run(long nanoseconds) {
        long begun = now;
        long first = frame;
        while (now - begun < nanoseconds) {
            if (!fast) {
                pass(FRAME);
            }
            hold();
            frame++;
            players.forEach(Player::perceive);
        }
        return (double) (frame - first) * SECOND / (now - begun);
    }

    /** Runs until the gate permits the next frame. */
    private void hold() {
        for (long wait = ask(); wait > 0; wait = ask()) {
            long ready =
                    players.stream().mapToLong(player -> player.readyNanos).min().orElse(NEVER);
            pass(Math.max(0, Math.min(wait, ready - now)));
        }
    }

    private long ask() {
        return gate.nanosecondsToWait(frame + 1, now);
    }

    private void pass(long nanoseconds) {
        now += nanoseconds;
        for (Player player : players) {
            if (player.readyNanos <= now) {
                player.act();
            }
        }
    }

    private static Thinking each(long nanoseconds) {
        return () -> nanoseconds;
    }

    /**
     * Returns a pace of an agent that thinks for that long once in a number of rounds, and for 5 ms
     * in the other rounds.
     */
    private static Thinking sometimes(int rounds, long nanoseconds) {
        return new Thinking() {
            private int round;

            @Override
            public long next() {
                return round++ % rounds == rounds - 1 ? nanoseconds : 5 * MILLISECOND;
            }
        };
    }

    @Test
    void readyJustBeforeEachDeadlineHoldsTheWorldForItsAllowanceOnly() {
        allowances.addRealTime(1);
        join(each(DEADLINE - MILLISECOND));
        double begin = run(10 * SECOND);
        assertThat(begin).as("it uses up its allowance").isLessThan(2);
        run(2 * SECOND);
        assertThat(spent).containsExactly(true);
        assertThat(run(LONG)).isGreaterThanOrEqualTo(30);
        assertThat(late).anyMatch(AgentInput.Late::away);
    }

    @Test
    void whoIsLateTwiceAndReadyThenHoldsTheWorldForItsAllowanceOnly() {
        allowances.addRealTime(1);
        join(
                new Thinking() {
                    private int round;

                    @Override
                    public long next() {
                        return ++round % 3 == 0 ? DEADLINE / 2 : NEVER;
                    }
                });
        run(12 * SECOND);
        assertThat(run(LONG)).isGreaterThanOrEqualTo(30);
    }

    @Test
    void whoLeavesAndComesUnderOtherNamesHasNoOtherAllowance() {
        allowances.addRealTime(1);
        join(
                new Thinking() {
                    @Override
                    public long next() {
                        return DEADLINE - MILLISECOND;
                    }

                    @Override
                    public boolean leaves() {
                        return true;
                    }
                });
        run(12 * SECOND);
        assertThat(spent).startsWith(true);
        assertThat(run(LONG)).isGreaterThanOrEqualTo(30);
    }

    @Test
    void whoIsPutOffByAnotherThatComesHasHeldTheWorldUntilThen() {
        allowances.addRealTime(1);
        Turn before = silent();
        for (int comer = 0; comer < 30; comer++) {
            pass(FRAME);
            long patience = 9 * SECOND / 10;
            for (long wait = ask(); wait > 0 && patience > 0; wait = ask()) {
                long step = Math.min(wait, patience);
                pass(step);
                patience -= step;
            }
            gate.comes();
            assertThat(ask()).as("others come without waiting").isZero();
            frame++;
            gate.came();
            Turn next = silent();
            gate.remove(before, now);
            before = next;
        }
        assertThat(spent).as("30 times 0.9 s").first().isEqualTo(true);
    }

    private Turn silent() {
        var turn =
                new Turn(
                        "silent",
                        new ClientMessage.LockStep(1, false, 1, Optional.empty()),
                        DEADLINE,
                        allowances.of(Optional.empty(), ByteBuffer.wrap(new byte[] {0}), now));
        turn.begin(frame);
        gate.add(turn);
        return turn;
    }

    @Test
    void severalThatHoldTheWorldInTurnShareTheAllowance() {
        allowances.addRealTime(1);
        for (int i = 0; i < 5; i++) {
            int turn = i;
            join(() -> frame % 5 == turn ? DEADLINE - MILLISECOND : MILLISECOND);
        }
        run(12 * SECOND);
        assertThat(run(LONG)).isGreaterThanOrEqualTo(30);
    }

    @Test
    void whoSavesItsAllowanceUpGainsNothing() {
        allowances.addRealTime(1);
        join(() -> isSpent() ? MILLISECOND : DEADLINE - MILLISECOND);
        run(12 * SECOND);
        assertThat(run(LONG)).isGreaterThanOrEqualTo(50);
        assertThat(spent.size()).as("changes in an hour").isBetween(20, 150);
    }

    @Test
    void whoIsAwayComesBackOnlyWhenTheAllowanceHasReturned() {
        allowances.addRealTime(1);
        for (int i = 0; i < 20; i++) {
            join(each(2 * FRAME + MILLISECOND));
        }
        run(60 * SECOND);
        assertThat(spent).first().isEqualTo(true);
        late.clear();
        assertThat(run(LONG)).as("frames a second").isGreaterThan(50);
        long returns = spent.stream().filter(isSpent -> !isSpent).count();
        assertThat(returns).isPositive();
        assertThat(backs).as("returns of 20 agents").isBetween(20, (int) (20 * returns));
        assertThat(late.stream().filter(AgentInput.Late::told).count())
                .as("rounds that the world waited for in vain")
                .isLessThanOrEqualTo(4 * 20 * returns);
    }

    @Test
    void whoIsAwayComesBackAtOnceWhereNobodyElseWaits() {
        allowances.addRealTime(1);
        join(() -> now < 20 * SECOND ? DEADLINE / 2 : MILLISECOND);
        run(20 * SECOND);
        assertThat(isSpent()).isTrue();
        assertThat(late).last().matches(each -> !each.told(), "it is away");
        assertThat(backs).isZero();
        allowances.addRealTime(-1);
        run(2 * SECOND);
        assertThat(isSpent()).isTrue();
        assertThat(backs).isEqualTo(1);
    }

    private boolean isSpent() {
        return !spent.isEmpty() && spent.getLast();
    }

    @Test
    void whateverAgentsDoTheWorldHasHalfItsRate() {
        long seed = Seed.of("agents that keep others waiting");
        var random = new Random(seed);
        allowances.addRealTime(1);
        for (int i = 0; i < 6; i++) {
            int most = 1 + random.nextInt(40);
            boolean leaves = random.nextBoolean();
            join(
                    new Thinking() {
                        @Override
                        public long next() {
                            return random.nextInt(most) == 0
                                    ? random.nextLong(2 * DEADLINE)
                                    : random.nextLong(FRAME + MILLISECOND);
                        }

                        @Override
                        public boolean leaves() {
                            return leaves && random.nextInt(50) == 0;
                        }
                    });
        }
        run(12 * SECOND);
        assertThat(run(LONG / 4)).as("seed %d", seed).isGreaterThanOrEqualTo(30);
    }

    @Test
    void whoSeldomThinksForLongIsWaitedFor() {
        allowances.addRealTime(1);
        join(sometimes(600, SECOND / 2));
        assertThat(run(LONG)).isGreaterThan(55);
        assertThat(late).isEmpty();
        assertThat(spent).isEmpty();
    }

    @Test
    void whoNeedsLessThanAFrameMoreIsWaitedForAlways() {
        allowances.addRealTime(1);
        join(each(FRAME + FRAME / 2));
        assertThat(run(LONG)).isGreaterThan(39);
        assertThat(spent).as("told that its allowance is spent").containsExactly(true);
        assertThat(late).isEmpty();
    }

    @Test
    void inAFastWorldOnlyWhatIsSlowerThanItsRateCounts() {
        fast = true;
        allowances.addRealTime(1);
        join(each(FRAME - MILLISECOND));
        assertThat(run(LONG)).isGreaterThan(60);
        assertThat(spent).isEmpty();
        join(each(DEADLINE - MILLISECOND));
        run(12 * SECOND);
        assertThat(run(LONG)).isGreaterThanOrEqualTo(30);
    }

    @Test
    void aTokensAllowanceIsNotThatOfOthers() {
        allowances.addRealTime(1);
        join("mallory", 1, each(DEADLINE - MILLISECOND));
        join("ada", 1, sometimes(600, SECOND / 2));
        run(12 * SECOND);
        late.clear();
        assertThat(run(LONG)).isGreaterThanOrEqualTo(29);
        assertThat(late).extracting(AgentInput.Late::agent).containsOnly("agent 0");
    }

    @Test
    void whoIsBackAfterAWhileHasAnAllowanceAgain() {
        allowances.addRealTime(1);
        join(() -> now < 20 * SECOND || now > 90 * SECOND ? DEADLINE / 2 : MILLISECOND);
        run(95 * SECOND);
        assertThat(spent).containsExactly(true, false);
        assertThat(late).isNotEmpty().noneMatch(each -> each.count() > 2000);
    }

    @Test
    void whoIsAloneIsWaitedForUntilItsDeadline() {
        join(each(DEADLINE - MILLISECOND));
        run(LONG);
        assertThat(late).isEmpty();
        assertThat(spent).isEmpty();
    }

    @Test
    void agentsOfOneAddressWaitForEachOther() {
        for (int i = 1; i <= 4; i++) {
            join(each(i * DEADLINE / 5));
            join("token" + i, 0, each(i * DEADLINE / 5));
        }
        run(LONG);
        assertThat(late).isEmpty();
        assertThat(spent).isEmpty();
    }

    @Test
    void anAgentOfAnotherAddressThatIsReadyWaits() {
        join("mallory", 1, each(DEADLINE - MILLISECOND));
        join("ada", 2, each(MILLISECOND));
        run(12 * SECOND);
        assertThat(run(LONG)).isGreaterThanOrEqualTo(30);
        assertThat(late).extracting(AgentInput.Late::agent).containsOnly("agent 0");
    }

    @Test
    void anAgentOfAnotherAddressThatThinksAsLongDoesNotWait() {
        join("bob", 1, each(DEADLINE / 2));
        join("ada", 2, each(DEADLINE / 2));
        run(LONG);
        assertThat(late).isEmpty();
        assertThat(spent).isEmpty();
    }

    @Test
    void withoutALimitNobodyIsGivenUpBeforeItsDeadline() {
        allowances = allowances(Optional.empty());
        gate = gate();
        allowances.addRealTime(1);
        join(each(DEADLINE - MILLISECOND));
        run(LONG);
        assertThat(late).isEmpty();
        assertThat(spent).isEmpty();
    }

    /** In this test, the server is suspended for 22 s while it waits. */
    @Test
    void aTimeInWhichTheServerDidNotRunIsNotCharged() {
        allowances.addRealTime(1);
        join(each(DEADLINE / 2));
        for (int i = 0; i < 10; i++) {
            pass(FRAME);
            long wait = ask();
            now += Math.min(wait, DEADLINE / 10) + 22 * SECOND;
            assertThat(ask()).as("its deadline is not over").isPositive();
            pass(MILLISECOND);
            hold();
            frame++;
            players.forEach(Player::perceive);
        }
        assertThat(late).isEmpty();
        assertThat(spent).isEmpty();
    }

    @Test
    void aPauseIsNoWaiting() {
        allowances.addRealTime(1);
        join(each(NEVER));
        for (int i = 0; i < 100; i++) {
            assertThat(gate.nanosecondsToWait(frame + 1, now)).isPositive();
            now += DEADLINE / 2;
            gate.paused();
        }
        assertThat(spent).isEmpty();
        assertThat(late).isEmpty();
    }
}
