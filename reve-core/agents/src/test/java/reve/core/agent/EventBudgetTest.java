// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.Shape;
import reve.core.world.WorldEvent;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.List;
import java.util.Map;

/**
 * The limit of bytes of events that agents' actions raise in a second of world time, over the wire.
 */
class EventBudgetTest {

    /** Frames of a second in the room. */
    private static final int SECOND = 60;

    private static final int BYTES = 1000;
    private static final int WORLD_BYTES = 1500;
    private static final Parameter WORDS = Parameter.text("words", "What to say.");

    /**
     * Bytes of an event without its text: "said", "item" "bell", "action" "say", "actor" "ada" or
     * "bob", and "words".
     */
    private static final int OTHER_BYTES = 4 + 4 + 4 + 6 + 3 + 5 + 3 + 5;

    private AgentRoom room;
    private int id;

    @BeforeEach
    void open() throws IOException {
        var bell =
                ItemDefinition.named("bell")
                        .shape(Shape.box(1, 1, 1))
                        .action(
                                new DeclaredAction(
                                        "say",
                                        "Says it.",
                                        List.of(WORDS),
                                        List.of(
                                                new Effect.SetSymbol(
                                                        "rung", new Operand.Argument(WORDS)),
                                                new Effect.Raise(
                                                        "said",
                                                        "say",
                                                        Map.of(
                                                                "words",
                                                                new Operand.Argument(WORDS))))))
                        .action(
                                new DeclaredAction(
                                        "nod",
                                        "Says nothing.",
                                        List.of(),
                                        List.of(
                                                new Effect.SetSymbol(
                                                        "rung", new Operand.Symbol("no")))));
        room =
                new AgentRoom(
                        AgentRoom.CONFIG,
                        AgentRoom.making().withEvents(BYTES, WORLD_BYTES),
                        64,
                        List.of(bell.build()));
        nextSecond();
    }

    @AfterEach
    void close() {
        room.close();
    }

    /** Makes frames until the next one is among the first of a second. */
    private void nextSecond() {
        do {
            room.step();
        } while (room.loop.frame() % SECOND != 0);
    }

    /** Says a text of that many letters, and returns the result of the act. */
    private JsonNode say(TestClient client, int letters) throws IOException {
        client.say(
                        "{'t':'act','id':%d,'item':'bell','action':'say','arguments':{'words':'%s'}}"
                                .formatted(++id, "x".repeat(letters)))
                .sync();
        room.step();
        return client.skipTo("result");
    }

    /** Returns the last text that was said to the bell. */
    private String rung() {
        return (String) room.item("bell").semantic().get("rung").orElseThrow();
    }

    private String code(TestClient client, int letters) throws IOException {
        return say(client, letters).path("code").asString("");
    }

    @Test
    void anEventIsAsLargeAsItsTextsInUtf8AndEightBytesForANumber() {
        assertThat(
                        new WorldEvent(
                                        1,
                                        "said",
                                        Map.of("who", "\u00e4da", "loud", true, "db", 3.5))
                                .bytes())
                .isEqualTo(4 + 3 + 4 + 4 + 8 + 2 + 8);
    }

    @Test
    void theWelcomeSaysBothBudgets() throws IOException {
        try (TestClient ada =
                room.connect().say("{'t':'hello','protocol':1,'name':'ada'}").sync()) {
            room.step();
            JsonNode limits = ada.expect("welcome").get("limits");
            assertThat(limits.get("eventBytes").intValue()).isEqualTo(BYTES);
            assertThat(limits.get("worldEventBytes").intValue()).isEqualTo(WORLD_BYTES);
        }
    }

    @Test
    void anActWhoseEventsExceedTheBudgetIsRefusedBeforeAnythingOfItHappens() throws IOException {
        try (TestClient ada = room.join("ada")) {
            assertThat(code(ada, 900)).isEmpty();
            assertThat(rung()).hasSize(900);
            int frames = (int) (SECOND - (room.loop.frame() + 1) % SECOND);
            assertThat(say(ada, 67))
                    .isEqualTo(
                            TestClient.json(
                                    ("{'t':'result','id':2,'accepted':false,'code':'too-many-events','reason':'the"
                                                    + " action raises events of 101 bytes, and your actions"
                                                    + " have raised 934 of at most 1000 bytes in this second"
                                                    + " of world time; give it shorter texts, or try again in"
                                                    + " %d frames'}")
                                            .formatted(frames)));
            assertThat(rung()).as("nothing of it").hasSize(900);
            assertThat(code(ada, 66 - OTHER_BYTES)).as("all that is left").isEmpty();
            ada.say("{'t':'act','id':99,'item':'bell','action':'nod'}").sync();
            room.step();
            assertThat(ada.skipTo("result").get("accepted").booleanValue())
                    .as("an action without events")
                    .isTrue();
        }
    }

    @Test
    void theBudgetIsFullAgainInTheNextSecondOfWorldTimeAlsoAfterARewind() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            boss.say("{'t':'snapshot','id':1,'image':'before'}").sync();
            assertThat(code(ada, 900)).isEmpty();
            boss.say("{'t':'rewind','id':2,'image':'before'}").sync();
            room.step();
            assertThat(code(ada, 900)).as("frames are counted on").isEqualTo("too-many-events");
            nextSecond();
            assertThat(code(ada, 900)).isEmpty();
            assertThat(code(ada, 900)).isEqualTo("too-many-events");
        }
    }

    @Test
    void aTextThatNeverFitsIsRefusedWithThatHint() throws IOException {
        try (TestClient ada = room.join("ada")) {
            JsonNode result = say(ada, BYTES);
            assertThat(result.get("code").stringValue()).isEqualTo("too-many-events");
            assertThat(result.get("reason").stringValue()).endsWith("; give it shorter texts");
        }
    }

    @Test
    void theBudgetOfTheWorldHoldsForAllTogetherAndLeavingGivesNothingBack() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient bob = room.join("bob")) {
            assertThat(code(ada, 900)).isEmpty();
            JsonNode refused = say(bob, 900);
            assertThat(refused.get("reason").stringValue())
                    .contains("actions of all agents have raised 934 of at most 1500 bytes");
            assertThat(code(bob, 500)).isEmpty();
            ada.say("{'t':'bye'}");
            ada.skipToBye("goodbye");
        }
        while (room.has("ada")) {
            room.step();
        }
        try (TestClient ada = room.join("ada")) {
            assertThat(code(ada, 100)).isEqualTo("too-many-events");
        }
    }
}
