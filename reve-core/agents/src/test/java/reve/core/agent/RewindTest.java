// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.List;
import java.util.Optional;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;

/** Rewinds of a world while agents are in it. */
class RewindTest {

    private AgentRoom room;
    private TestClient boss;

    @BeforeEach
    void open() throws IOException {
        room = new AgentRoom();
        boss = control(room);
    }

    @AfterEach
    void close() throws IOException {
        boss.close();
        room.close();
    }

    @Test
    void theWorldIsAsItWasAndTimeGoesOnFromThereWhileFramesAreCountedOn() throws IOException {
        boss.say("{'t':'perceive','id':1,'every':1}").sync();
        room.step();
        double then = boss.expect("perception").get("time").doubleValue();
        boss.say("{'t':'snapshot','id':2,'image':'calm'}").sync();
        room.step();
        assertThat(boss.expect("result").get("frame").longValue()).isEqualTo(1);
        boss.expect("perception");
        room.item("duck").physics().set("velocity", 0, 9, 0);
        room.world.remove(room.item("duck").id());
        room.step();
        assertThat(boss.expect("perception").get("left").get(0).stringValue()).isEqualTo("duck");

        boss.say("{'t':'rewind','id':3,'image':'calm'}").sync();
        room.step();

        assertThat(boss.expect("result").get("frame").longValue()).isEqualTo(4);
        JsonNode event = boss.expect("event");
        assertThat(event.get("type").stringValue()).isEqualTo("rewound");
        assertThat(event.get("frame").longValue()).isEqualTo(4);
        assertThat(event.at("/fields/image").stringValue()).isEqualTo("calm");
        JsonNode seen = boss.skipTo("perception");
        assertThat(seen.has("since")).as("%s", seen).isFalse();
        assertThat(seen.at("/items/0/name").stringValue()).isEqualTo("duck");
        assertThat(seen.get("time").doubleValue() - then).isBetween(0.0, 1.5 / 60);
        assertThat(room.item("duck").physics().vector("velocity")).containsExactly(0, 0, 0);
        assertThat(room.loop.frame()).isEqualTo(5);
    }

    @Test
    void whileTheWorldIsPausedARewindIsDoneAndPerceivedAtOnce() throws Exception {
        try (var _ = new Running(room)) {
            boss.say("{'t':'pause','id':1}").skipTo("result");
            boss.say("{'t':'perceive','id':2,'every':1000}").sync();
            for (int id = 3; id < 6; id++) {
                boss.say("{'t':'rewind','id':" + id + "}");
                long frame = boss.skipTo("result").get("frame").longValue();
                JsonNode seen = boss.skipTo("perception");
                assertThat(seen.get("frame").longValue()).isEqualTo(frame);
                assertThat(seen.get("time").doubleValue()).isZero();
                assertThat(seen.has("since")).isFalse();
            }
        }
    }

    @Test
    void theResultOfAStepComesBeforeWhatIsPerceivedOfIt() throws Exception {
        try (var _ = new Running(room)) {
            boss.say("{'t':'pause','id':1}").skipTo("result");
            boss.say("{'t':'perceive','id':2,'every':1}").sync();
            // The client may also perceive the frame that was in progress at the pause.
            long first = boss.say("{'t':'step','id':3}").skipTo("result").get("frame").longValue();
            for (long seen = 0; seen < first; ) {
                seen = boss.skipTo("perception").get("frame").longValue();
            }
            for (int id = 4; id < 200; id++) {
                long frame =
                        boss.say("{'t':'step','id':" + id + "}")
                                .expect("result")
                                .get("frame")
                                .longValue();
                assertThat(boss.expect("perception").get("frame").longValue()).isEqualTo(frame);
            }
        }
    }

