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
import java.util.Map;

/** Readings of laws' own columns, with a clock, a world and an event loop that the test drives. */
class ColumnReadingsTest {
    private static final long MILLISECOND = 1_000_000;

    private final Deque<Runnable> world = new ArrayDeque<>();
    private final Deque<Runnable> loop = new ArrayDeque<>();
    private final List<String> answers = new ArrayList<>();
    private long nanos;
    private long costNanos = MILLISECOND / 100;
    private final ColumnReadings readings =
            new ColumnReadings(
                    world::add,
                    loop::add,
                    item -> {
                        nanos += costNanos;
                        return Map.of("of", item);
                    },
                    (requester, query, columns) ->
                            answers.add(requester.name() + query.id() + columns),
                    () -> nanos);

    private final Requester a = new Asker("a");
    private final Requester b = new Asker("b");
    private final Requester operator = new Asker("operator");

    private void ask(Requester requester, long id) {
        readings.ask(requester, new ClientMessage.Inspect(id, "duck"));
    }

    /** Makes a frame: the world's thread runs what waits for it, and the event loop follows. */
    private void frame() {
        for (int left = world.size(); left > 0; left--) {
            world.remove().run();
        }
        while (!loop.isEmpty()) {
            loop.remove().run();
        }
    }

    @Test
    void severalQueriesAreReadBetweenTwoFramesAndThoseOfOperatorsFirst() {
        for (int id = 1; id <= 8; id++) {
            ask(a, id);
        }
        ask(b, 1);
        ask(operator, 1);
        assertThat(world).as("readings at once").hasSize(1);
        frame();
        assertThat(answers).containsExactly("a1{of=duck}");
        frame();
        assertThat(answers).hasSize(9).element(1).isEqualTo("operator1{of=duck}");
        frame();
        assertThat(answers).hasSize(10).last().isEqualTo("b1{of=duck}");
        assertThat(world).isEmpty();
    }

    @Test
    void aQueryOfAWorldThatMakesNoFrameIsAnsweredWithoutColumnsAfterASecond() {
        ask(a, 1);
        nanos += 500 * MILLISECOND;
        ask(a, 2);
        nanos += 499 * MILLISECOND;
        readings.proceed();
        assertThat(answers).isEmpty();
        nanos += MILLISECOND;
        readings.proceed();
        assertThat(answers).containsExactly("a1{}");
        nanos += 500 * MILLISECOND;
        readings.proceed();
        assertThat(answers).containsExactly("a1{}", "a2{}");
        frame();
        assertThat(answers).as("nothing is answered twice").hasSize(2);
        ask(a, 3);
        frame();
        assertThat(answers).last().isEqualTo("a3{of=duck}");
    }

    @Test
    void readingsTakeATenthOfTheTimeInTheLongRun() {
        costNanos = MILLISECOND;
        long used = 0;
        for (long frame = 1; frame <= 1000; frame++) {
            for (int i = 0; i < 8; i++) {
                ask(a, i);
            }
            long begin = nanos;
            frame();
            used += nanos - begin;
            nanos = Math.max(nanos, frame * 10 * MILLISECOND);
            readings.proceed();
        }
        assertThat(used / MILLISECOND)
                .as("of 10000 ms, and 50 ms in advance")
                .isBetween(900L, 1100L);
    }

    @Test
    void aClientThatDoesNotWaitIsRefusedAndOneThatHasGoneIsForgotten() {
        for (int id = 1; id <= QueryTurns.MOST + 1; id++) {
            ask(a, id);
        }
        assertThat(answers).containsExactly("aworld-busy");
        ask(b, 1);
        readings.forget(a);
        assertThat(answers).hasSize(QueryTurns.MOST + 1).containsOnly("aworld-busy");
        frame();
        frame();
        assertThat(answers).hasSize(QueryTurns.MOST + 2).last().isEqualTo("b1{of=duck}");
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
        public boolean answer(ClientMessage.Request query, byte[] line) {
            throw new AssertionError("the turns of queries answer it");
        }

        @Override
        public void refuse(ClientMessage.Request request, String code, String reason) {
            answers.add(name + code);
        }
    }
}
