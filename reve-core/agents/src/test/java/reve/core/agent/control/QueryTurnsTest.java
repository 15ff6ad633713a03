// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;

import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.List;

/** Turns of costly queries, with a clock and an event loop that the test drives. */
class QueryTurnsTest {

    private static final long MILLISECOND = 1_000_000;

    private final Deque<Runnable> loop = new ArrayDeque<>();
    private final List<String> answers = new ArrayList<>();
    private long nanos;
    private long published;
    private final QueryTurns turns =
            new QueryTurns(loop::add, () -> nanos, frame -> frame <= published);

    private final Requester a = new Asker("a");
    private final Requester b = new Asker("b");
    private final Requester operator = new Asker("operator");

    private void ask(Requester requester, long id, long costNanos) {
        ask(requester, id, 0, costNanos);
    }

    /** Asks a query that waits for a frame and takes this time, in steps of 0.1 ms. */
    private void ask(Requester requester, long id, long frame, long costNanos) {
        long[] rest = {costNanos};
        turns.ask(
                requester,
                new ClientMessage.Search(id, "toy"),
                frame,
                end -> {
                    while (rest[0] > 0 && nanos < end) {
                        nanos += MILLISECOND / 10;
                        rest[0] -= MILLISECOND / 10;
                    }
                    if (rest[0] > 0) {
                        return false;
                    }
                    answers.add(requester.name() + id);
                    return true;
                });
    }

    private void turn() {
        loop.remove().run();
    }

    @Test
    void clientsTakeTurnsInSlices() {
        for (int id = 1; id <= 3; id++) {
            ask(a, id, MILLISECOND * 4 / 10);
        }
        ask(b, 1, MILLISECOND * 4 / 10);
        turn();
        assertThat(answers).containsExactly("a1", "b1");
        assertThat(nanos).isEqualTo(MILLISECOND);
        turn();
        assertThat(answers).containsExactly("a1", "b1", "a2", "a3");
        assertThat(loop).as("nothing waits").isEmpty();
    }

    @Test
    void aLongQueryLetsOtherClientsGoFirst() {
        ask(a, 1, 4 * MILLISECOND);
        ask(b, 1, MILLISECOND / 10);
        turn();
        assertThat(nanos)
                .as("the long query pauses at the end of its slice")
                .isEqualTo(MILLISECOND);
        turn();
        assertThat(answers).containsExactly("b1");
        while (!loop.isEmpty()) {
            turn();
        }
        assertThat(answers).containsExactly("b1", "a1");
        assertThat(nanos).isEqualTo(41 * MILLISECOND / 10);
    }

    @Test
    void clientsThatControlComeFirst() {
        ask(a, 1, 4 * MILLISECOND);
        ask(b, 1, MILLISECOND);
        ask(operator, 1, MILLISECOND);
        turn();
        assertThat(answers).containsExactly("operator1");
    }

    @Test
    void queriesOfAClientThatHasGoneAreDropped() {
        for (int id = 1; id <= QueryTurns.MOST; id++) {
            ask(a, id, 2 * MILLISECOND);
        }
        ask(b, 1, MILLISECOND / 10);
        turn(); // half of a's first query
        turns.forget(a);
        assertThat(answers).hasSize(QueryTurns.MOST).containsOnly("aworld-busy");
        while (!loop.isEmpty()) {
            turn();
        }
        assertThat(answers).hasSize(QueryTurns.MOST + 1).last().isEqualTo("b1");
        assertThat(nanos).as("no other query of a was answered").isLessThan(2 * MILLISECOND);
    }

    @Test
    void aQueryEndsWhoseClientGoesWhileItIsAnswered() {
        turns.ask(
                a,
                new ClientMessage.Search(1, "toy"),
                0,
                end -> {
                    turns.forget(a); // as another thread may
                    return false;
                });
        turn();
        assertThat(answers).containsExactly("aworld-busy");
        assertThat(loop).as("nothing waits").isEmpty();
    }

    @Test
    void queriesTakeATenthOfTheTimeInTheLongRun() {
        long used = 0;
        for (long frame = 1; frame <= 1000; frame++) {
            ask(a, frame, 5 * MILLISECOND);
            long begin = nanos;
            turns.proceed();
            while (!loop.isEmpty()) {
                turn();
            }
            used += nanos - begin;
            nanos = Math.max(nanos, frame * 10 * MILLISECOND);
        }
        assertThat(used / MILLISECOND)
                .as("of 10000 ms, and 50 ms in advance")
                .isBetween(950L, 1100L);
    }

    @Test
    void aClientThatDoesNotWaitIsRefused() {
        for (int id = 1; id <= QueryTurns.MOST + 2; id++) {
            ask(a, id, MILLISECOND / 10);
        }
        assertThat(answers).containsExactly("aworld-busy", "aworld-busy");
        while (!loop.isEmpty()) {
            turn();
        }
        ask(a, 20, MILLISECOND / 10);
        turn();
        assertThat(answers).hasSize(2 + QueryTurns.MOST + 1).last().isEqualTo("a20");
    }

    @Test
    void aQueryWaitsForItsFrameAtMostASecond() {
        ask(a, 1, 1, MILLISECOND / 10);
        ask(b, 1, 2, MILLISECOND / 10);
        turns.proceed();
        assertThat(loop).as("no frame is published").isEmpty();
        published = 1;
        turns.proceed();
        turn();
        assertThat(answers).containsExactly("a1");
        nanos += 999 * MILLISECOND;
        turns.proceed();
        assertThat(loop).isEmpty();
        nanos += MILLISECOND;
        turns.proceed();
        turn();
        assertThat(answers).containsExactly("a1", "b1");
    }

    @Test
    void queriesThatWaitForAFrameCountAndAreDropped() {
        for (int id = 1; id <= QueryTurns.MOST + 1; id++) {
            ask(a, id, 1, MILLISECOND / 10);
        }
        assertThat(answers).containsExactly("aworld-busy");
        turns.forget(a);
        assertThat(answers).hasSize(QueryTurns.MOST + 1).containsOnly("aworld-busy");
        published = 1;
        turns.proceed();
        assertThat(loop).as("nothing waits").isEmpty();
    }

    /** A client whose refusals are recorded. */
    private final class Asker implements Requester {

        private final String name;

        Asker(String name) {
            this.name = name;
        }

        @Override
        public String name() {
            return name;
        }

        @Override
        public boolean controls() {
            return name.equals("operator");
        }

        @Override
        public Encoding encoding() {
            return Encoding.JSON;
        }

        @Override
        public void endRound(ClientMessage.Ready ready) {
            throw new AssertionError("an observer has no rounds");
        }

        @Override
        public void finish(ClientMessage.Request request, ServerMessage result, long frame) {
            throw new AssertionError("a query has no result");
        }

        @Override
        public void refuse(ClientMessage.Request request, String code, String reason) {
            answers.add(name + code);
        }

        @Override
        public boolean answer(ClientMessage.Request request, byte[] line) {
            throw new AssertionError("the test answers itself");
        }
    }
}
