// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.EnumSource;
import org.junit.jupiter.params.provider.MethodSource;

import reve.core.Seed;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.Vectors;
import reve.core.frame.FramePhase;
import reve.core.world.ItemDefinition;
import reve.core.world.WorldEvent;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Collections;
import java.util.HexFormat;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.function.Function;

/** A faulty client is disconnected with a reason. It affects no other client. */
class AgentLimitsTest {

    private static final Duration NEVER = Duration.ofMinutes(5);
    private static final String HELLO = "{'t':'hello','protocol':1,'name':'%s'}";

    @Test
    void whoSaysNoHelloInTimeIsCut() throws Exception {
        ShortLimit.run(
                soon -> {
                    try (AgentRoom room =
                                    new AgentRoom(AgentRoom.config(soon, NEVER, NEVER, NEVER));
                            TestClient silent = room.connect();
                            TestClient chatty = room.connect()) {
                        chatty.say("{'t':'ping'}").expect("error", "hello-expected");
                        chatty.expectBye("hello-late");
                        silent.expectBye("hello-late");
                        assertThat(room.server.stats().cut()).isEqualTo(2);
                    }
                });
    }

    @Test
    void aHelloHasToFitIntoItsLimit() throws IOException {
        try (AgentRoom room = new AgentRoom();
                TestClient client = room.connect()) {
            client.send("x".repeat(8192).getBytes(StandardCharsets.US_ASCII))
                    .send(new byte[] {'x'});
            client.expectBye("hello-too-long");
        }
    }

    @Test
    void aLineOfTheLongestLengthPassesAndOneByteMoreIsCut() throws IOException {
        AgentServerConfig config = AgentRoom.config(NEVER, NEVER, NEVER, NEVER);
        try (AgentRoom room = new AgentRoom(config);
                TestClient ada = room.join("ada")) {
            String ping = "{\"t\":\"ping\"}";
            String padded = ping + " ".repeat(config.limits().lineBytes() - ping.length() - 1);
            ada.say(padded).expect("pong");
            ada.say(padded + "  ").expectBye("line-too-long");
        }
    }

    @Test
    void aLineThatIsNeverFinishedIsCut() throws Exception {
        ShortLimit.run(
                soon -> {
                    try (AgentRoom room =
                                    new AgentRoom(AgentRoom.config(NEVER, soon, NEVER, NEVER));
                            TestClient ada = room.join("ada")) {
                        ada.send("{\"t\":".getBytes(StandardCharsets.US_ASCII))
                                .expectBye("line-late");
                        room.stepUntil("its body is gone", () -> !room.has("ada"));
                    }
                });
    }

    @Test
    void whoIsSilentIsPingedAndWhoDoesNotAnswerIsCut() throws Exception {
        ShortLimit.run(
                soon -> {
                    try (AgentRoom room =
                                    new AgentRoom(AgentRoom.config(NEVER, NEVER, soon, NEVER));
                            TestClient ada = room.join("ada")) {
                        for (int i = 0; i < 3; i++) {
                            ada.expect("ping");
                            ada.say("{'t':'pong'}");
                        }
                        ada.sync();
                        ada.expect("ping");
                        ada.expectBye("idle");
                    }
                });
    }

    /** A world with long texts in many items costs only the clients that ask for all of them. */
    @Test
    void aPerceptionOfTooManyBytesEndsTheConnection() throws IOException {
        List<String> texts = Collections.nCopies(60, "z".repeat(1000));
        try (AgentRoom room = new AgentRoom(AgentRoom.config(NEVER, NEVER, NEVER, NEVER));
                TestClient greedy = room.join("greedy");
                TestClient ada = room.join("ada")) {
            for (int i = 0; i < 1200; i++) {
                room.world.add(ItemDefinition.named("item " + i).symbol("a", texts).build());
            }
            room.step();
            greedy.say("{'t':'perceive','id':1}").sync();
            room.step();
            greedy.skipToBye("too-large");
            ada.sync();
        }
    }

