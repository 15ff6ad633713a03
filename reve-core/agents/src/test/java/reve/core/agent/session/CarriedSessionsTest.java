// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.agent.AgentRoom;
import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.TestClient;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Rights;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.FinishedCommand;
import reve.core.agent.port.SessionNote;
import reve.core.agent.protocol.Role;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeMap;

/** Sessions that continue on another server, to which their world moves. */
class CarriedSessionsTest {
    private static final String NEXT = "127.0.0.1:9";
    private static final String PUSH =
            "{'t':'act','id':%d,'item':'duck','action':'push','arguments':{'impulse':[2,0,0]}}";

    @TempDir private Path folder;
    private AgentRoom room;
    private AgentServer second;

    @BeforeEach
    void open() throws IOException {
        room = new AgentRoom();
        second = server(AgentRoom.CONFIG);
    }

    @AfterEach
    void close() {
        second.close();
        room.close();
    }

    private static AgentServer server(AgentServerConfig config) throws IOException {
        return AgentServer.start(config, List.of(), (source, message) -> {});
    }

    /** Joins with a grace, and returns the session token. */
    private String join(TestClient client, String name, String more) throws IOException {
        client.say("{'t':'hello','protocol':1,'name':'" + name + "','graceSeconds':60" + more + "}")
                .sync();
        room.step();
        return client.skipTo("welcome").at("/session/token").stringValue();
    }

    private TestClient resume(String name, String session, long frame) throws IOException {
        return new TestClient(second.address())
                .say(
                        "{'t':'hello','protocol':1,'name':'"
                                + name
                                + "','resume':{'session':'"
                                + session
                                + "','frame':"
                                + frame
                                + "}}");
    }

    private double speed() {
        return room.item("duck").physics().vector("velocity")[0];
    }

    @Test
    void aSessionContinuesWithItsBodyAndItsToken() throws IOException {
        List<CarriedSession> carried;
        String session;
        long acted;
        try (TestClient ada = room.connect()) {
            session = join(ada, "ada", "");
            ada.say(PUSH.formatted(1)).sync();
            room.step();
            acted = ada.skipTo("result").get("frame").longValue();
            carried = room.server.remove("pond", Optional.of(NEXT));
            JsonNode bye = ada.skipTo("bye");
            assertThat(bye.get("code").stringValue()).isEqualTo("moved");
            assertThat(bye.get("address").stringValue()).isEqualTo(NEXT);
        }
        assertThat(carried).singleElement().extracting(CarriedSession::client).isEqualTo("ada");
        assertThat(carried.getFirst().state()).doesNotContain(session);
        assertThat(room.has("ada")).as("the body stays").isTrue();
        assertThat(speed()).isEqualTo(1);
        second.add(room.port, carried);
        room.step();
        try (TestClient eve = resume("ada", "0".repeat(32), 0)) {
            eve.expectBye("no-such-session");
        }
        try (TestClient ada = resume("ada", session, acted - 1)) {
            JsonNode welcome = ada.expect("welcome");
            assertThat(welcome.get("resumed").booleanValue()).isTrue();
            assertThat(welcome.get("body").stringValue()).isEqualTo("ada");
            assertThat(welcome.get("frame").longValue()).isEqualTo(room.loop.frame());
            assertThat(welcome.at("/session/token").stringValue()).isEqualTo(session);
            JsonNode event = ada.expect("event");
            assertThat(event.get("type").stringValue()).isEqualTo("acted");
            assertThat(event.get("frame").longValue()).isEqualTo(acted);
            ada.say(PUSH.formatted(1)); // a client that did not get the result asks again
            assertThat(ada.skipTo("result").get("frame").longValue()).isEqualTo(acted);
            room.step();
            assertThat(speed()).as("no act is executed twice").isEqualTo(1);
            ada.say(PUSH.formatted(2)).sync();
            room.step();
            assertThat(ada.skipTo("result").get("accepted").booleanValue()).isTrue();
            assertThat(speed()).isEqualTo(2);
            ada.say("{'t':'bye'}");
            ada.skipToBye("goodbye");
        }
        room.stepUntil("the body is removed", () -> !room.has("ada"));
    }