    @Test
    void agentsStayWithTheBodiesThatTheyHadOrGetThemAnew() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient bob = room.join("bob")) {
            keep("two");
            bob.say("{'t':'bye'}").skipToBye("goodbye");
            room.step();
            try (TestClient cy = room.join("cy")) {
                room.item("ada").physical().setLocation(7, 7, 7);
                long idOfCy = room.item("cy").id().value();

                JsonNode result = rewind("two");

                assertThat(result.get("accepted").booleanValue()).isTrue();
                assertThat(room.item("ada").physical().location()).containsExactly(0, 0.5, 0);
                assertThat(room.has("bob")).as("the body of one who has left").isFalse();
                assertThat(room.has("cy")).isTrue();
                assertThat(room.item("cy").id().value()).isEqualTo(idOfCy);
                assertThat(act(ada)).isTrue();
                assertThat(act(cy)).isTrue();
                cy.say("{'t':'bye'}").skipToBye("goodbye");
                room.step();
                assertThat(room.has("cy")).isFalse();
                assertThat(room.has("ada")).isTrue();
            }
        }
    }

    @Test
    void anIdThatIsGivenAgainAfterARewindIsNotTakenForTheBodyThatHadIt() throws IOException {
        keep("empty");
        try (TestClient ada = room.join("ada")) {
            rewind("empty");
            try (TestClient abe = room.join("abe")) {
                ada.say("{'t':'bye'}").skipToBye("goodbye");
                room.step();
                assertThat(room.has("ada")).isFalse();
                assertThat(room.has("abe")).isTrue();
                assertThat(act(abe)).isTrue();
            }
        }
    }

    @Test
    void aLentBodyIsWhereItWasAndStaysWithItsAgent() throws IOException {
        try (AgentRoom lending = new AgentRoom(AgentRoom.CONFIG, AgentRoom.lending("duck"), 64);
                TestClient chief = control(lending);
                TestClient ada = lending.join("ada")) {
            lending.item("duck").physical().setLocation(3, 3, 3);
            chief.say("{'t':'rewind','id':1}").sync();
            lending.step();
            assertThat(chief.skipTo("result").get("accepted").booleanValue()).isTrue();
            assertThat(lending.item("duck").physical().location()).containsExactly(1, 0, -2.5);
            try (TestClient bob = lending.connect()) {
                bob.say("{'t':'hello','protocol':1,'name':'bob'}").sync();
                lending.step();
                bob.expectBye("no-body-free");
            }
            assertThat(act(lending, ada)).isTrue();
        }
    }

    @Test
    void whoSensesGoesOnSensingFromTheBodyThatItHasThen() throws IOException {
        ItemDefinition body =
                ItemDefinition.named("body")
                        .shape(Shape.box(0.5, 1, 0.5))
                        .at(0, 0.5, 0)
                        .sensor(Sensor.sight("eyes", 5))
                        .build();
        try (AgentRoom sensing =
                        new AgentRoom(
                                AgentRoom.CONFIG,
                                new AgentPolicy(List.of(), Optional.of(body)),
                                64);
                TestClient chief = control(sensing);
                TestClient ada = sensing.join("ada")) {
            sensing.world.add(
                    ItemDefinition.named("far").shape(Shape.sphere(1)).at(50, 0, 0).build());
            ada.say("{'t':'perceive','id':1,'every':1}").sync();
            sensing.step();
            ada.skipTo("perception");
            sensing.item("ada").physical().setLocation(50, 0, 0);
            sensing.step();
            ada.skipTo("perception");
            chief.say("{'t':'rewind','id':1}").sync();
            sensing.step();
            JsonNode seen = ada.skipTo("perception");
            assertThat(seen.get("items").toString())
                    .contains("duck")
                    .contains("ada")
                    .doesNotContain("far");
        }
    }

    @Test
    void whoCannotHaveItsBodyAgainLeaves() throws IOException {
        room.world.add(ItemDefinition.named("ada").at(9, 9, 9).build());
        keep("full");
        room.world.remove(room.item("ada").id());
        try (TestClient ada = room.join("ada")) {
            rewind("full");
            ada.skipToBye("name-taken");
            assertThat(boss.skipTo("event").get("type").stringValue()).isEqualTo("rewound");
            assertThat(boss.skipTo("event").at("/fields/reason").stringValue())
                    .isEqualTo("rewound");
            assertThat(room.item("ada").physical().location()).containsExactly(9, 9, 9);
        }
    }

    @Test
    void anImageThatIsNotKeptIsRefusedWithTheOnesThatAre() throws IOException {
        keep("one");
        keep("two");
        JsonNode refused = rewind("three");
        assertThat(refused.get("code").stringValue()).isEqualTo("no-such-image");
        assertThat(refused.get("reason").stringValue())
                .contains("three")
                .contains("kept are one, two");
    }

    /** A room whose world runs in a thread of its own until it is closed. */
    private record Running(AgentRoom room, ExecutorService thread) implements AutoCloseable {
        Running(AgentRoom room) {
            this(room, Executors.newSingleThreadExecutor());
            thread.submit(() -> room.loop.run());
        }

        @Override
        public void close() {
            room.loop.stop();
            thread.close();
            room.world.guard().claim();
        }
    }

    private int lastId;

    private void keep(String image) throws IOException {
        boss.say("{'t':'snapshot','id':" + ++lastId + ",'image':'" + image + "'}").sync();
        room.step();
        assertThat(boss.skipTo("result").get("accepted").booleanValue()).isTrue();
    }

    private JsonNode rewind(String image) throws IOException {
        boss.say("{'t':'rewind','id':" + ++lastId + ",'image':'" + image + "'}").sync();
        room.step();
        return boss.skipTo("result");
    }

    private boolean act(TestClient agent) throws IOException {
        return act(room, agent);
    }

    private boolean act(AgentRoom in, TestClient agent) throws IOException {
        agent.say("{'t':'act','id':" + ++lastId + ",'item':'duck','action':'wind-up'}").sync();
        in.step();
        return agent.skipTo("result").get("accepted").booleanValue();
    }

    private static TestClient control(AgentRoom in) throws IOException {
        TestClient client = in.connect();
        client.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
        return client;
    }
}
