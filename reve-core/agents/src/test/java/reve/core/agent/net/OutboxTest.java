// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.perception.View;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.List;

/** The order of messages to one client. */
class OutboxTest {

    private final Outbox outbox = new Outbox(2, 100, () -> {});

    @Test
    void whatHappenedComesBeforeThePerceptionsThatShowIt() {
        outbox.offerLatest(2, view(20));
        outbox.offerAnswer(1, view(10));
        outbox.offer(bytes("event"));
        assertThat(List.of(take(), take(), take()))
                .containsExactly("event", "perception 1", "perception 2");
        assertThat(outbox.isEmpty()).isTrue();
    }

    @Test
    void whatHappenedComesBeforeThePerceptionAlsoWhenTheConnectionEnds() {
        outbox.offer(bytes("result"));
        outbox.offer(bytes("event"));
        outbox.offerAnswer(1, view(10));
        outbox.offerLatest(2, view(20));
        outbox.finish(bytes("bye"));
        outbox.offer(bytes("too late"));
        var told = new ArrayList<String>();
        for (String line = take(); line != null; line = take()) {
            told.add(line);
        }
        assertThat(told).containsExactly("result", "event", "perception 1", "bye");
    }

    @Test
    void whatWasWrittenMakesRoomForMore() {
        for (int i = 0; i < 10; i++) {
            assertThat(outbox.offer(new byte[50])).isTrue();
            assertThat(outbox.offer(new byte[50])).isTrue();
            assertThat(outbox.offer(new byte[0])).as("a third message").isFalse();
            outbox.poll();
            assertThat(outbox.offer(new byte[51])).as("101 bytes").isFalse();
            outbox.poll();
        }
    }

    @Test
    void whatHappenedInOneFrameMayWaitHoweverMuchButNotUntilMoreHappens() {
        for (int i = 0; i < 10; i++) {
            assertThat(outbox.offer(new byte[50], 7)).as("event %d", i).isTrue();
        }
        assertThat(outbox.offer(new byte[50])).as("a result").isTrue();
        assertThat(outbox.offer(new byte[50])).as("another").isTrue();
        assertThat(outbox.offer(new byte[0])).as("a third").isFalse();
        assertThat(outbox.offer(new byte[0], 8)).as("an event of the next frame").isFalse();
        for (int i = 0; i < 9; i++) {
            outbox.poll();
        }
        assertThat(outbox.offer(new byte[50], 8)).as("all but one event is read").isTrue();
    }

    @Test
    void eventsThatNobodyReadsAreMissedByTheFrameAndOneMessageSaysSo() {
        offer("a", 7);
        offer("b", 7);
        offer("c", 7);
        assertThat(outbox.offer(bytes("d"), 8)).isFalse();
        outbox.miss(8);
        offer("e", 8);
        assertThat(List.of(take(), take())).containsExactly("a", "b");
        offer("f", 9);
        outbox.offerAnswer(1, view(9));
        assertThat(outbox.offer(bytes("result"))).as("counts apart from events").isTrue();
        assertThat(List.of(take(), take(), take(), take()))
                .as("nothing comes between but what waited before")
                .containsExactly("c", "result", "missed 3 of 8 to 9", "perception 1");
        offer("g", 10);
        assertThat(take()).isEqualTo("g");
        assertThat(outbox.poll()).isNull();
    }

    @Test
    void whoIsSentAwayIsToldBeforeWhatItHasMissed() {
        offer("a", 7);
        offer("b", 7);
        assertThat(outbox.offer(bytes("c"), 8)).isFalse();
        outbox.miss(8);
        outbox.finish(bytes("bye"));
        outbox.miss(9);
        assertThat(List.of(take(), take(), take(), take()))
                .containsExactly("a", "b", "missed 1 of 8 to 8", "bye");
        assertThat(outbox.isDone()).isTrue();
    }

    @Test
    void anEventAloneIsNeverTooLong() {
        assertThat(outbox.offer(new byte[1000], 7)).isTrue();
        assertThat(outbox.offer(new byte[1], 8)).isFalse();
    }

    private void offer(String event, long frame) {
        assertThat(outbox.offer(bytes(event), frame)).as(event).isTrue();
    }

    @Test
    void aDifferenceIsToWhatTheClientWasHandedLastHoweverManyItMissed() {
        outbox.offerLatest(1, view(1));
        outbox.offerLatest(1, view(2));
        assertThat(outbox.poll())
                .as("nobody has read the first")
                .isEqualTo(new Outbox.Perception(1, view(2), null));
        outbox.offerLatest(1, view(3));
        outbox.offerLatest(1, view(4));
        assertThat(outbox.poll()).isEqualTo(new Outbox.Perception(1, view(4), view(2)));
        outbox.offerLatest(1, view(5));
        outbox.restart();
        assertThat(outbox.isEmpty()).isTrue();
        outbox.offerLatest(7, view(6));
        assertThat(outbox.poll()).isEqualTo(new Outbox.Perception(7, view(6), null));
    }

    private static View view(long frame) {
        return new View(frame, 0, List.of());
    }

    @Test
    void whatIsNotToldAtAllIsMissedBehindWhatIs() {
        outbox.miss(7, 3, 5);
        assertThat(take()).isEqualTo("missed 7 of 3 to 5");
        outbox.offer(bytes("event"), 6);
        outbox.miss(9, 6, 6);
        outbox.miss(1, 7, 7);
        assertThat(List.of(take(), take())).containsExactly("event", "missed 10 of 6 to 7");
        assertThat(outbox.isEmpty()).isTrue();
    }

    private String take() {
        return switch (outbox.poll()) {
            case Outbox.Message message -> new String(message.bytes(), StandardCharsets.UTF_8);
            case Outbox.Missed missed ->
                    "missed " + missed.events() + " of " + missed.first() + " to " + missed.last();
            case Outbox.Perception perception -> "perception " + perception.id();
            case null -> null;
        };
    }

    private static byte[] bytes(String text) {
        return text.getBytes(StandardCharsets.UTF_8);
    }
}
