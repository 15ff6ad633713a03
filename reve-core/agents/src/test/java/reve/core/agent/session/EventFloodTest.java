// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.agent.AgentRoom;
import reve.core.agent.TestClient;
import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** One agent raises events faster than another client reads them. */
class EventFloodTest {

    /**
     * Number of frames with events. The sockets and the reader's outbox together hold fewer events.
     */
    private static final int FRAMES = 300;

    private static final int ACTS = 4;
    private static final Parameter WORDS = Parameter.text("words", "What to say.");
    private static final Operand SAID = new Operand.Argument(WORDS);
    private static final String LONG = "x".repeat(1000);

    private AgentRoom room;
    private int id;

    @BeforeEach
    void open() throws IOException {
        Duration never = Duration.ofMinutes(5);
        AgentPolicy policy =
                new AgentPolicy(List.of(), AgentRoom.making().template())
                        .withEvents(1_000_000_000, 1_000_000_000);
        var bell =
                ItemDefinition.named("bell")
                        .shape(Shape.box(1, 1, 1))
                        .action(
                                new DeclaredAction(
                                        "say",
                                        "Says it.",
                                        List.of(WORDS),
                                        List.of(
                                                new Effect.Raise(
                                                        "said",
                                                        "say",
                                                        Map.of(
                                                                "once", SAID, "twice", SAID,
                                                                "thrice", SAID)))));
        room =
                new AgentRoom(
                        AgentRoom.config(never, never, never, never),
                        policy,
                        4096,
                        List.of(bell.build()));
    }

    @AfterEach
    void close() {
        room.close();
    }

    /** Lets a client raise as many events as permitted in each of some frames. */
    private void flood(TestClient evil, int frames) throws IOException {
        for (int i = 0; i < frames; i++) {
            for (int act = 0; act < ACTS; act++) {
                evil.say(
                        ("{'t':'act','id':%d,'item':'bell','action':'say',"
                                        + "'arguments':{'words':'%s'}}")
                                .formatted(++id, LONG));
            }
            evil.sync();
            room.step();
            for (int act = 0; act < ACTS; act++) {
                JsonNode result = evil.skipTo("result");
                assertThat(result.get("accepted").booleanValue()).as("%s", result).isTrue();
            }
        }
    }

    /** Returns all events before a pong. */
    private static List<JsonNode> events(TestClient reader) throws IOException {
        reader.say("{'t':'ping','id':5}");
        var events = new ArrayList<JsonNode>();
        for (JsonNode next = reader.next();
                !next.get("t").stringValue().equals("pong");
                next = reader.next()) {
            if (next.get("t").stringValue().equals("event")) {
                events.add(next);
            }
        }
        return events;
    }

    private static Optional<JsonNode> missed(List<JsonNode> events) {
        return events.stream()
                .filter(event -> event.get("type").stringValue().equals("missed"))
                .findFirst();
    }

    @Test
    void aReaderThatPausesIsToldWhatItMissedAndPerceivesOn() throws IOException {
        try (TestClient slow = new TestClient(room.server.address(), 4096)) {
            slow.say("{'t':'hello','protocol':1,'name':'slow'}").sync();
            room.step();
            slow.expect("welcome");
            slow.expect("event");
            try (TestClient evil = room.join("evil")) {
                long before = room.loop.frame();
                flood(evil, FRAMES);
                assertThat(room.server.stats().cut()).as("clients cut").isZero();
                slow.say(
                        "{'t':'act','id':1,'item':'bell','action':'say',"
                                + "'arguments':{'words':'me as well'}}");
                room.stepUntil(
                        "it has spoken",
                        () -> room.server.stats().actsAccepted() == (long) FRAMES * ACTS + 1);

                List<JsonNode> told = new ArrayList<>(events(slow));
                while (missed(told).isEmpty()) {
                    told.addAll(events(slow)); // earlier events, which the sockets still hold
                }
                JsonNode gap = missed(told).get();
                long first = gap.at("/fields/first").longValue();
                long last = gap.at("/fields/last").longValue();
                assertThat(gap.get("frame").longValue()).isEqualTo(last);
                assertThat(told).extracting(event -> event.get("frame").longValue()).isSorted();
                assertThat(told)
                        .filteredOn(
                                event ->
                                        event.get("frame").longValue() >= first
                                                && event.get("frame").longValue() <= last)
                        .as("frames are missed as a whole")
                        .containsExactly(gap);
                long flooded = Math.min(last, before + FRAMES) - first + 1;
                assertThat(gap.at("/fields/events").longValue())
                        .as("an event and `acted` for each act, those of its own among them")
                        .isEqualTo(2 * ACTS * flooded + (last > before + FRAMES ? 2 : 0));

                flood(evil, 1);
                slow.say("{'t':'perceive','id':2}").sync();
                room.step();
                List<JsonNode> on = new ArrayList<>();
                for (JsonNode next = slow.next();
                        !next.get("t").stringValue().equals("perception");
                        next = slow.next()) {
                    on.add(next);
                }
                assertThat(on)
                        .extracting(event -> event.path("type").asString(""))
                        .contains("said");
                assertThat(missed(on)).isEmpty();
            }
        }
    }

    @Test
    void whatOthersDoWhileItWasAwayDoesNotKeepAClientFromComingBack() throws IOException {
        TestClient ada = room.connect();
        ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':60}").sync();
        room.step();
        JsonNode welcome = ada.expect("welcome");
        ada.close();
        room.stepUntil("its connection is gone", () -> room.server.stats().open() == 0);
        try (TestClient evil = room.join("evil");
                TestClient back = room.connect()) {
            int enough = EventLog.MAX_BYTES / (ACTS * 3 * LONG.length()) + 2;
            flood(evil, enough);
            back.say(
                    "{'t':'hello','protocol':1,'name':'ada','resume':{'session':'"
                            + welcome.at("/session/token").stringValue()
                            + "','frame':1}}");
            assertThat(back.expect("welcome").get("resumed").booleanValue()).isTrue();
            assertThat(back.expect("event").get("type").stringValue()).isEqualTo("missed");
            List<JsonNode> rest = events(back);
            assertThat(rest.size()).isGreaterThan(enough);
            assertThat(missed(rest)).isEmpty();
        }
    }

    @Test
    void clientsThatComeAndGoAllTheTimeCutNobodyEither() throws IOException {
        try (TestClient slow = new TestClient(room.server.address(), 4096)) {
            slow.say("{'t':'hello','protocol':1,'name':'slow','role':'observer'}")
                    .expect("welcome");
            String longName = "n".repeat(60);
            for (int i = 0; i < 1500; i++) {
                try (TestClient guest = room.connect()) {
                    guest.say("{'t':'hello','protocol':1,'name':'" + longName + i % 100 + "'}");
                    guest.say("{'t':'bye'}");
                    room.step();
                }
            }
            assertThat(room.server.stats().cut()).isZero();
            slow.say("{'t':'perceive','id':2}").sync();
            room.step();
            slow.skipTo("perception");
        }
    }
}