    @Test
    void whoLetsMessagesPileUpIsCutAndTheOthersNoticeNothing() throws IOException {
        try (AgentRoom room = new AgentRoom(AgentRoom.config(NEVER, NEVER, NEVER, NEVER));
                TestClient greedy = new TestClient(room.server.address(), 4096);
                TestClient ada = room.connect()) {
            greedy.say(HELLO.formatted("greedy")).sync();
            room.step();
            ada.say(HELLO.formatted("ada")).sync();
            room.step();
            ada.expect("welcome");
            ada.expect("event");
            floodUntilCut(room, greedy);
            room.stepUntil("its body is gone", () -> !room.has("greedy"));
            assertThat(room.server.stats().cut()).isEqualTo(1);
            ada.say("{'t':'perceive','id':1}").sync();
            room.step();
            JsonNode message = ada.next();
            assertThat(message.at("/fields/reason").asString("")).isEqualTo("too-slow");
            assertThat(ada.expect("perception").get("id").longValue()).isEqualTo(1);
        }
    }

    /** Sends requests and reads no answer, until the server disconnects the client. */
    private static void floodUntilCut(AgentRoom room, TestClient greedy) {
        byte[] pings =
                "{\"t\":\"ping\",\"id\":1}\n".repeat(1000).getBytes(StandardCharsets.US_ASCII);
        try {
            long enough = 200_000_000;
            for (long sent = 0; room.server.stats().cut() == 0; sent += pings.length) {
                assertThat(sent).as("bytes sent without being cut").isLessThan(enough);
                greedy.send(pings);
            }
        } catch (IOException e) {
            assertThat(room.server.stats().cut()).as("%s", e).isEqualTo(1);
        }
    }

    @Test
    void whoNeverReadsItsPerceptionsIsCutByTheWriteDeadline() throws Exception {
        ShortLimit.run(
                soon -> {
                    try (AgentRoom room =
                            new AgentRoom(AgentRoom.config(NEVER, NEVER, NEVER, soon))) {
                        for (int i = 0; i < 3000; i++) {
                            room.world.add(
                                    ItemDefinition.named("stone " + i)
                                            .symbol("note", "x".repeat(200))
                                            .build());
                        }
                        try (TestClient blind = new TestClient(room.server.address(), 4096)) {
                            blind.say(HELLO.formatted("blind"))
                                    .say("{'t':'perceive','every':1}")
                                    .sync();
                            room.stepUntil("it has been cut", () -> room.server.stats().cut() == 1);
                            room.stepUntil("its body is gone", () -> !room.has("blind"));
                            room.stepUntil(
                                    "its connection is gone",
                                    () -> room.server.stats().open() == 0);
                        }
                    }
                });
    }

    static List<JsonNode> refusedLines() {
        return Vectors.lines("refused.jsonl");
    }

    @ParameterizedTest
    @MethodSource("refusedLines")
    void aRefusedLineCostsOneErrorAndNothingElse(JsonNode vector) throws IOException {
        byte[] line =
                vector.has("bytes")
                        ? HexFormat.of().parseHex(vector.get("bytes").stringValue())
                        : vector.get("line").stringValue().getBytes(StandardCharsets.UTF_8);
        try (AgentRoom room = new AgentRoom();
                TestClient ada = room.join("ada")) {
            ada.send(line).send(new byte[] {'\n'});
            ada.expect("error", vector.get("code").stringValue());
            ada.say("{'t':'act','id':1,'item':'duck','action':'wind-up'}").sync();
            room.step();
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
        }
    }

    @Test
    void aRefusedLineNamesNoMethodOfALibrary() throws IOException {
        try (AgentRoom room = new AgentRoom();
                TestClient ada = room.join("ada")) {
            ada.say("{'" + "n".repeat(50_001) + "':1}");
            assertThat(ada.expect("error", "bad-json").get("message").stringValue())
                    .contains("50000")
                    .doesNotContain("Constraints", "get");
        }
    }

