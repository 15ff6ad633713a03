// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;

import java.time.Duration;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.OptionalLong;

/** The way in which a client processes events that it missed. The test has no connection. */
class ConversationTest {

    private final Conversation talk =
            new Conversation(
                    Join.as("ada").withGrace(Duration.ofSeconds(60)),
                    new Welcome(
                            OptionalLong.empty(),
                            1,
                            "agent",
                            "ada",
                            Optional.of("ada"),
                            "pond",
                            1,
                            60,
                            "json",
                            Optional.empty(),
                            Optional.of(new Welcome.Ticket("secret", 60, List.of())),
                            false,
                            new Welcome.Limits(
                                    65_536,
                                    4096,
                                    64,
                                    15,
                                    60,
                                    OptionalInt.empty(),
                                    OptionalInt.empty(),
                                    OptionalInt.empty(),
                                    OptionalInt.empty()),
                            List.of()));

    private static WorldEvent said(long frame) {
        return new WorldEvent(frame, "said", Map.of());
    }

    private static WorldEvent missed(double first, long last) {
        return new WorldEvent(
                last, WorldEvent.MISSED, Map.of("first", first, "last", (double) last));
    }

    private void take(WorldEvent... events) {
        List.of(events).forEach(talk::take);
    }

    private long frameSeen() {
        return talk.greeting().orElseThrow().resume().orElseThrow().frame();
    }

    private List<Long> frames() {
        return talk.events().stream().map(WorldEvent::frame).toList();
    }

    @Test
    void aGapIsAnEventAndCounted() {
        take(
                said(3),
                new WorldEvent(
                        9, WorldEvent.MISSED, Map.of("events", 12.0, "first", 4.0, "last", 9.0)),
                said(10),
                missed(11, 12));
        assertThat(talk.missedEvents()).isEqualTo(13);
        assertThat(talk.events())
                .extracting(WorldEvent::type)
                .containsExactly("said", "missed", "said", "missed");
    }

    @Test
    void aGapIsNotAskedForAgainAfterABreak() {
        take(missed(2, 9));
        assertThat(frameSeen()).isEqualTo(9);
        talk.goneOn();
        take(said(10));
        assertThat(frames()).containsExactly(9L, 10L);
    }

    @Test
    void eventsKnownBeforeABreakAreSkippedOnlyWhereTheyAreToldAgain() {
        take(said(5), said(5), said(5));
        assertThat(frameSeen()).isEqualTo(4);
        talk.goneOn();
        take(missed(5, 8), said(9)); // the server no longer has those either
        assertThat(frames()).containsExactly(5L, 5L, 5L, 8L, 9L);
    }

    private static WorldEvent heard(long frame, String text) {
        return new WorldEvent(
                frame,
                "heard",
                Map.of("text", text, "direction", List.of(0.0, 0.6, -0.8), "distance", 2.5));
    }

    private void perceive(long id, long frame) {
        talk.take(new Perception(OptionalLong.of(id), frame, frame / 60.0, List.of(), Map.of()));
    }

    @Test
    void whatIsHeardBelongsToTheNextPerceptionThatIsReturned() {
        talk.subscribe(1);
        take(
                new WorldEvent(
                        3,
                        "heard",
                        Map.of(
                                "text",
                                "one …",
                                "lost",
                                1.0,
                                "speaker",
                                "bob",
                                "direction",
                                List.of(0.0, 0.6, -0.8),
                                "distance",
                                2.5)));
        perceive(1, 3);
        take(heard(4, "two"));
        perceive(1, 4);
        take(heard(5, "three")); // of a frame that is not perceived yet
        assertThat(talk.news().heard())
                .containsExactly(
                        new Heard(3, "one …", 1, Optional.of("bob"), 0, 0.6, -0.8, 2.5),
                        new Heard(4, "two", 0, Optional.empty(), 0, 0.6, -0.8, 2.5));
        perceive(1, 5);
        assertThat(talk.news().heard()).extracting(Heard::text).containsExactly("three");
        perceive(1, 6);
        assertThat(talk.news().heard()).isEmpty();
        assertThat(talk.events()).extracting(WorldEvent::type).containsOnly("heard").hasSize(3);
    }

    @Test
    void aSinglePerceptionHasWhatWasHeardAndAPredictionHasNot() {
        long future = talk.fork(60, List.of()).id();
        long id = talk.question(number -> Protocol.perceive(number, 1)).id();
        take(heard(7, "one"));
        perceive(future, 70);
        perceive(id, 7);
        assertThat(talk.answer(future, Perception.class).heard()).isEmpty();
        assertThat(talk.answer(id, Perception.class).heard())
                .extracting(Heard::text)
                .containsExactly("one");
    }

    @Test
    void aHeardEventWithoutDirectionIsNoMessage() {
        assertThatExceptionOfType(AgentException.class)
                .isThrownBy(
                        () ->
                                take(
                                        new WorldEvent(
                                                3, "heard", Map.of("text", "a", "distance", 1.0))));
    }
}
