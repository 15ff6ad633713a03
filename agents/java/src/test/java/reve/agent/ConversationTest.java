// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import static org.assertj.core.api.Assertions.assertThat;

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
                            Optional.of(new Welcome.Ticket("secret", 60)),
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
                                    OptionalInt.empty())));

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
}