    @Test
    void eightRefusedLinesEndTheConnection() throws IOException {
        try (AgentRoom room = new AgentRoom();
                TestClient ada = room.join("ada")) {
            for (int i = 0; i < 8; i++) {
                ada.say("GET / HTTP/1.1");
                ada.expect("error", "bad-json");
            }
            ada.expectBye("too-many-errors");
        }
    }

    @Test
    void aPageInABrowserCannotSpeakToTheServer() throws IOException {
        try (AgentRoom room = new AgentRoom();
                TestClient browser = room.connect()) {
            browser.say("POST / HTTP/1.1\r")
                    .say("Host: 127.0.0.1\r")
                    .say("\r")
                    .say("{'t':'hello','protocol':1,'name':'page','role':'control'}")
                    .say("{'t':'shut-down','id':1}");
            browser.expectBye("no-http");
        }
    }

    private enum Garbage {
        NOISE(
                random -> {
                    byte[] bytes = new byte[random.nextInt(1, 3000)];
                    random.nextBytes(bytes);
                    return bytes;
                }),
        MUTANTS(
                random -> {
                    byte[] bytes =
                            ("{\"t\":\"hello\",\"protocol\":1,\"name\":\"eve\"}\n"
                                            + "{\"t\":\"act\",\"id\":1,\"item\":\"duck\",\"action\":\"push\",\"arguments\":{\"impulse\":[1,2,3]}}\n")
                                    .repeat(3)
                                    .getBytes(StandardCharsets.UTF_8);
                    for (int i = random.nextInt(1, 20); i > 0; i--) {
                        bytes[random.nextInt(bytes.length)] = (byte) random.nextInt(256);
                    }
                    return bytes;
                }),
        NESTING(
                random ->
                        ("{\"x\":".repeat(random.nextInt(1, 2000)) + "\n")
                                .getBytes(StandardCharsets.UTF_8)),
        NUMBERS(
                random ->
                        ("{\"t\":\"ping\",\"id\":"
                                        + random.nextInt(10)
                                        + "e"
                                        + random.nextInt(-99999, 99999)
                                        + "}\n")
                                .getBytes(StandardCharsets.UTF_8)),
        NEWLINES(random -> "\n".repeat(random.nextInt(1, 4000)).getBytes(StandardCharsets.UTF_8));

        private final Function<Random, byte[]> bytes;

        Garbage(Function<Random, byte[]> bytes) {
            this.bytes = bytes;
        }
    }

    @ParameterizedTest
    @EnumSource
    void garbageOfEveryKindIsAnsweredOrCutAndTheNextClientIsServed(Garbage kind)
            throws IOException {
        long seed = Seed.of("garbage " + kind);
        Random random = new Random(seed);
        try (AgentRoom room = new AgentRoom()) {
            for (int i = 0; i < 100; i++) {
                try (TestClient client = room.connect()) {
                    client.send(kind.bytes.apply(random));
                    client.socket.shutdownOutput();
                    room.step();
                    drain(client, room);
                } catch (IOException e) {
                    // The connection was reset, because the server closed it before the client had
                    // sent everything.
                }
            }
            room.stepUntil(
                    "all are gone", () -> room.server.stats().open() == 0 && !room.has("eve"));
            room.join("ada").close();
        }
    }

    /** Each line of the answer is a message of the protocol, up to the end. */
    private static void drain(TestClient client, AgentRoom room) throws IOException {
        JsonNode message = client.next();
        while (!message.get("t").stringValue().equals("bye")) {
            assertThat(message.get("t").stringValue())
                    .isIn("error", "welcome", "event", "result", "pong");
            room.step();
            message = client.next();
        }
    }

