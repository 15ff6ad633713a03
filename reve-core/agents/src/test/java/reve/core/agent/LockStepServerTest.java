// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.agent.publish.Publisher;
import reve.core.frame.FramePhase;
import reve.core.world.World;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.locks.LockSupport;

/** Agents in lock-step, over the wire. The world runs as fast as possible. */
class LockStepServerTest {

    private static final String HELLO =
            "{'t':'hello','protocol':1,'name':'%s','time':{'mode':'lock-step'%s}}";
    private static final String WIND_UP =
            "{'t':'act','id':%d,'item':'duck','action':'wind-up','ready':true}";
    private static final int FRAMES = 1000;

    private AgentRoom room;
    private Thread loop;

    @BeforeEach
    void open() throws IOException {
        room = new AgentRoom();
    }

    @AfterEach
    void close() throws InterruptedException {
        room.server.close();
        if (loop != null) {
            room.loop.stop();
            loop.join();
        }
    }

    /** Returns an agent that joined before the world runs, and that has its first perception. */
    private TestClient join(String name, String time) throws IOException {
        TestClient client = room.connect().say(HELLO.formatted(name, time)).sync();
        room.step();
        client.expect("welcome");
        assertThat(client.expect("event").at("/fields/agent").stringValue()).isEqualTo(name);
        JsonNode perception = client.expect("perception");
        assertThat(perception.get("frame").longValue()).isEqualTo(room.loop.frame());
        assertThat(perception.has("items")).isTrue();
        return client;
    }

    private void run() {
        loop = new Thread(room.loop::run, "world");
        loop.start();
    }

    @Test
    void theWelcomeSaysTheRhythmAndTheDeadlineThatTheServerGrants() throws IOException {
        try (TestClient ada =
                room.connect().say(HELLO.formatted("ada", ",'every':3,'deadline':1000")).sync()) {
            room.step();
            assertThat(ada.expect("welcome").get("time"))
                    .isEqualTo(TestClient.json("{'mode':'lock-step','every':3,'deadline':300.0}"));
        }
    }

    @Test
    void theLongestDeadlineIsASecondUnlessTheOperatorSaysOtherwise() throws IOException {
        room.close();
        room = new AgentRoom(AgentServerConfig.onPort(0));
        try (TestClient ada =
                room.connect().say(HELLO.formatted("ada", ",'deadline':600")).sync()) {
            room.step();
            assertThat(ada.expect("welcome").at("/time/deadline").doubleValue()).isEqualTo(1.0);
        }
    }

