// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.agent.AgentRoom;
import reve.core.agent.TestClient;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;
import reve.core.world.ItemDefinition;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.Random;
import java.util.TreeSet;

/** Roles, commands that are executed at most once, and connections that break and are replaced. */
class SessionsTest {

    /**
     * Number of acts of an agent whose connection breaks after every third act. A long run uses
     * thirty thousand.
     */
    private static final int CUT_COMMANDS = Integer.getInteger("reve.abuse.commands", 60);

    private static final String WIND_UP = "{'t':'act','id':%d,'item':'duck','action':'wind-up'}";

    private AgentRoom room;

    @BeforeEach
    void open() throws IOException {
        room =
                new AgentRoom(
                        AgentRoom.resumedOften(),
                        AgentRoom.making().withEvents(1_000_000, 1_000_000),
                        4096);
    }

    @AfterEach
    void close() {
        room.close();
    }

    // ---- roles ----

    @Test
    void anObserverHasNoBodyAndPerceivesEverything() throws IOException {
        try (TestClient eye = room.connect()) {
            eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}");
            JsonNode welcome = eye.expect("welcome");
            assertThat(welcome.get("role").stringValue()).isEqualTo("observer");
            assertThat(welcome.has("body")).isFalse();
            assertThat(room.has("eye")).isFalse();
            eye.say("{'t':'perceive','id':1}").sync();
            room.step();
            assertThat(eye.expect("perception").at("/items/0/name").stringValue())
                    .isEqualTo("duck");
        }
    }

    @Test
    void anObserverHearsWhatHappensFromItsWelcomeOn() throws IOException {
        try (TestClient eye = guest("eye", "observer");
                TestClient ada = room.join("ada")) {
            assertThat(eye.expect("event").get("type").stringValue()).isEqualTo("joined");
            ada.say("{'t':'bye'}").expectBye("goodbye");
            room.step();
            assertThat(eye.expect("event").get("type").stringValue()).isEqualTo("left");
        }
    }

    @Test
    void whoTakesANameThatIsFreeAgainHearsWhatHappens() throws IOException {
        try (TestClient first = guest("eye", "observer")) {
            first.say("{'t':'bye'}").expectBye("goodbye");
        }
        try (TestClient second = guest("eye", "observer");
                TestClient ada = room.join("ada")) {
            assertThat(second.expect("event").get("type").stringValue()).isEqualTo("joined");
            ada.say("{'t':'bye'}").expectBye("goodbye");
            room.step();
            assertThat(second.expect("event").get("type").stringValue()).isEqualTo("left");
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            quoteCharacter = '`',
            value = {
                "observer | {'t':'act','id':1,'item':'duck','action':'wind-up'} | agent",
                "observer | {'t':'pause','id':1} | control",
                "control | {'t':'act','id':1,'item':'duck','action':'wind-up'} | agent",
                "agent | {'t':'pause','id':1} | control",
                "agent | {'t':'run','id':1} | control",
                "agent | {'t':'step','id':1} | control",
                "agent | {'t':'load-law','id':1,'library':'x'} | control",
                "agent | {'t':'unload-law','id':1,'library':'x'} | control",
                "agent | {'t':'edit','id':1,'item':'duck','property':'physics.mass','value':3} |"
                        + " control",
                "agent | {'t':'picture','id':1} | control",
                "agent | {'t':'snapshot','id':1,'image':'x'} | control",
                "agent | {'t':'rewind','id':1} | control",
                "agent | {'t':'save','id':1,'file':'x'} | control",
                "agent | {'t':'fork','id':1,'frames':1} | control",
                "agent | {'t':'shut-down','id':1} | control",
            })
    void aRoleMaySayOnlyWhatIsItsOwn(String role, String message, String needed)
            throws IOException {
        try (TestClient client = role.equals("agent") ? room.join("ada") : guest("ada", role)) {
            client.say(message).sync();
            JsonNode error = client.expect("error", "not-permitted");
            assertThat(error.get("id").longValue()).isEqualTo(1);
            assertThat(error.get("hint").stringValue()).contains(needed);
            room.step();
            assertThat(room.item("duck").semantic().get("wound")).isEqualTo(Optional.empty());
            assertThat(room.item("duck").physics().scalar("mass")).isEqualTo(2);
        }
    }

    @Test
    void aNameIsTakenByAnyRole() throws IOException {
        try (TestClient eye = guest("eye", "observer");
                TestClient second = room.connect()) {
            second.say("{'t':'hello','protocol':1,'name':'eye'}").expectBye("name-taken");
            eye.say("{'t':'bye'}").expectBye("goodbye");
        }
        room.join("eye").close();
    }

    // ---- control ----

    @Test
    void anEditChangesOnePropertyInTheNextFrame() throws IOException {
        try (TestClient boss = guest("boss", "control")) {
            String edit = "{'t':'edit','id':%d,'item':'duck','property':'%s','value':%s}";
            boss.say(edit.formatted(1, "physics.velocity", "[0,3,0]"))
                    .say(edit.formatted(2, "physical.location", "[4,5,6]"))
                    .say(edit.formatted(3, "semantic.class", "'bird'"))
                    .say(edit.formatted(4, "physical.colour", "'#ff0000'"))
                    .sync();
            room.step();
            for (int i = 1; i <= 4; i++) {
                JsonNode result = boss.expect("result");
                assertThat(result.get("accepted").booleanValue()).as("%s", result).isTrue();
                assertThat(result.get("frame").longValue()).isEqualTo(1);
            }
            assertThat(room.item("duck").physics().vector("velocity")).containsExactly(0, 3, 0);
            assertThat(room.item("duck").physical().location()).containsExactly(4, 5, 6);
            assertThat(room.item("duck").semantic().get("class")).contains("bird");
            assertThat(room.item("duck").physical().colour()).hasToString("#ff0000ff");
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            quoteCharacter = '`',
            value = {
                "swan | physics.mass | 1 | no-such-item | swan",
                "duck | mass | 1 | no-such-property | physics.NAME",
                "duck | soul.mass | 1 | no-such-property | soul.mass",
                "duck | physical.smell | 1 | no-such-property | physical.smell",
                "duck | physics.smell | 1 | edit-refused | smell",
                "duck | physics.velocity | [1,2] | edit-refused | velocity",
                "duck | physics.mass | 'heavy' | edit-refused | "
                        + "item duck: physics.mass is \"heavy\", expected numbers",
                "duck | physical.location | [1,2] | edit-refused | "
                        + "item duck: location is 2 numbers, expected 3",
                "duck | physical.colour | 'red' | edit-refused | "
                        + "item duck: colour \"red\": expected #rrggbb",
                "duck | semantic.name | 'swan' | edit-refused | name",
                "duck | semantic.class | 1 | edit-refused | item duck: class is 1.0, expected a"
                        + " text such as \"toy\"",
                "duck | semantic.a: {b} | 'x' | edit-refused | \"a: {b}\" is no name of a symbol",
                "duck | physical.location | [1e308,0,0] | out-of-range | item duck: location is"
                        + " 1.0E308; an action or an edit sets 0 or a magnitude from 1.0E-100 to"
                        + " 1.0E100",
                "duck | physics.mass | 1e-160 | out-of-range | item duck: physics.mass is 1.0E-160;"
                        + " an",
                "duck | physics.mass | -1 | out-of-range | physics.mass is -1.0; expected 0 or more"
                        + " [kg]",
                "duck | physics.inertia | [1,1,3] | out-of-range | item duck: physics.inertia is"
                        + " [1.0, 1.0, 3.0]; no body has moments of 1.0, 1.0 and 3.0 kg*m^2; expected"
                        + " none",
            })
    void anEditThatDoesNotFitIsRefusedWithAReason(
            String item, String property, String value, String code, String reason)
            throws IOException {
        try (TestClient boss = guest("boss", "control")) {
            boss.say(
                            "{'t':'edit','id':1,'item':'"
                                    + item
                                    + "','property':'"
                                    + property
                                    + "','value':"
                                    + value
                                    + "}")
                    .sync();
            room.step();
            assertThat(boss.expect("result", code).get("reason").stringValue()).contains(reason);
        }
    }

    @Test
    void aServerWithoutLawsOrPicturesSaysSo() throws IOException {
        try (TestClient boss = guest("boss", "control")) {
            boss.say("{'t':'load-law','id':1,'library':'drag'}").expect("result", "unsupported");
            boss.say("{'t':'unload-law','id':2,'library':'drag'}").expect("result", "unsupported");
            boss.say("{'t':'picture','id':3}").expect("result", "unsupported");
        }
    }

    @Test
    void aPausedWorldMakesExactlyTheFramesItIsToldTo() throws Exception {
        room.loop.pause();
        Thread runner = Thread.ofPlatform().start(room.loop::run);
        try (TestClient boss = guest("boss", "control")) {
            long before =
                    boss.say("{'t':'pause','id':1}").expect("result").get("frame").longValue();
            long after =
                    boss.say("{'t':'step','id':2,'frames':3}")
                            .expect("result")
                            .get("frame")
                            .longValue();
            assertThat(after).isEqualTo(before + 3);
            while (room.loop.frame() < after) {
                Thread.onSpinWait();
            }
            boss.say("{'t':'edit','id':3,'item':'duck','property':'physics.mass','value':7}")
                    .sync();
            boss.say("{'t':'step','id':4}");
            long next = before + 4;
            String result = "{'t':'result','id':%d,'accepted':true,'frame':%d}";
            assertThat(List.of(boss.expect("result"), boss.expect("result")))
                    .containsExactlyInAnyOrder(
                            TestClient.json(result.formatted(3, next)),
                            TestClient.json(result.formatted(4, next)));
            boss.say("{'t':'perceive','id':5}").sync();
            boss.say("{'t':'run','id':6}").expect("result");
            assertThat(boss.expect("perception").get("frame").longValue()).isGreaterThan(next);
            boss.say("{'t':'shut-down','id':7}").expect("result");
            assertThat(runner.join(Duration.ofMinutes(5))).isTrue();
        } finally {
            room.loop.stop();
            runner.join();
            room.world.guard().claim();
        }
    }

    // at most once

    @Test
    void aCommandSentTwiceIsDoneOnceAndGetsItsFirstResultAgain() throws IOException {
        String push =
                "{'t':'act','id':9,'item':'duck','action':'push','arguments':{'impulse':[2,0,0]}}";
        try (TestClient ada = room.join("ada")) {
            ada.say(push).say(push).sync();
            room.step();
            JsonNode first = ada.expect("result");
            ada.expect("event");
            ada.say(push).sync();
            assertThat(ada.expect("result")).isEqualTo(first);
            room.step();
            ada.say("{'t':'ping','id':1}").expect("pong");
            assertThat(room.item("duck").physics().vector("velocity")).containsExactly(1, 0, 0);
        }
    }

    @Test
    void aRefusalIsAResultTooAndStays() throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'act','id':1,'item':'duck','action':'sing'}").sync();
            room.step();
            JsonNode refusal = ada.expect("result", "no-such-action");
            assertThat(ada.say(WIND_UP.formatted(1)).expect("result")).isEqualTo(refusal);
        }
    }

    @Test
    void aCommandThatWasNotTakenMayBeSentAgain() throws IOException {
        try (AgentRoom busy = new AgentRoom(AgentRoom.CONFIG, AgentRoom.making(), 1);
                TestClient ada = busy.join("ada")) {
            ada.say(WIND_UP.formatted(1)).say(WIND_UP.formatted(2)).sync();
            ada.expect("result", "world-busy");
            busy.step();
            ada.expect("result");
            ada.expect("event");
            ada.say(WIND_UP.formatted(2)).sync();
            busy.step();
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
        }
    }

    @Test
    void anIdThatMayHaveBeenForgottenIsNotTaken() {
        var log = new CommandLog();
        for (long id = 0; id <= CommandLog.REMEMBERED; id++) {
            log.begin(id);
            log.finish(id, new ServerMessage.Accepted(id, 1));
        }
        assertThat(log.look(0)).isInstanceOf(CommandLog.Known.Forgotten.class);
        assertThat(log.look(1))
                .isEqualTo(new CommandLog.Known.Done(new ServerMessage.Accepted(1, 1)));
        assertThat(log.look(5000)).isInstanceOf(CommandLog.Known.Fresh.class);
    }

    /** A client could otherwise fill the memory of the server with results. */
    @Test
    void theResultsOfASessionTakeLimitedMemory() {
        var log = new CommandLog();
        var long1 = new ServerMessage.Refused(0, "no", "x".repeat(8000));
        var answer =
                new ServerMessage.Answer(0, 1, Map.of("items", List.of("y".repeat(300_000), 2.0)));
        for (long id = 0; id < 100; id++) {
            log.begin(id);
            log.finish(id, long1);
        }
        int stored = CommandLog.CHARACTERS / 8000;
        assertThat(log.look(99 - stored)).isInstanceOf(CommandLog.Known.Forgotten.class);
        for (long id = 100 - stored; id < 100; id++) {
            assertThat(log.look(id)).isEqualTo(new CommandLog.Known.Done(long1));
        }

        log.begin(100);
        log.finish(100, answer);
        assertThat(log.look(99)).isInstanceOf(CommandLog.Known.Forgotten.class);
        assertThat(log.look(100)).isEqualTo(new CommandLog.Known.Done(answer));

        for (long id = 101; id < 140; id++) {
            log.begin(id);
            log.finish(id, new ServerMessage.Accepted(id, id));
        }
        assertThat(log.look(100)).isInstanceOf(CommandLog.Known.Forgotten.class);
        for (long id = 101; id < 140; id++) {
            assertThat(log.look(id))
                    .isEqualTo(new CommandLog.Known.Done(new ServerMessage.Accepted(id, id)));
        }
    }

    @Test
    void aReasonIsCut() {
        var refused = new ServerMessage.Refused(1, "no", "a".repeat(8191) + "\ud83e\udd86" + "b");
        assertThat(refused.reason())
                .endsWith("aa… (the first 8191 of 8194 characters)")
                .hasSizeLessThan(8250);
    }

    // broken connections

    @Test
    void anAgentWhoseConnectionBreaksKeepsItsBodyAndGoesOn() throws IOException {
        TestClient ada = room.connect();
        String token = joinAsAda(ada, 60);
        assertThat(token).matches("[0-9a-f]{32}");
        ada.say(WIND_UP.formatted(1)).sync();
        reset(ada);
        room.step();
        try (TestClient bob = room.join("bob");
                TestClient again = room.connect()) {
            assertThat(room.has("ada")).isTrue();
            again.say(resume("ada", token, 1)).sync();
            JsonNode welcome = again.expect("welcome");
            assertThat(welcome.get("resumed").booleanValue()).isTrue();
            assertThat(welcome.get("body").stringValue()).isEqualTo("ada");
            assertThat(again.expect("event").at("/fields/action").stringValue())
                    .isEqualTo("wind-up");
            assertThat(again.expect("event").at("/fields/agent").stringValue()).isEqualTo("bob");
            JsonNode result = again.say(WIND_UP.formatted(1)).expect("result");
            assertThat(result.get("frame").longValue()).isEqualTo(2);
            again.say("{'t':'bye'}").expectBye("goodbye");
            room.step();
            assertThat(bob.expect("event").get("type").stringValue()).isEqualTo("left");
            assertThat(room.has("ada")).isFalse();
        }
    }

    @Test
    void anotherConnectionTakesOverFromOneThatSeemsAlive() throws IOException {
        try (TestClient ada = room.connect();
                TestClient again = room.connect()) {
            String token = joinAsAda(ada, 60);
            again.say(resume("ada", token, 1)).expect("welcome");
            ada.expectBye("resumed");
            room.step();
            assertThat(room.has("ada")).isTrue();
        }
    }

    @Test
    void whoHasAnotherTokenOrNoGraceCannotTakeOver() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient eve = room.connect();
                TestClient eva = room.connect()) {
            eve.say(resume("ada", "00112233445566778899aabbccddeeff", 1))
                    .expectBye("no-such-session");
            eva.say(resume("ada", "", 1).replace("''", "'x'")).expectBye("no-such-session");
            ada.say("{'t':'ping','id':1}").expect("pong");
        }
    }

    @Test
    void whoDoesNotComeBackInTimeLeaves() throws IOException {
        TestClient ada = room.connect();
        String token = joinAsAda(ada, 0.05);
        reset(ada);
        room.stepUntil("the body is gone", () -> !room.has("ada"));
        try (TestClient late = room.connect()) {
            late.say(resume("ada", token, 1)).expectBye("no-such-session");
        }
    }

    @Test
    void whoIsCutForItsOwnFaultDoesNotStay() throws IOException {
        try (TestClient ada = room.connect()) {
            joinAsAda(ada, 60);
            for (int i = 0; i < AgentRoom.CONFIG.limits().maxErrors(); i++) {
                ada.say("nonsense");
            }
            ada.skipToBye("too-many-errors");
            room.stepUntil("the body is gone", () -> !room.has("ada"));
        }
    }

    @Test
    void whoMissedMoreThanIsRememberedIsToldSo() {
        var log = new EventLog(20, 1000);
        for (int frame = 1; frame <= 3; frame++) {
            log.add(told(frame, 1), 10 * frame);
        }
        assertThat(after(log, 0)).containsExactly(event(1), event(2), event(3));
        log.add(told(4, 1), 31);
        assertThat(after(log, 0)).containsExactly(missed(1, 1), event(2), event(3), event(4));
        assertThat(after(log, 1)).containsExactly(event(2), event(3), event(4));
        log.add(told(5, 1000), 31);
        assertThat(after(log, 3)).containsExactly(missed(4, 4), event(5));
        assertThat(after(log, 4)).containsExactly(event(5));
    }

    @Test
    void aFrameOfWhichSomeIsForgottenIsMissedAsAWhole() {
        var log = new EventLog(1000, 2);
        for (int i = 0; i < 3; i++) {
            log.add(told(7, 1), 0);
        }
        log.add(told(8, 0), 0);
        assertThat(after(log, 6)).containsExactly(missed(7, 7), event(8));
    }

    private static ServerMessage.Event missed(long first, long last) {
        return ServerMessage.Event.missed(OptionalLong.empty(), first, last);
    }

    /** An agent acts in every frame for more than a minute. */
    @Test
    void whoComesBackToABusyWorldIsToldAllThatItMissed() throws IOException {
        room.world.add(bell());
        TestClient ada = room.connect();
        String token = joinAsAda(ada, 60);
        int rings = 4_000;
        try (TestClient bob = room.join("bob")) {
            long joined = room.loop.frame();
            reset(ada);
            int atOnce = AgentRoom.CONFIG.limits().actsInFlight();
            for (int id = 0; id < rings; ) {
                for (int i = 0; i < atOnce && id < rings; i++, id++) {
                    bob.say("{'t':'act','id':" + id + ",'item':'bell','action':'ring'}");
                }
                bob.sync();
                room.step();
                bob.sync();
            }
            try (TestClient again = room.connect()) {
                again.say(resume("ada", token, joined)).expect("welcome");
                long last = joined;
                for (int heard = 0; heard < rings; ) {
                    JsonNode event = again.expect("event");
                    assertThat(event.get("frame").longValue()).isGreaterThanOrEqualTo(last);
                    last = event.get("frame").longValue();
                    heard += event.get("type").stringValue().equals("rang") ? 1 : 0;
                }
                again.say("{'t':'ping','id':1}").skipTo("pong");
            }
        }
    }

    private static HeardEvent.Told told(long frame, int bytes) {
        return new HeardEvent.Told(event(frame), new byte[bytes], Encoding.JSON);
    }

    private static List<ServerMessage.Event> after(EventLog log, long frame) {
        return log.after(frame, Encoding.JSON).stream().map(HeardEvent.Told::message).toList();
    }

    private static ServerMessage.Event event(long frame) {
        return new ServerMessage.Event(frame, "rang", Map.of());
    }

    /**
     * A connection may break at any time. No command is executed twice, and each command with a
     * result was executed.
     */
    @Test
    void randomCutsNeverDoACommandTwice() throws IOException {
        long seed = Seed.of("cuts");
        var random = new Random(seed);
        room.world.add(bell());
        TestClient ada = room.connect();
        String token = joinAsAda(ada, 60);
        long frameSeen = 1;
        int commands = CUT_COMMANDS;
        var open = new TreeSet<Integer>();
        var rings = new ArrayList<Long>();
        for (int id = 0; id < commands || !open.isEmpty(); id++) {
            if (id < commands) {
                open.add(id);
            }
            for (int command : open) {
                ada.say("{'t':'act','id':" + command + ",'item':'bell','action':'ring'}");
            }
            if (random.nextBoolean()) {
                ada.sync();
            }
            room.step();
            if (id < commands && random.nextInt(3) == 0) {
                reset(ada);
                ada = room.connect().say(resume("ada", token, frameSeen));
                ada.expect("welcome");
            } else {
                ada.say("{'t':'perceive'}").sync();
                room.step();
                JsonNode message = ada.next();
                for (; !message.get("t").stringValue().equals("perception"); message = ada.next()) {
                    if (message.get("t").stringValue().equals("result")) {
                        open.remove(message.get("id").intValue());
                    } else if (message.get("type").stringValue().equals("rang")) {
                        rings.add(message.get("frame").longValue());
                    }
                }
                frameSeen = message.get("frame").longValue();
            }
        }
        assertThat(rings).as("seed %d", seed).hasSize(commands);
        ada.close();
    }

    @Test
    void withoutTokensAFewSessionsWaitForTheirClientsAndOthersLeave() throws IOException {
        int kept = AgentRoom.CONFIG.limits().kept();
        var tokens = new HashMap<String, String>();
        for (int i = 0; i < 2 * kept; i++) {
            breakOff("agent" + i, tokens);
        }
        room.stepUntil("half of them have left", () -> bodies(tokens).size() == kept);
        String name = bodies(tokens).getFirst();
        try (TestClient back = room.connect()) {
            back.say(resume(name, tokens.get(name), room.loop.frame())).expect("welcome");
            breakOff("new", tokens);
            breakOff("newer", tokens);
            room.stepUntil("there is room for one", () -> bodies(tokens).size() == kept + 1);
            assertThat(bodies(tokens)).contains(name);
        }
    }

    private List<String> bodies(Map<String, String> tokens) {
        return tokens.keySet().stream().filter(room::has).toList();
    }

    /** Connects an agent that may resume, and breaks its connection. */
    private void breakOff(String name, Map<String, String> tokens) throws IOException {
        TestClient client = room.connect();
        tokens.put(name, join(client, name, 60));
        reset(client);
    }

    // ---- helpers ----

    /** An object that records its calls. */
    private static ItemDefinition bell() {
        return ItemDefinition.named("bell")
                .action(
                        new DeclaredAction(
                                "ring",
                                "Once.",
                                List.of(),
                                List.of(new Effect.Raise("rang", "ring"))))
                .build();
    }

    /**
     * Lets a client join. The world makes one frame for this.
     *
     * @return the token with which another connection resumes
     */
    private String joinAsAda(TestClient client, double graceSeconds) throws IOException {
        return join(client, "ada", graceSeconds);
    }

    private String join(TestClient client, String name, double graceSeconds) throws IOException {
        client.say(
                        "{'t':'hello','protocol':1,'name':'"
                                + name
                                + "','graceSeconds':"
                                + graceSeconds
                                + "}")
                .sync();
        room.step();
        String token = client.expect("welcome").at("/session/token").stringValue();
        client.expect("event");
        return token;
    }

    private TestClient guest(String name, String role) throws IOException {
        TestClient client = room.connect();
        client.say("{'t':'hello','protocol':1,'name':'" + name + "','role':'" + role + "'}")
                .expect("welcome");
        return client;
    }

    private static String resume(String name, String token, long frame) {
        return "{'t':'hello','protocol':1,'name':'"
                + name
                + "','resume':{'session':'"
                + token
                + "','frame':"
                + frame
                + "}}";
    }

    /** Breaks a client's connection, as a crash of its machine does. */
    private static void reset(TestClient client) throws IOException {
        client.socket.setSoLinger(true, 0);
        client.close();
    }
}