    @Test
    void eventsBetweenTheServersReachTheClient() throws IOException {
        String session;
        List<CarriedSession> carried;
        long seen;
        try (TestClient eye = room.connect()) {
            session = join(eye, "eye", ",'role':'observer'");
            seen = room.loop.frame();
            carried = room.server.remove("pond", Optional.of(NEXT));
            eye.skipToBye("moved");
        }
        assertThat(carried.getFirst().body()).isEmpty();
        second.add(room.port, carried);
        try (TestClient ada = new TestClient(second.address())) {
            ada.say("{'t':'hello','protocol':1,'name':'ada'}").sync();
            room.step();
            ada.expect("welcome");
            try (TestClient eye = resume("eye", session, seen)) {
                assertThat(eye.expect("welcome").get("role").stringValue()).isEqualTo("observer");
                JsonNode event = eye.expect("event");
                assertThat(event.get("type").stringValue()).isEqualTo("joined");
                assertThat(event.at("/fields/agent").stringValue()).isEqualTo("ada");
            }
        }
    }

    @Test
    void anAgentInLockStepContinuesItsRounds() throws Exception {
        String session;
        List<CarriedSession> carried;
        String time =
                ",'time':{'mode':'lock-step','deadline':1000,'every':3,'fallback':{'action':'wait',"
                        + "'arguments':{'seconds':2.0,'at':[1,2.5]}}}";
        try (TestClient ada = room.connect()) {
            session = join(ada, "ada", time);
            carried = room.server.remove("pond", Optional.of(NEXT));
            ada.skipToBye("moved");
        }
        second.add(room.port, carried);
        assertThat(second.inLockStep("pond")).isEqualTo(1);
        long frame = room.loop.frame();
        Thread world = new Thread(room.loop::run, "world");
        try (TestClient ada = resume("ada", session, frame)) {
            JsonNode rhythm = ada.expect("welcome").get("time");
            assertThat(rhythm.get("every").intValue()).isEqualTo(3);
            assertThat(rhythm.get("deadline").doubleValue()).isEqualTo(300);
            world.start();
            assertThat(ada.skipTo("perception").get("frame").longValue()).isEqualTo(frame + 1);
            ada.say("{'t':'ready','frame':" + (frame + 1) + "}");
            assertThat(ada.skipTo("perception").get("frame").longValue()).isEqualTo(frame + 4);
            assertThat(room.loop.frame()).as("it waits").isLessThanOrEqualTo(frame + 4);
        } finally {
            room.loop.stop();
            world.join();
        }
    }