    @Test
    void whoIsSilentIsToldThatItIsNotWaitedForAndComesBackByReady() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':0.3,'fallback':{'action':'swim'}");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            run();
            for (TestClient client : List.of(ada, boss)) {
                for (int frame = 2; frame <= 4; frame++) {
                    assertThat(client.skipTo("event"))
                            .isEqualTo(
                                    TestClient.json(
                                            ("{'t':'event',"
                                                            + "'frame':%d,'type':'late','fields':{'agent':'ada','body':'ada',"
                                                            + "'count':%d}}")
                                                    .formatted(frame, frame - 1)));
                }
                assertThat(client.skipTo("event"))
                        .isEqualTo(
                                TestClient.json(
                                        "{'t':'event',"
                                                + "'frame':4,'type':'away','fields':{'agent':'ada','body':'ada'}}"));
            }
            while (room.loop.frame() < 1000) {
                Thread.onSpinWait(); // takes 300 s if each frame waits for ada
            }
            ada.say("{'t':'ready','frame':3}");
            JsonNode back = boss.expect("event");
            assertThat(back.get("type").stringValue()).isEqualTo("back");
            assertThat(back.get("fields"))
                    .isEqualTo(TestClient.json("{'agent':'ada','body':'ada'}"));
            long frame = back.get("frame").longValue();
            JsonNode told = ada.skipTo("perception");
            while (told.get("frame").longValue() < frame) {
                told = ada.skipTo("perception"); // of the rounds while the agent was away
            }
            assertThat(told.get("frame").longValue()).isEqualTo(frame);
            ada.say("{'t':'ready','frame':%d}".formatted(frame));
            assertThat(ada.skipTo("perception").get("frame").longValue()).isEqualTo(frame + 1);
        }
    }

    /** A room whose agents may delay others by 50 ms. */
    private void openImpatient() throws IOException {
        room.close();
        room = new AgentRoom(AgentRoom.CONFIG.withWaiting(Optional.of(Duration.ofMillis(50))));
    }

    private static JsonNode nextWaiting(TestClient client) throws IOException {
        JsonNode event = client.skipTo("event");
        while (!event.get("type").stringValue().equals("waiting")) {
            event = client.skipTo("event");
        }
        return event;
    }

    @Test
    void whoKeepsAnAgentInRealTimeWaitingIsToldThatTheWorldWaitsAFrameOnly() throws IOException {
        openImpatient();
        try (TestClient bob = room.join("bob");
                TestClient ada = join("ada", ",'deadline':600")) {
            bob.say("{'t':'perceive','every':100}").sync();
            run();
            JsonNode told = nextWaiting(ada);
            assertThat(told.get("frame").isIntegralNumber()).isTrue();
            assertThat(told.get("fields"))
                    .isEqualTo(
                            TestClient.json("{'longest':%s}".formatted(1_000_000_000L / 60 / 1e9)));
            for (long frame = 0; frame < 1000; ) {
                frame = bob.skipTo("perception").get("frame").longValue(); // else this takes hours
            }
            ada.say("{'t':'bye'}").skipToBye("goodbye");
            try (TestClient again = room.connect().say(HELLO.formatted("eve", ""))) {
                again.expect("welcome");
                assertThat(again.expect("event").get("type").stringValue())
                        .as("another name has the same allowance")
                        .isEqualTo("waiting");
            }
        }
    }

    @Test
    void whoHasLeftAndWhoOnlyObservesAreNotKeptWaiting() throws IOException {
        openImpatient();
        try (TestClient bob = room.join("bob");
                TestClient ada = join("ada", ",'deadline':0.2");
                TestClient eye = room.connect()) {
            eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}").expect("welcome");
            bob.say("{'t':'bye'}").skipToBye("goodbye");
            room.step();
            assertThat(ada.skipTo("event").get("type").stringValue()).isEqualTo("left");
            run();
            for (String type : List.of("late", "late", "late", "away")) {
                assertThat(ada.skipTo("event").get("type").stringValue()).isEqualTo(type);
            }
        }
    }

    @Test
    void anOperatorsCommandsAreDoneWhileTheWorldWaitsAndShowInTheNextFrame() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':600");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            run();
            for (int id = 1; id <= 100; id++) {
                boss.say(
                        ("{'t':'edit','id':%d,'item':'duck','property':'semantic.wound',"
                                        + "'value':%d}")
                                .formatted(id, id));
                assertThat(boss.expect("result"))
                        .isEqualTo(
                                TestClient.json(
                                        "{'t':'result','id':%d,'accepted':true,'frame':2}"
                                                .formatted(id)));
            }
            boss.say("{'t':'edit','id':101,'item':'swan','property':'physics.mass','value':1}");
            boss.expect("result", "no-such-item");
            assertThat(room.loop.frame()).as("the world waits").isEqualTo(1);
            ada.say("{'t':'ready'}");
            JsonNode seen = ada.expect("perception");
            assertThat(seen.get("frame").longValue()).isEqualTo(2);
            assertThat(seen.at("/changed/0/symbols/wound").doubleValue()).isEqualTo(100.0);
        }
    }

    @Test
    void aQueryAfterAChangeIsAnsweredFromTheFrameThatContainsTheChange() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':600");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            run();
            boss.say(
                    "{'t':'edit','id':1,'item':'duck','property':'semantic.wound','value':'deep'}");
            assertThat(boss.expect("result").get("frame").longValue()).isEqualTo(2);
            boss.say("{'t':'search','id':2,'text':'deep'}").sync();
            assertThat(room.loop.frame()).as("the world waits").isEqualTo(1);
            ada.say("{'t':'ready'}");
            JsonNode found = boss.skipTo("report");
            assertThat(found.get("frame").longValue()).isEqualTo(2);
            assertThat(found.at("/content/count").intValue()).isEqualTo(1);
        }
    }

    @Test
    void whatIsSaidToAPausedWorldWaitsForItsNextFrame() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':600");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            run();
            boss.say("{'t':'pause','id':1}").expect("result");
            boss.say("{'t':'edit','id':2,'item':'duck','property':'physics.mass','value':3}");
            boss.say("{'t':'run','id':3}");
            assertThat(boss.expect("result").get("id").longValue()).isEqualTo(3);
            JsonNode edited = boss.expect("result");
            assertThat(edited.get("id").longValue())
                    .as("done as the world waits for ada")
                    .isEqualTo(2);
            assertThat(edited.get("frame").longValue()).isEqualTo(2);
            assertThat(room.loop.frame()).isEqualTo(1);
            ada.say("{'t':'ready'}");
            assertThat(ada.expect("perception").get("frame").longValue()).isEqualTo(2);
        }
    }

    @Test
    void whoIsReadyGetsTheNextPerceptionWithoutAskingForIt() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':600")) {
            run();
            for (long frame = 2; frame < 100; frame++) {
                ada.say("{'t':'ready'}");
                JsonNode perception = ada.expect("perception");
                assertThat(perception.get("frame").longValue()).isEqualTo(frame);
                assertThat(perception.get("since").longValue()).isEqualTo(frame - 1);
            }
            assertThat(room.loop.frame()).as("it waits").isLessThanOrEqualTo(99);
        }
    }

    @Test
    void anActThatSaysReadyIsDoneInTheNextFrameAndItsResultComesFirst() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':600")) {
            run();
            for (int frame = 2; frame < 50; frame++) {
                ada.say(WIND_UP.formatted(frame));
                assertThat(ada.expect("result"))
                        .isEqualTo(
                                TestClient.json(
                                        "{'t':'result','id':%d,'accepted':true,'frame':%d}"
                                                .formatted(frame, frame)));
                assertThat(ada.expect("event").get("type").stringValue()).isEqualTo("acted");
                assertThat(ada.expect("perception").get("frame").longValue()).isEqualTo(frame);
            }
        }
    }

    @Test
    void roundsOfSeveralFramesPassWithoutWaiting() throws IOException {
        try (TestClient ada = join("ada", ",'every':3,'deadline':600")) {
            run();
            for (long frame = 4; frame < 100; frame += 3) {
                ada.say("{'t':'ready','frame':" + (frame - 3) + "}");
                assertThat(ada.expect("perception").get("frame").longValue()).isEqualTo(frame);
            }
        }
    }

    @Test
    void relationsAreToldToWhoWantsThem() throws IOException {
        try (TestClient ada =
                room.connect().say(HELLO.formatted("ada", ",'relations':true")).sync()) {
            room.step();
            assertThat(ada.skipTo("perception").at("/items/0/symbols/near").isArray()).isTrue();
        }
    }

    @Test
    void everybodyHearsWhoIsLateAndItsFallbackIsDoneInTheNextFrame() throws IOException {
        try (TestClient ada =
                        join(
                                "ada",
                                ",'deadline':0.02,'fallback':{'item':'duck','action':'push',"
                                        + "'arguments':{'impulse':[2,0,0]}}");
                TestClient eye = room.connect()) {
            eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}").expect("welcome");
            run();
            for (TestClient client : List.of(ada, eye)) {
                JsonNode late = client.expect("event");
                assertThat(late)
                        .isEqualTo(
                                TestClient.json(
                                        "{'t':'event','frame':2,'type':'late',"
                                                + "'fields':{'agent':'ada','body':'ada','count':1}}"));
                assertThat(client.expect("event"))
                        .isEqualTo(
                                TestClient.json(
                                        "{'t':'event','frame':2,'type':'acted',"
                                                + "'fields':{'agent':'ada','item':'duck','action':'push'}}"));
            }
            assertThat(ada.skipTo("event").at("/fields/count").longValue()).isEqualTo(2);
        }
    }

    @Test
    void ofManyThatAreLateInOneFrameEachHearsOfItselfAndOfAFewOthers() throws IOException {
        int many = 3 * Publisher.MAX_ABSENCES;
        var agents = new ArrayList<TestClient>();
        try (TestClient eye = room.connect()) {
            for (int i = 0; i < many; i++) {
                agents.add(
                        room.connect()
                                .say(HELLO.formatted("a" + (10 + i), ",'deadline':0.02"))
                                .sync());
            }
            room.step();
            eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}").expect("welcome");
            run();
            Map<String, Integer> seen = absences(eye, many);
            assertThat(seen.get(""))
                    .as("late and away, of which some are missed")
                    .isEqualTo(4 * many);
            assertThat(seen.get("told")).isLessThanOrEqualTo(3 * Publisher.MAX_ABSENCES);
            for (int i = 0; i < many; i++) {
                Map<String, Integer> heard = absences(agents.get(i), many);
                assertThat(heard.get("a" + (10 + i))).as("of itself").isEqualTo(4);
                assertThat(heard.get("")).isEqualTo(4 * many);
                assertThat(heard.get("told"))
                        .isLessThanOrEqualTo(3 * (Publisher.MAX_ABSENCES + 1) + 1);
            }
        } finally {
            for (TestClient agent : agents) {
                agent.close();
            }
        }
    }

    /**
     * Counts the events that a client receives about agents that are late three times and then
     * away. The keys are the names of the agents. The key "told" has the number of all these
     * events, and the key "" has the number of missed events.
     */
    private static Map<String, Integer> absences(TestClient client, int agents) throws IOException {
        var counts = new HashMap<String, Integer>(Map.of("", 0, "told", 0));
        while (counts.get("") < 4 * agents) {
            JsonNode event = client.skipTo("event");
            String type = event.get("type").stringValue();
            if (type.equals("missed")) {
                counts.merge("", event.at("/fields/events").intValue(), Integer::sum);
            } else if (!type.equals("joined")) {
                assertThat(type).isIn("late", "away");
                counts.merge("", 1, Integer::sum);
                counts.merge("told", 1, Integer::sum);
                counts.merge(event.at("/fields/agent").stringValue(), 1, Integer::sum);
            }
        }
        return counts;
    }

    @Test
    void aFallbackThatCannotBeDoneChangesNothingElse() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':0.02,'fallback':{'action':'swim'}")) {
            run();
            assertThat(ada.expect("event").get("type").stringValue()).isEqualTo("late");
            assertThat(ada.skipTo("event").at("/fields/count").longValue()).isEqualTo(2);
        }
    }

    @Test
    void whoLeavesOrBreaksOffIsNotWaitedFor() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':600");
                TestClient bob = join("bob", ",'deadline':600");
                TestClient cleo = join("cleo", ",'deadline':600")) {
            ada.expect("event"); // bob joined
            ada.expect("perception");
            ada.expect("event"); // cleo joined
            ada.expect("perception");
            ada.say("{'t':'ready','frame':3}").sync();
            run();
            bob.say("{'t':'bye'}");
            cleo.socket.setSoLinger(true, 0);
            cleo.socket.close();
            JsonNode perception = ada.skipTo("perception");
            assertThat(perception.get("frame").longValue()).isEqualTo(4);
        }
    }

    @Test
    void whoComesBackPerceivesTheNextFrameAndIsWaitedForAgain() throws IOException {
        TestClient ada =
                room.connect().say(HELLO.formatted("ada", "}, 'graceSeconds': 60, 'x': {")).sync();
        room.step();
        JsonNode welcome = ada.expect("welcome");
        try (TestClient again = room.connect()) {
            run();
            again.say(
                            "{'t':'hello','protocol':1,'name':'ada','resume':{'session':'"
                                    + welcome.at("/session/token").stringValue()
                                    + "','frame':1}}")
                    .expect("welcome");
            long frame = again.skipTo("perception").get("frame").longValue();
            assertThat(frame).isEqualTo(2);
            again.say("{'t':'ready','frame':2}");
            assertThat(again.expect("perception").get("frame").longValue()).isEqualTo(3);
            assertThat(room.loop.frame()).as("it waits").isLessThanOrEqualTo(3);
        }
        ada.close();
    }

    @Test
    void aWorldThatWaitsIsPausedSteppedAndEndedAtOnce() throws IOException, InterruptedException {
        try (TestClient ada = join("ada", ",'deadline':600");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            run();
            boss.say("{'t':'pause','id':1}");
            assertThat(boss.expect("result").get("frame").longValue()).isEqualTo(1);
            ada.say("{'t':'ready'}").sync();
            boss.say("{'t':'step','id':2}");
            assertThat(boss.expect("result").get("frame").longValue()).isEqualTo(2);
            assertThat(ada.expect("perception").get("frame").longValue()).isEqualTo(2);
            boss.say("{'t':'run','id':3}").expect("result");
            boss.say("{'t':'shut-down','id':4}").expect("result");
            loop.join();
            assertThat(room.loop.frame()).isEqualTo(2);
        }
    }

    @Test
    void aServerThatEndsHoldsNothing() throws IOException, InterruptedException {
        try (TestClient ada = join("ada", ",'deadline':600")) {
            run();
            room.server.close();
            ada.skipToBye("closing");
            while (room.loop.frame() < 100) {
                Thread.onSpinWait();
            }
        }
    }

    @Test
    void agentsComeOneAfterAnotherAndBeginTogether() throws IOException {
        try (TestClient ada = join("ada", ",'deadline':600");
                TestClient bob = room.connect();
                TestClient cleo = room.connect()) {
            run();
            bob.say(HELLO.formatted("bob", ",'deadline':600")).skipTo("perception");
            cleo.say(HELLO.formatted("cleo", ",'deadline':600")).skipTo("perception");
            for (TestClient client : List.of(ada, bob, cleo)) {
                client.say("{'t':'ready','frame':3}");
            }
            assertThat(cleo.expect("perception").get("frame").longValue()).isEqualTo(4);
            for (TestClient client : List.of(ada, bob)) {
                JsonNode message = client.next();
                for (; message.path("frame").asLong() < 4; message = client.next()) {
                    assertThat(message.path("type").asString("")).isNotEqualTo("late");
                }
                assertThat(message.get("t").stringValue()).isEqualTo("perception");
            }
        }
    }

    @Test
    void agentsInRealTimeAreNotWaitedForAndPerceiveTheSameFrames() throws IOException {
        try (TestClient bob = room.join("bob");
                TestClient ada = join("ada", ",'deadline':600")) {
            bob.say("{'t':'perceive','every':2}").sync();
            run();
            bob.expect("event"); // ada joined
            for (long frame = 3; frame < 20; frame++) {
                ada.say("{'t':'ready'}");
                assertThat(ada.expect("perception").get("frame").longValue()).isEqualTo(frame);
                if (frame % 2 == 1) {
                    assertThat(bob.expect("perception").get("frame").longValue()).isEqualTo(frame);
                }
            }
        }
    }

    @Test
    void whoIsNotInLockStepCannotBeReady() throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'ready'}").expect("error", "not-lock-step");
            ada.say(WIND_UP.formatted(1));
            assertThat(ada.expect("error", "not-lock-step").get("id").longValue()).isEqualTo(1);
        }
    }

    /**
     * The same acts make the same world in each frame. The time that each of the two agents thinks
     * has no effect.
     */
    @Test
    void theSameActsMakeTheSameWorldHoweverLongTheAgentsThink() throws Exception {
        long seed = Seed.of("delays");
        var random = new Random(seed);
        List<Long> first = hashes(random.nextLong());
        close();
        open();
        List<Long> second = hashes(random.nextLong());
        assertThat(first).hasSize(FRAMES);
        assertThat(second).as("seed %d", seed).isEqualTo(first);
    }

    /** The duck's velocity after the acts of two agents; its rounding reveals their order. */
    private List<Long> hashes(long seedOfDelays) throws Exception {
        List<Long> hashes = new CopyOnWriteArrayList<>();
        try (TestClient ada = room.connect();
                TestClient bob = room.connect()) {
            ada.say(HELLO.formatted("ada", ",'deadline':600")).sync();
            bob.say(HELLO.formatted("bob", ",'deadline':600")).sync();
            room.step();
            room.bus.subscribe(
                    FramePhase.DERIVE, "hashes", event -> hashes.add(hash(event.world())));
            run();
            Thread other = Thread.ofVirtual().start(() -> play(bob, 2, seedOfDelays));
            play(ada, 1, ~seedOfDelays);
            other.join();
        }
        // Later frames do not count, because the world continues after the agents have left.
        return hashes.stream().limit(FRAMES).toList();
    }

    private static void play(TestClient client, long seedOfActs, long seedOfDelays) {
        var acts = new Random(seedOfActs);
        var delays = new Random(seedOfDelays);
        try {
            client.skipTo("perception");
            for (int i = 0; i < FRAMES; i++) {
                if (delays.nextInt(4) == 0) {
                    LockSupport.parkNanos(delays.nextInt(200_000));
                }
                client.say(
                        ("{'t':'act','id':%d,'item':'duck','action':'push','ready':true,"
                                        + "'arguments':{'impulse':[%s,%s,0]}}")
                                .formatted(i, acts.nextDouble(), acts.nextDouble()));
                client.skipTo("perception");
            }
        } catch (IOException e) {
            throw new AssertionError(e);
        }
    }

    private static long hash(World world) {
        long hash = 0;
        for (double speed : world.find("duck").orElseThrow().physics().vector("velocity")) {
            hash = 31 * hash + Double.doubleToLongBits(speed);
        }
        return hash;
    }
}