    @Test
    void twoHundredAgentsPerceiveActAndLeaveTogether() throws IOException {
        int count = 200;
        try (AgentRoom room = new AgentRoom()) {
            List<TestClient> agents = new ArrayList<>();
            for (int i = 0; i < count; i++) {
                agents.add(room.connect().say(HELLO.formatted("agent" + i)).sync());
            }
            room.step();
            for (TestClient agent : agents) {
                agent.expect("welcome");
                for (int i = 0; i < count; i++) {
                    agent.expect("event");
                }
                agent.say("{'t':'perceive','id':1}")
                        .say(
                                "{'t':'act','id':2,'item':'duck','action':'push',"
                                        + "'arguments':{'impulse':[2,0,0]}}")
                        .sync();
            }
            room.step();
            for (TestClient agent : agents) {
                assertThat(agent.expect("result").get("frame").longValue()).isEqualTo(2);
                agent.skipTo("perception");
                agent.say("{'t':'bye'}");
            }
            assertThat(room.item("duck").physics().vector("velocity")).containsExactly(count, 0, 0);
            for (TestClient agent : agents) {
                agent.skipToBye("goodbye");
                agent.socket.close();
            }
            room.step();
            assertThat(room.world.table("body").rowCount()).isEqualTo(1);
            assertThat(room.server.stats().perceptions()).isEqualTo(count);
            assertThat(room.server.stats().agents()).isZero();
        }
    }

    @Test
    void whoReadsIsNotCutHoweverMuchHappensInOneFrame() throws IOException {
        int count = 20 * AgentRoom.CONFIG.limits().outboxMessages();
        try (AgentRoom room = new AgentRoom();
                TestClient ada = room.join("ada")) {
            var rings =
                    room.bus.subscribe(
                            FramePhase.ACT,
                            "rings",
                            event -> {
                                for (int i = 0; i < count; i++) {
                                    room.world.raise(
                                            new WorldEvent(
                                                    event.frame(), "rang", Map.of("number", i)));
                                }
                            });
            room.step();
            rings.close();
            room.step();
            for (int i = 0; i < count; i++) {
                assertThat(ada.expect("event").at("/fields/number").intValue()).isEqualTo(i);
            }
            ada.sync();
        }
    }

    @Test
    void moreConnectionsThanAllowedAreTurnedAwayWithAReason() throws IOException {
        AgentServerConfig config = with(AgentRoom.CONFIG, 2);
        try (AgentRoom room = new AgentRoom(config);
                TestClient ada = room.join("ada");
                TestClient second = room.connect()) {
            second.say("{'t':'ping'}").expect("error");
            try (TestClient third = room.connect()) {
                third.expectBye("too-many-connections");
            }
            ada.say("{'t':'bye'}").expectBye("goodbye");
            ada.socket.close();
            room.stepUntil("there is room", () -> room.server.stats().open() == 1);
            room.join("bob").close();
        }
    }

    @Test
    void anAddressThatOnlyConnectsLeavesRoomForOthers() throws IOException {
        var silent = new ArrayList<TestClient>();
        Duration later = Duration.ofMinutes(5);
        AgentServerConfig config = with(AgentRoom.config(later, later, later, later), 8);
        try (AgentRoom room = new AgentRoom(config);
                var socket = new Socket()) {
            for (int i = 0; i < 6; i++) {
                silent.add(room.connect().say("{'t':'ping'}"));
                silent.getLast().expect("error", "hello-expected");
            }
            try (TestClient seventh = room.connect()) {
                seventh.expectBye("too-many-connections");
            }
            socket.bind(new InetSocketAddress("127.0.0.2", 0));
            socket.connect(room.server.address());
            new TestClient(socket)
                    .say("{'t':'hello','protocol':1,'name':'bob','role':'observer'}")
                    .expect("welcome");
            silent.getFirst()
                    .say("{'t':'hello','protocol':1,'name':'ada','role':'observer'}")
                    .expect("welcome");
            room.join("eve").close();
        } finally {
            for (TestClient client : silent) {
                client.close();
            }
        }
    }