    /** A damaged session is lost. The world and the other sessions continue. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            value = {
                "\"every\":3 | \"every\":0",
                "\"deadline\":1000.0 | \"deadline\":-1",
                "\"deadline\":1000.0 | \"deadline\":1e300",
                "\"graceSeconds\":60.0 | \"graceSeconds\":1e300",
                "\"encoding\":\"json\" | \"encoding\":\"x\""
            })
    void aDamagedSessionIsLostAndNotItsWorld(String whole, String damaged) throws Exception {
        List<CarriedSession> carried;
        String session;
        try (TestClient ada = room.connect();
                TestClient eve = room.connect()) {
            join(ada, "ada", ",'time':{'mode':'lock-step','deadline':1000,'every':3}");
            session = join(eve, "eve", "");
            carried = new ArrayList<>(room.server.remove("pond", Optional.of(NEXT)));
        }
        CarriedSession ada = carried.getFirst();
        assertThat(ada.state()).contains(whole);
        carried.set(
                0,
                new CarriedSession(ada.client(), ada.body(), ada.state().replace(whole, damaged)));
        second.add(room.port, carried);
        assertThat(second.inLockStep("pond")).isZero();
        room.stepUntil("the body of ada is removed", () -> !room.has("ada"));
        try (TestClient eve = resume("eve", session, room.loop.frame())) {
            assertThat(eve.expect("welcome").get("resumed").booleanValue()).isTrue();
        }
    }

    @Test
    void aClientWithoutAGraceLeaves() throws IOException {
        try (TestClient ada = room.join("ada")) {
            assertThat(room.server.remove("pond", Optional.of(NEXT))).isEmpty();
            ada.skipToBye("moved");
        }
    }

    @Test
    void aWorldThatEndsCarriesNoSessions() throws IOException {
        try (TestClient ada = room.connect()) {
            join(ada, "ada", "");
            assertThat(room.server.remove("pond", Optional.empty())).isEmpty();
            ada.skipToBye("closing");
        }
    }

    /**
     * The body of an agent whose client does not return is removed, as after a broken connection.
     */
    @Test
    void anAgentThatDoesNotReturnLeavesAfterItsGrace() throws IOException {
        List<CarriedSession> carried;
        try (TestClient ada = room.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':0.05}").sync();
            room.step();
            ada.skipTo("welcome");
            carried = room.server.remove("pond", Optional.of(NEXT));
        }
        second.add(room.port, carried);
        try (TestClient eye = new TestClient(second.address())) {
            eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}").expect("welcome");
            room.stepUntil("ada has left", () -> !room.has("ada"));
            JsonNode left = eye.skipTo("event");
            assertThat(left.get("type").stringValue()).isEqualTo("left");
            assertThat(left.at("/fields/reason").stringValue()).isEqualTo("lost");
        }
    }

    /** A second move does not begin the grace of a lost client again. */
    @Test
    void theGraceGoesOnWhileWorldsMove() throws Exception {
        List<CarriedSession> carried;
        try (TestClient ada = room.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':6}").sync();
            room.step();
            ada.skipTo("welcome");
            carried = room.server.remove("pond", Optional.of(NEXT));
        }
        long end = System.nanoTime() + 600_000_000_000L;
        int moves = 0;
        while (room.has("ada") && System.nanoTime() < end) {
            second.add(room.port, carried);
            for (int i = 0; i < 2; i++) {
                Thread.sleep(50);
                room.step();
            }
            carried = second.remove("pond", Optional.of(NEXT));
            moves++;
        }
        assertThat(room.has("ada")).as("after %d moves", moves).isFalse();
        assertThat(moves).isGreaterThan(2);
    }

    @Test
    void aTokenThatIsNoLongerValidEndsTheSession() throws IOException {
        Path file = folder.resolve("tokens.json");
        AgentToken.Issued token =
                AgentToken.issue(
                        "ada",
                        new Rights(
                                Set.of(Role.AGENT),
                                Optional.empty(),
                                Optional.empty(),
                                Optional.empty(),
                                false),
                        Optional.empty());
        TokenFile.add(file, token.token());
        AgentServerConfig config =
                AgentServerConfig.on(
                        AgentRoom.CONFIG.address(),
                        new AgentSecurity(Optional.of(TokenFile.open(file)), Optional.empty()));
        for (boolean isRevoked : List.of(false, true)) {
            try (AgentRoom guarded = new AgentRoom(config);
                    AgentServer next = server(isRevoked ? AgentRoom.CONFIG : config);
                    TestClient ada = guarded.connect()) {
                ada.say(
                                "{'t':'hello','protocol':1,'name':'ada','graceSeconds':60,'token':'"
                                        + token.secret()
                                        + "'}")
                        .sync();
                guarded.step();
                ada.skipTo("welcome");
                next.add(guarded.port, guarded.server.remove("pond", Optional.of(NEXT)));
                guarded.step();
                assertThat(guarded.has("ada")).isEqualTo(!isRevoked);
            }
        }
    }

    @Test
    void aSessionOfAnotherVersionEnds() throws IOException {
        List<CarriedSession> carried;
        try (TestClient ada = room.connect()) {
            join(ada, "ada", "");
            carried = room.server.remove("pond", Optional.of(NEXT));
        }
        CarriedSession known = carried.getFirst();
        second.add(
                room.port,
                List.of(new CarriedSession(known.client(), known.body(), "{\"version\":2}")));
        room.step();
        assertThat(room.has("ada")).isFalse();
    }

    /** Returns the sessions of this room if its server were lost now. */
    private List<CarriedSession> noted() {
        Map<String, CarriedSession> begun = new TreeMap<>();
        Map<String, List<FinishedCommand>> finished = new HashMap<>();
        for (SessionNote note : room.notes) {
            switch (note) {
                case SessionNote.Began began -> {
                    begun.put(note.client(), began.session());
                    finished.put(note.client(), new ArrayList<>());
                }
                case SessionNote.Finished done -> finished.get(note.client()).add(done.command());
                case SessionNote.Ended _ -> begun.remove(note.client());
            }
        }
        return begun.values().stream()
                .map(
                        session ->
                                new CarriedSession(
                                        session.client(),
                                        session.body(),
                                        session.state(),
                                        Optional.of(
                                                new CarriedSession.Since(
                                                        finished.get(session.client()), -1))))
                .toList();
    }

    /**
     * The room's server is lost: it says nothing any more, and its world runs on another server.
     */
    private void lose() {
        room.server.close();
    }

    @Test
    void aSessionOfALostServerContinuesFromItsNotes() throws IOException {
        String session;
        long seen;
        List<CarriedSession> noted;
        try (TestClient ada = room.connect()) {
            session = join(ada, "ada", "");
            seen = room.loop.frame();
            ada.say(PUSH.formatted(1)).sync();
            room.step();
            ada.skipTo("result");
            ada.say(PUSH.formatted(2).replace("duck", "goose")).sync();
            room.step();
            assertThat(ada.skipTo("result").get("accepted").booleanValue()).isFalse();
            noted = noted();
        }
        assertThat(noted).singleElement().extracting(CarriedSession::client).isEqualTo("ada");
        assertThat(noted.getFirst().state()).doesNotContain(session);
        lose();
        second.add(room.port, noted);
        room.step();
        try (TestClient ada = resume("ada", session, seen)) {
            JsonNode welcome = ada.expect("welcome");
            assertThat(welcome.get("resumed").booleanValue()).isTrue();
            assertThat(welcome.get("body").stringValue()).isEqualTo("ada");
            assertThat(ada.expect("event").get("type").stringValue())
                    .as("the events of the lost server are lost, and the client learns it")
                    .isEqualTo("missed");
            ada.say(PUSH.formatted(1));
            assertThat(ada.skipTo("result").get("accepted").booleanValue()).isTrue();
            ada.say(PUSH.formatted(2));
            JsonNode refused = ada.skipTo("result");
            assertThat(refused.get("accepted").booleanValue())
                    .as("the result that the command had, whatever it asks for now")
                    .isFalse();
            room.step();
            assertThat(speed()).as("no act is executed twice").isEqualTo(1);
            ada.say(PUSH.formatted(3)).sync();
            room.step();
            assertThat(ada.skipTo("result").get("accepted").booleanValue()).isTrue();
            assertThat(speed()).isEqualTo(2);
        }
    }

    /** An act whose frame was not stored is executed when the client sends it again. */
    @Test
    void anActThatIsNotNotedIsExecuted() throws IOException {
        String session;
        List<CarriedSession> noted;
        try (TestClient ada = room.connect()) {
            session = join(ada, "ada", "");
            noted = noted();
            ada.say(PUSH.formatted(1)).sync();
            room.step();
            ada.skipTo("result");
        }
        lose();
        room.item("duck").physics().set("velocity", 0, 0, 0); // the frame of the act is lost
        second.add(room.port, noted);
        try (TestClient ada = resume("ada", session, room.loop.frame() + 1)) {
            assertThat(ada.expect("welcome").get("resumed").booleanValue()).isTrue();
            ada.say(PUSH.formatted(1)).sync();
            room.step();
            ada.expect("result");
            assertThat(ada.expect("event").get("type").stringValue())
                    .as("no event of a frame that the client believes to have seen is missing")
                    .isEqualTo("acted");
            assertThat(speed()).isEqualTo(1);
        }
    }

    @Test
    void sessionsThatCannotBeResumedAreNotNoted() throws IOException {
        try (TestClient _ = room.join("ada")) {
            assertThat(room.notes).noneMatch(SessionNote.Began.class::isInstance);
        }
        room.notes.clear();
        try (TestClient eye = room.connect()) {
            join(eye, "eye", ",'role':'observer'");
            assertThat(noted()).singleElement().extracting(CarriedSession::client).isEqualTo("eye");
            eye.say("{'t':'bye'}");
            eye.skipToBye("goodbye");
        }
        assertThat(noted()).isEmpty();
    }
}
