// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.AgentRoom;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.TestClient;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.net.Outbox;
import reve.core.agent.net.WriteBuffers;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.IntStream;

/** The cost for the server of a session that is resumed again and again. */
class ResumesTest {

    private static final long SECOND = 1_000_000_000;
    private static final byte[] BYE = {'b'};

    private String token = "";

    @Test
    void aSessionIsResumedSomeTimesAtOnceAndThenFourTimesASecond() {
        var resumes = new Resumes(3, 0);
        for (int i = 0; i < 3; i++) {
            assertThat(resumes.take(0)).isTrue();
        }
        long wait = SECOND / 4;
        assertThat(resumes.take(wait - 1000)).isFalse();
        for (long time = 1; time < 10; time++) {
            assertThat(resumes.take(time * wait)).isTrue();
            assertThat(resumes.take(time * wait + 1000)).isFalse();
        }
        long later = 100 * SECOND;
        assertThat(IntStream.range(0, 10).filter(i -> resumes.take(later)).count()).isEqualTo(3);
    }

    @Test
    void whoResumesTooOftenIsRefusedAndKeepsItsSession() throws IOException {
        try (var room = new AgentRoom();
                TestClient ada = room.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':60}").sync();
            room.step();
            token = ada.expect("welcome").at("/session/token").stringValue();
            String resume =
                    "{'t':'hello','protocol':1,'name':'ada','resume':{'session':'"
                            + token
                            + "','frame':0}}";
            var clients = new ArrayList<TestClient>(List.of(ada));
            long begun = System.nanoTime();
            int resumed = 0;
            JsonNode answer = null;
            while (answer == null || answer.get("t").stringValue().equals("welcome")) {
                TestClient next = room.connect().say(resume);
                clients.add(next);
                answer = next.next();
                resumed++;
            }
            long atOnce = AgentLimits.PROTOCOL.resumes();
            long most = atOnce + 4 * (System.nanoTime() - begun) / SECOND + 1;
            assertThat(resumed - 1L).as("resumes").isBetween(atOnce, most);
            assertThat(answer.get("code").stringValue()).isEqualTo("resumed-too-often");
            assertThat(answer.get("hint").stringValue()).isEqualTo("try again in 0.25 s");
            clients.get(resumed - 1).say("{'t':'ping','id':9}").skipTo("pong");
            assertThat(room.has("ada")).isTrue();
            for (TestClient client : clients) {
                client.close();
            }
        }
    }

    @Test
    void whatHappenedMeanwhileIsNeitherEncodedNorCopiedForAResume() {
        var log = new EventLog(SECOND, EventLog.MAX_BYTES);
        var shared = new ArrayList<byte[]>();
        for (int frame = 1; frame <= 100; frame++) {
            var told =
                    HeardEvent.Told.of(
                            new ServerMessage.Event(frame, "rang", Map.of()), Encoding.JSON);
            shared.add(told.bytes());
            log.add(told, 0);
        }
        for (int resume = 0; resume < 3; resume++) {
            var outbox = new Outbox(2, 100, () -> {});
            outbox.begin(new byte[10], log.after(0, Encoding.JSON), Encoding.JSON);
            assertThat(outbox.bytes()).as("memory of its own").isEqualTo(100 * 8);
            assertThat(bytes(outbox)).hasSize(10);
            for (byte[] bytes : shared) {
                assertThat(bytes(outbox)).isSameAs(bytes);
            }
            assertThat(outbox.isEmpty()).isTrue();
            assertThat(outbox.bytes()).isZero();
        }
    }

    @Test
    void aResumeInAnotherEncodingGetsTheSameEvents() {
        var told = HeardEvent.Told.of(new ServerMessage.Event(7, "rang", Map.of()), Encoding.JSON);
        var outbox = new Outbox(2, 100, () -> {});
        outbox.begin(new byte[10], List.of(told), Encoding.MESSAGEPACK);
        bytes(outbox);
        assertThat(bytes(outbox)).isEqualTo(told.message().in(Encoding.MESSAGEPACK));
    }

    @Test
    void whatWaitedForTheOlderConnectionIsDiscarded() {
        var outbox = new Outbox(10, 1000, () -> {});
        outbox.begin(
                new byte[10],
                List.of(
                        HeardEvent.Told.of(
                                new ServerMessage.Event(7, "rang", Map.of()), Encoding.JSON)),
                Encoding.JSON);
        outbox.offer(new byte[100]);
        outbox.offer(new byte[100], 8);
        outbox.miss(9);
        assertThat(outbox.bytes()).isBetween(100, 300);
        outbox.abandon(BYE);
        assertThat(outbox.bytes()).isEqualTo(BYE.length);
        assertThat(bytes(outbox)).isEqualTo(BYE);
        assertThat(outbox.isDone()).isTrue();
        outbox.offer(new byte[1]);
        assertThat(outbox.isDone()).isTrue();
    }

    /** Returns an agent that reads nothing and for which more than one write waits. */
    private TestClient stuck(AgentRoom room) throws IOException {
        var ada = new TestClient(room.server.address(), 4096);
        ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':60}").sync();
        room.step();
        token = ada.expect("welcome").at("/session/token").stringValue();
        String ping = "{'t':'ping','id':9007199254740991}\n".repeat(20).strip();
        long unsent = WriteBuffers.BUFFER_BYTES + 100;
        while (room.connections().slowReaders().bytes() <= unsent) {
            ada.say(ping);
            assertThat(room.server.stats().cut()).as("clients cut").isZero();
        }
        return ada;
    }

    private static AgentRoom talkative() throws IOException {
        AgentLimits l = AgentRoom.CONFIG.limits();
        var limits =
                new AgentLimits(
                        l.maxConnections(),
                        l.helloBytes(),
                        l.lineBytes(),
                        10_000_000,
                        l.actsInFlight(),
                        100_000,
                        10_000_000,
                        l.maxErrors(),
                        l.kept(),
                        l.resumes(),
                        l.hellos());
        return new AgentRoom(
                new AgentServerConfig(
                        AgentRoom.CONFIG.address(),
                        limits,
                        AgentRoom.CONFIG.timeouts(),
                        Optional.empty(),
                        AgentSecurity.NONE));
    }

    @Test
    void whatWaitsInTheQueueOfASlowReaderCountsUntilItsSessionIsResumed() throws IOException {
        try (AgentRoom room = talkative();
                TestClient ada = stuck(room);
                TestClient again = room.connect()) {
            assertThat(ada.hasNews()).as("something to read").isTrue();
            again.say(
                            "{'t':'hello','protocol':1,'name':'ada','resume':{'session':'"
                                    + token
                                    + "','frame':0}}")
                    .expect("welcome");
            assertThat(room.connections().slowReaders().bytes()).isZero();
            assertThat(room.server.stats().open()).as("connections").isEqualTo(1);
        }
    }

    private static byte[] bytes(Outbox outbox) {
        return ((Outbox.Message) outbox.poll()).bytes();
    }
}