    @Test
    void clientsThatJoinInQuickSuccessionWaitForTheirTurn() throws IOException {
        List<TestClient> clients = new ArrayList<>();
        try (AgentRoom room = new AgentRoom(withBurst(4))) {
            long start = System.nanoTime();
            for (int i = 0; i < 20; i++) {
                clients.add(room.connect().say(HELLO.formatted("agent" + i)));
            }
            room.stepUntil("all are welcome", () -> clients.stream().allMatch(TestClient::hasNews));
            long waited = System.nanoTime() - start;
            for (TestClient client : clients) {
                client.expect("welcome");
            }
            // After the first burst, 16 clients remain. The server lets 100 of them join per
            // second.
            assertThat(Duration.ofNanos(waited)).isGreaterThan(Duration.ofMillis(150));
        } finally {
            for (TestClient client : clients) {
                client.close();
            }
        }
    }

    @Test
    void clientsThatLeaveWhileTheyWaitDoNotJoinAndDelayNobody() throws IOException {
        try (AgentRoom room = new AgentRoom(withBurst(1));
                TestClient ada = room.join("ada")) {
            Duration waited = Duration.ofDays(1);
            for (int i = 0; i < 5 && waited.toSeconds() >= 8; i++) { // a machine may be busy
                long start = System.nanoTime();
                leaveWhileWaiting(room, 1000);
                try (TestClient bob = room.connect().say(HELLO.formatted("bob" + i))) {
                    room.stepUntil("bob is welcome", bob::hasNews);
                    bob.expect("welcome");
                    waited = Duration.ofNanos(System.nanoTime() - start);
                }
            }
            assertThat(waited).as("1000 that join take 10 s").isLessThan(Duration.ofSeconds(8));
            ada.say("{'t':'ping'}").skipTo("pong");
        }
    }

    private static void leaveWhileWaiting(AgentRoom room, int clients) throws IOException {
        for (int i = 0; i < clients; i++) {
            try (TestClient gone = room.connect()) {
                gone.say(HELLO.formatted("gone" + i));
            }
        }
    }

    private static AgentServerConfig withBurst(int hellos) {
        AgentLimits l = AgentRoom.CONFIG.limits();
        return new AgentServerConfig(
                AgentRoom.CONFIG.address(),
                new AgentLimits(
                        l.maxConnections(),
                        l.helloBytes(),
                        l.lineBytes(),
                        l.messagesPerSecond(),
                        l.actsInFlight(),
                        l.outboxMessages(),
                        l.outboxBytes(),
                        l.maxErrors(),
                        l.kept(),
                        l.resumes(),
                        hellos),
                AgentRoom.CONFIG.timeouts(),
                AgentRoom.CONFIG.audit(),
                AgentRoom.CONFIG.security());
    }

    @Test
    void whoComesAndBreaksOffAgainAndAgainTakesNoMoreThanItsShare() throws IOException {
        try (AgentRoom room = new AgentRoom(with(AgentRoom.CONFIG, 5))) {
            for (int i = 0; i < 5; i++) {
                try (TestClient client = room.connect()) {
                    client.say(
                            "{'t':'hello','protocol':1,'name':'agent" + i + "','graceSeconds':60}");
                    room.stepUntil("it is welcome", client::hasNews);
                    client.expect("welcome");
                }
            }
            room.stepUntil("all have broken off", () -> room.server.stats().open() == 0);
            try (TestClient late = room.connect().say(HELLO.formatted("late"))) {
                late.expectBye("too-many-connections");
            }
        }
    }

    private static AgentServerConfig with(AgentServerConfig c, int maxConnections) {
        AgentLimits l = c.limits();
        var limits =
                new AgentLimits(
                        maxConnections,
                        l.helloBytes(),
                        l.lineBytes(),
                        l.messagesPerSecond(),
                        l.actsInFlight(),
                        l.outboxMessages(),
                        l.outboxBytes(),
                        l.maxErrors(),
                        l.kept(),
                        l.resumes(),
                        l.hellos());
        return new AgentServerConfig(c.address(), limits, c.timeouts(), c.audit(), c.security());
    }
}
