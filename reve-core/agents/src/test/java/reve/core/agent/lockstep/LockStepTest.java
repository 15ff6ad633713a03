// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.protocol.ActionRequest;
import reve.core.agent.protocol.ClientMessage;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameClock;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;

/**
 * The times at which a world waits for agents in lock-step, compared with a small model, on a clock
 * that moves only while the world waits.
 */
class LockStepTest {

    private static final long MILLISECOND = 1_000_000;
    private static final int FRAMES = 10_000;

    private final long seed = Seed.of("agents in lock-step");
    private final Random random = new Random(seed);
    private final List<Player> players = new ArrayList<>();
    private final Map<String, Player> byName = new HashMap<>();
    private final Clock clock = new Clock();
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop =
            new FrameLoop(
                    new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena()),
                    bus,
                    Timing.DEFAULT,
                    Pacing.FAST,
                    clock);
    private final LockStep lockStep =
            new LockStep(clock::wake, this::heard, allowances(), LockStep.Waiting.IDLE);
    private long dueSince;
    private long longestDeadline;

    /** Agents that delay no others. */
    private static Allowances allowances() {
        return new Allowances(MILLISECOND, Optional.empty(), allowance -> {});
    }

    private static Allowance allowance() {
        return new Allowance(Optional.empty(), 0);
    }

    /** The state that one agent should have. The test computes it without the server. */
    private static final class Player {
        private final Turn turn;
        private final int every;
        private final long deadlineNanos;
        private long origin;
        private long done;
        private long late;
        private long judged;
        private int lateInRow;
        private boolean present = true;
        private boolean broken;
        private boolean away;
        private boolean returning;
        private int backs;

        Player(String name, int every, long deadlineNanos, long origin) {
            this.turn =
                    new Turn(
                            name,
                            new ClientMessage.LockStep(
                                    every,
                                    false,
                                    deadlineNanos / 1e9,
                                    Optional.of(
                                            new ActionRequest(
                                                    Optional.empty(), "brake", Map.of()))),
                            deadlineNanos,
                            allowance());
            this.every = every;
            this.deadlineNanos = deadlineNanos;
            this.origin = origin;
        }

        long roundsBegun(long frame) {
            return frame < origin ? 0 : (frame - origin) / every + 1;
        }

        boolean isMissing(long frame) {
            return present && done < roundsBegun(frame);
        }
    }

    /** A clock that moves to the end of each wait, unless an event ends the wait earlier. */
    private final class Clock implements FrameClock {
        private long now = 1;
        private boolean woken;

        @Override
        public long nanoTime() {
            return now;
        }

        @Override
        public void park(long nanoseconds) {
            if (!loop.isPaused()) {
                takeBack(loop.frame() + 1); // the world just asked the gate
            }
            long end = now + nanoseconds;
            while (!woken && now < end) {
                long next = now + 1 + random.nextLong(4 * MILLISECOND);
                if (next >= end) {
                    now = end;
                } else {
                    now = next;
                    happen();
                }
            }
            woken = false;
        }

        void wake() {
            woken = true;
        }
    }

    private void heard(AgentInput news) {
        Player player = byName.get(news.agent());
        if (!(news instanceof AgentInput.Late late)) {
            assertThat(news).isInstanceOf(AgentInput.Back.class);
            assertThat(player.away).as("%s was away", news.agent()).isTrue();
            player.away = false;
            player.backs++;
            return;
        }
        player.late++;
        assertThat(late.count()).isEqualTo(player.late);
        assertThat(late.fallback()).isPresent();
        player.judged = player.roundsBegun(loop.frame());
        player.lateInRow++;
        assertThat(late.away())
                .as("%s after %d late rounds in a row", late.agent(), player.lateInRow)
                .isEqualTo(player.present && player.lateInRow >= 3);
        if (player.present) {
            assertThat(late.told()).isTrue();
            assertThat(clock.now - dueSince)
                    .as("time that %s got", late.agent())
                    .isGreaterThanOrEqualTo(player.deadlineNanos);
        }
        if (late.away()) {
            player.away = true;
            player.present = false;
        }
        player.done = Math.max(player.done, player.roundsBegun(loop.frame()));
    }

    /**
     * Lets an agent or an operator do something while the world waits. Agents also act while the
     * world runs.
     */
    private void happen() {
        if (loop.isPaused()) {
            if (random.nextInt(3) == 0) {
                loop.resume();
                dueSince = clock.now;
                clock.wake();
            }
            return;
        }
        if (random.nextInt(50) == 0) {
            loop.pause();
            clock.wake();
        } else if (random.nextInt(50) == 0) {
            loop.betweenFrames(this::rewind);
            clock.wake();
        } else if (!players.isEmpty()) {
            move(players.get(random.nextInt(players.size())));
            if (players.stream().noneMatch(player -> player.isMissing(loop.frame()))) {
                assertThat(clock.woken).as("the world goes on at once").isTrue();
            }
        }
    }

    private void rewind() {
        loop.continueAfter(loop.frame() + 1);
        for (Player player : players) {
            player.origin = loop.frame();
            player.done = 0;
            player.judged = 0;
        }
        dueSince = clock.now;
    }

    private void takeBack(long frame) {
        for (Player player : players) {
            if (player.returning) {
                assertThat(player.away).as("whether the others were told").isFalse();
                player.returning = false;
                player.present = true;
                player.origin = frame;
                player.done = 0;
                player.judged = 0;
                player.lateInRow = 0;
            }
        }
    }

    private void move(Player player) {
        switch (random.nextInt(player.present ? 10 : 30)) {
            case 0 -> {
                players.remove(player);
                lockStep.remove(player.turn, clock.now);
            }
            case 1 -> {
                player.present = false;
                player.returning = false;
                player.broken = true;
                player.turn.breakOff(0);
                lockStep.changed();
            }
            case 2 -> {
                player.present = false;
                player.broken = false;
                player.returning = true;
                player.turn.comeBack();
                lockStep.changed();
            }
            case 3, 4, 5 -> ready(player, false);
            default -> ready(player, true);
        }
    }

    private void ready(Player player, boolean saysFrame) {
        boolean isAway = player.away && !player.broken && !player.returning;
        if (!player.present && !isAway) {
            return;
        }
        player.returning |= isAway;
        long frame = random.nextInt(4) == 0 ? random.nextLong(2 * loop.frame() + 1) : loop.frame();
        if (saysFrame) {
            player.turn.ready(frame, loop.frame(), clock.now);
            player.done =
                    frame > loop.frame()
                            ? player.done
                            : Math.max(player.done, player.roundsBegun(frame));
        } else {
            player.turn.ready(clock.now);
            player.done++;
        }
        lockStep.changed();
    }

    @Test
    void noFrameComesBeforeAllAreReadyOrLateAndNoneLaterThanTheirDeadlines() {
        bus.subscribe(
                FramePhase.INTAKE,
                "check",
                event -> {
                    long before = event.frame() - 1;
                    for (Player player : players) {
                        if (player.roundsBegun(before) != player.judged) {
                            player.judged = player.roundsBegun(before);
                            player.lateInRow = 0; // it was ready, because no Late came
                        }
                        assertThat(player.isMissing(before))
                                .as("seed %d, frame %d", seed, event.frame())
                                .isFalse();
                    }
                    takeBack(event.frame());
                    assertThat(clock.now - dueSince)
                            .as("seed %d, wait before frame %d", seed, event.frame())
                            .isLessThanOrEqualTo(longestDeadline);
                });
        bus.subscribe(
                FramePhase.ACT,
                "join",
                event -> {
                    if (players.size() < 5 && random.nextInt(20) == 0) {
                        String name = "agent " + byName.size();
                        var player =
                                new Player(
                                        name,
                                        1 + random.nextInt(4),
                                        random.nextLong(30 * MILLISECOND),
                                        event.frame());
                        players.add(player);
                        byName.put(name, player);
                        player.turn.begin(event.frame());
                        lockStep.add(player.turn);
                    } else if (!players.isEmpty() && random.nextInt(4) == 0) {
                        move(players.get(random.nextInt(players.size())));
                    }
                });
        bus.subscribe(
                FramePhase.PUBLISH,
                "due",
                event -> {
                    dueSince = clock.now;
                    longestDeadline =
                            players.stream()
                                    .mapToLong(player -> player.deadlineNanos)
                                    .max()
                                    .orElse(0);
                });
        loop.setGate(lockStep);
        loop.run(FRAMES);
        assertThat(byName.values())
                .anyMatch(player -> player.late > 0)
                .anyMatch(player -> player.backs > 0)
                .hasSizeGreaterThan(10);
    }

    @Test
    void whoIsLateThreeRoundsInARowIsNoLongerWaitedForUntilItIsReady() {
        var news = new ArrayList<AgentInput>();
        var gate = new LockStep(() -> {}, news::add, allowances(), LockStep.Waiting.IDLE);
        var turn =
                new Turn(
                        "ada",
                        new ClientMessage.LockStep(2, false, 1, Optional.empty()),
                        MILLISECOND,
                        allowance());
        turn.begin(0);
        gate.add(turn);
        for (long frame = 1; frame <= 5; frame += 2) {
            assertThat(gate.nanosecondsToWait(frame, 0))
                    .as("frame %d", frame)
                    .isEqualTo(MILLISECOND);
            assertThat(gate.nanosecondsToWait(frame, MILLISECOND)).isZero();
            assertThat(gate.nanosecondsToWait(frame + 1, 0)).isZero();
        }
        assertThat(news)
                .containsExactly(
                        new AgentInput.Late("ada", 1, Optional.empty(), true, false),
                        new AgentInput.Late("ada", 2, Optional.empty(), true, false),
                        new AgentInput.Late("ada", 3, Optional.empty(), true, true));
        news.clear();
        assertThat(gate.nanosecondsToWait(7, 0)).as("the world goes on").isZero();
        assertThat(turn.isDue(7, 5)).as("it still perceives its rounds").isTrue();
        turn.ready(3, 7, 0);
        assertThat(gate.nanosecondsToWait(8, 0)).isZero();
        assertThat(turn.isDue(8, 7)).as("its rounds restart with the next frame").isTrue();
        assertThat(gate.nanosecondsToWait(9, 0)).as("it is waited for").isEqualTo(MILLISECOND);
        assertThat(news)
                .containsExactly(
                        new AgentInput.Late("ada", 4, Optional.empty(), false, false),
                        new AgentInput.Back("ada"));
    }

    @Test
    void aRoundInTimeBetweenLateOnesStartsTheCountAgain() {
        var news = new ArrayList<AgentInput>();
        var gate = new LockStep(() -> {}, news::add, allowances(), LockStep.Waiting.IDLE);
        var turn =
                new Turn(
                        "ada",
                        new ClientMessage.LockStep(1, false, 1, Optional.empty()),
                        MILLISECOND,
                        allowance());
        turn.begin(0);
        gate.add(turn);
        for (long frame = 1; frame <= 12; frame++) {
            if (frame % 3 == 0) {
                turn.ready(frame - 1, frame - 1, 0);
            }
            gate.nanosecondsToWait(frame, 0);
            gate.nanosecondsToWait(frame, MILLISECOND);
        }
        assertThat(news)
                .hasSize(8)
                .allMatch(
                        each ->
                                each instanceof AgentInput.Late late
                                        && late.told()
                                        && !late.away());
    }

    /**
     * The message comes from another thread at the worst moment, which is while the server detects
     * the third late round.
     */
    @Test
    void aReadyThatComesAsTheWorldGivesUpIsNotLost() {
        var turn =
                new Turn(
                        "ada",
                        new ClientMessage.LockStep(1, false, 1, Optional.empty()),
                        MILLISECOND,
                        allowance());
        turn.begin(0);
        for (long frame = 1; frame <= 3; frame++) {
            assertThat(turn.miss(frame - 1)).isTrue();
            if (frame == 3) {
                turn.ready(frame - 1, frame - 1, 0);
            }
            assertThat(turn.late().away()).isEqualTo(frame == 3);
        }
        assertThat(turn.takeBack(4, true)).as("it is back at once").isTrue();
        assertThat(turn.isAwaited(4)).isTrue();
    }

    @Test
    void aReadyForARoundThatIsOverDoesNothing() {
        var turn =
                new Turn(
                        "ada",
                        new ClientMessage.LockStep(2, false, 1, Optional.empty()),
                        MILLISECOND,
                        allowance());
        turn.begin(10);
        assertThat(turn.isAwaited(9)).isFalse();
        assertThat(turn.isAwaited(10)).isTrue();
        turn.ready(10, 10, 0);
        assertThat(turn.isAwaited(11)).isFalse();
        assertThat(turn.isAwaited(12)).isTrue();
        turn.ready(11, 12, 0);
        turn.ready(14, 12, 0);
        assertThat(turn.isAwaited(12))
                .as("by a ready of the last round, or of one to come")
                .isTrue();
        turn.ready(0);
        turn.ready(0);
        assertThat(turn.isAwaited(14)).as("said before its time").isFalse();
    }

    @Test
    void whoHasLeftBeforeItCameIsNotWaitedFor() {
        var turn =
                new Turn(
                        "ada",
                        new ClientMessage.LockStep(1, false, 1, Optional.empty()),
                        MILLISECOND,
                        allowance());
        turn.begin(1);
        lockStep.remove(turn, 0);
        lockStep.add(turn);
        assertThat(lockStep.nanosecondsToWait(2, 0)).isZero();
    }

    @Test
    void whoHasNotBeenReadyYetDoesNotKeepOthersFromComing() {
        var turn =
                new Turn(
                        "ada",
                        new ClientMessage.LockStep(3, false, 1, Optional.empty()),
                        MILLISECOND,
                        allowance());
        turn.begin(1);
        lockStep.add(turn);
        assertThat(lockStep.nanosecondsToWait(2, 0)).isEqualTo(MILLISECOND);
        lockStep.comes();
        assertThat(lockStep.nanosecondsToWait(2, 0)).isZero();
        lockStep.came();
        assertThat(turn.isDue(2, 1)).as("it begins with the others").isTrue();
        assertThat(lockStep.nanosecondsToWait(3, 0)).isEqualTo(MILLISECOND);
        turn.ready(0);
        assertThat(lockStep.nanosecondsToWait(3, 0)).isZero();
        lockStep.comes();
        assertThat(lockStep.nanosecondsToWait(6, 0)).as("it plays already").isEqualTo(MILLISECOND);
    }

    @Test
    void ofTheRoundsThatABrokenConnectionCostsTheOthersHearOnce() {
        var heard = new ArrayList<AgentInput>();
        var gate = new LockStep(() -> {}, heard::add, allowances(), LockStep.Waiting.IDLE);
        var turn =
                new Turn(
                        "ada",
                        new ClientMessage.LockStep(1, false, 1, Optional.empty()),
                        MILLISECOND,
                        allowance());
        turn.begin(1);
        gate.add(turn);
        turn.breakOff(0);
        for (long frame = 2; frame < 5; frame++) {
            assertThat(gate.nanosecondsToWait(frame, 0)).isZero();
        }
        turn.comeBack();
        assertThat(gate.nanosecondsToWait(5, 0)).isZero();
        assertThat(gate.nanosecondsToWait(6, 0)).isEqualTo(MILLISECOND);
        assertThat(gate.nanosecondsToWait(6, MILLISECOND)).isZero();
        assertThat(heard)
                .extracting(news -> ((AgentInput.Late) news).told())
                .containsExactly(true, false, false, true);
        assertThat(heard)
                .extracting(news -> ((AgentInput.Late) news).count())
                .containsExactly(1L, 2L, 3L, 4L);
    }
}
