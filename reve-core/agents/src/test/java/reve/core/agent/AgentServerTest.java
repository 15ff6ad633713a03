// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.agent.protocol.Vectors;
import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.Level;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.lang.management.ManagementFactory;
import java.net.InetSocketAddress;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/** Joining, perceiving, acting and leaving, over real sockets, in a world stepped by hand. */
class AgentServerTest {

    private AgentRoom room;

    @BeforeEach
    void open() throws IOException {
        room = new AgentRoom();
    }

    @AfterEach
    void close() {
        room.close();
    }

    @Test
    void theDocumentedSessionHappensLineByLine() throws IOException {
        try (AgentRoom documented = new AgentRoom(AgentServerConfig.onPort(0));
                TestClient client = documented.connect()) {
            for (JsonNode line : Vectors.lines("session.jsonl")) {
                if (line.has("client")) {
                    client.say(line.get("client").toString());
                    if (!line.at("/client/t").stringValue().equals("bye")) {
                        client.sync();
                    }
                } else if (line.has("frame")) {
                    documented.step();
                    assertThat(documented.loop.frame()).isEqualTo(line.get("frame").longValue());
                } else {
                    Vectors.assertSame(client.next(), line.get("server"));
                }
            }
        }
    }

    @Test
    void theSessionOnTheProtocolsPageIsTheVector() {
        List<String> onPage =
                Vectors.text("PROTOCOL.md")
                        .lines()
                        .dropWhile(line -> !line.startsWith("$ nc "))
                        .skip(1)
                        .takeWhile(line -> !line.equals("```"))
                        .map(line -> TestClient.json(line).toString())
                        .toList();
        List<String> vector =
                Vectors.lines("session.jsonl").stream()
                        .filter(line -> !line.has("frame"))
                        .map(line -> line.iterator().next().toString())
                        .toList();
        assertThat(onPage).isEqualTo(vector);
    }

    @Test
    void everyCodeThatTheServerUsesIsOnTheProtocolsPage() throws IOException {
        var givesCode =
                Pattern.compile(
                        "(?:CloseReason\\.\\w+|BadMessage|Refused|refuse)\\([^\"]*\"([a-z0-9-]+)\"");
        Set<String> codes = new TreeSet<>();
        Path sources =
                Path.of(
                        System.getProperty("reve.root"),
                        "reve-core/agents/src/main/java/reve/core/agent");
        try (Stream<Path> files = Files.walk(sources)) {
            for (Path file : files.filter(Files::isRegularFile).toList()) {
                givesCode
                        .matcher(Files.readString(file))
                        .results()
                        .forEach(code -> codes.add(code.group(1)));
            }
        }
        assertThat(codes)
                .hasSizeGreaterThan(30)
                .contains("bad-json", "hello-late", "world-busy", "no-such-item");
        assertThat(codes)
                .allSatisfy(
                        code -> assertThat(Vectors.text("PROTOCOL.md")).contains("`" + code + "`"));
    }

    @Test
    void perceptionsComeEveryNFramesUntilStopped() throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'perceive','id':5,'every':3}").sync();
            List<Long> frames = new ArrayList<>();
            for (int i = 0; i < 7; i++) {
                room.step();
                if (i % 3 == 0) {
                    JsonNode perception = ada.expect("perception");
                    assertThat(perception.get("id").longValue()).isEqualTo(5);
                    frames.add(perception.get("frame").longValue());
                }
            }
            assertThat(frames).containsExactly(2L, 5L, 8L);
            ada.say("{'t':'perceive','id':6,'every':0}").sync();
            room.step();
            room.step();
            room.step();
            ada.say("{'t':'perceive','id':7}").sync();
            room.step();
            assertThat(ada.expect("perception").get("id").longValue()).isEqualTo(7);
        }
    }

    @Test
    void aPerceptionShowsWhatPhysicsAndActionsChanged() throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'act','id':1,'item':'duck','action':'wind-up'}")
                    .say("{'t':'perceive','id':2}")
                    .sync();
            room.item("duck").physical().setLocation(0.1, -7, 1e-300);
            room.step();
            ada.expect("result");
            ada.expect("event");
            JsonNode duck = ada.expect("perception").get("items").get(0);
            assertThat(duck.get("location")).isEqualTo(TestClient.json("[0.1,-7.0,1e-300]"));
            assertThat(duck.at("/symbols/wound").booleanValue()).isTrue();
        }
    }

    @Test
    void whatHasNoPlaceIsPerceivedWithoutLocationAndTheWorldsConstantsNotAtAll()
            throws IOException {
        room.world.add(ItemDefinition.named("fish").at(0, 0, 0).physics("mass", 1).build());
        room.world.add(
                ItemDefinition.named("rope")
                        .kind("spring")
                        .reference("end1", "duck")
                        .reference("end2", "fish")
                        .build());
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'perceive'}").sync();
            room.step();
            JsonNode perception = ada.expect("perception");
            assertThat(perception.has("id")).isFalse();
            assertThat(perception.get("items").findValuesAsString("name"))
                    .containsSubsequence("duck", "fish", "rope", "ada")
                    .doesNotContain("world");
            assertThat(perception.get("items").get(2))
                    .isEqualTo(
                            TestClient.json(
                                    "{'name':'rope','symbols':{'name':'rope','class':'spring'},'actions':{}}"));
        }
    }

    @Test
    void onlyOnePerceptionCanBeAwaited() throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'perceive','id':1}").say("{'t':'perceive','id':2}").sync();
            assertThat(ada.expect("error", "perceive-pending").get("id").longValue()).isEqualTo(2);
            room.step();
            assertThat(ada.expect("perception").get("id").longValue()).isEqualTo(1);
        }
    }

    @Test
    void whoReadsLateGetsTheNewestPerceptionNotAllOfThem() throws IOException {
        for (int i = 0; i < 2000; i++) {
            room.world.add(
                    ItemDefinition.named("stone " + i)
                            .at(i, 0, 0)
                            .symbol("note", "x".repeat(100))
                            .build());
        }
        try (TestClient slow = new TestClient(room.server.address(), 4096)) {
            slow.say("{'t':'hello','protocol':1,'name':'slow'}")
                    .say("{'t':'perceive','every':1}")
                    .sync();
            int frames = 200;
            for (int i = 0; i < frames; i++) {
                room.step();
            }
            slow.expect("welcome");
            slow.expect("event");
            int count = 0;
            long last = 0;
            while (last < frames) {
                long frame = slow.expect("perception").get("frame").longValue();
                assertThat(frame).isGreaterThan(last);
                last = frame;
                count++;
            }
            assertThat(count).isLessThan(frames / 2);
        }
    }

    @Test
    void anActIsDoneInTheNextFrameAndItsResultNamesIt() throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say(
                            "{'t':'act','id':9,'item':'duck','action':'push',"
                                    + "'arguments':{'impulse':[3,0,-1]}}")
                    .sync();
            assertThat(room.item("duck").physics().vector("velocity")).containsExactly(0, 0, 0);
            room.step();
            assertThat(room.item("duck").physics().vector("velocity"))
                    .containsExactly(1.5, 0, -0.5);
            assertThat(ada.expect("result"))
                    .isEqualTo(TestClient.json("{'t':'result','id':9,'accepted':true,'frame':2}"));
            assertThat(room.server.stats().actsAccepted()).isEqualTo(1);
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            quoteCharacter = '`',
            value = {
                "swan | push | {} | no-such-item | the world has no item \"swan\"",
                "duck | sing | {} | no-such-action | \"sing\"; it has [push, wind-up]",
                "ada | sing | {} | no-such-action | it has none",
                "duck | push | {} | missing-argument | impulse",
                "duck | push | {'impulse':[1,2]} | wrong-components | 3 numbers in N*s, found 2",
                "duck | push | {'impulse':'far'} | wrong-type | found a text",
                "duck | push | {'impulse':[1,2,3],'how':true} | unknown-argument | how",
                "duck | wind-up | {'turns':3} | unknown-argument | it takes no arguments",
            })
    void anActThatDoesNotFitIsRefusedWithAReason(
            String item, String action, String arguments, String code, String reason)
            throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say(
                            "{'t':'act','id':1,'item':'"
                                    + item
                                    + "','action':'"
                                    + action
                                    + "','arguments':"
                                    + arguments
                                    + "}")
                    .sync();
            room.step();
            JsonNode result = ada.expect("result", code);
            assertThat(result.get("accepted").booleanValue()).isFalse();
            assertThat(result.has("frame")).isFalse();
            assertThat(result.get("reason").stringValue()).contains(reason);
            assertThat(room.item("duck").physics().vector("velocity")).containsExactly(0, 0, 0);
            assertThat(room.server.stats().actsRefused()).isEqualTo(1);
        }
    }

    @Test
    void anActionWithAnErrorOfItsOwnCostsNobodyElseAnything() throws IOException {
        room.world.add(ItemDefinition.named("bomb").action(AgentRoom.broken()).build());
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'act','id':1,'item':'bomb','action':'explode'}")
                    .say("{'t':'act','id':2,'item':'duck','action':'wind-up'}")
                    .sync();
            room.step();
            ada.expect("result", "action-failed");
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
        }
    }

    @Test
    void actsOfOneFrameAreOrderedByNameAndSequenceNotByArrival() throws IOException {
        try (TestClient zoe = room.join("zoe");
                TestClient ada = room.join("ada")) {
            zoe.expect("event"); // ada joined
            String act = "{'t':'act','id':%d,'item':'duck','action':'wind-up'}";
            zoe.say(act.formatted(1)).say(act.formatted(2)).sync();
            ada.say(act.formatted(3)).sync();
            room.step();
            ada.expect("result");
            List<String> actors = new ArrayList<>();
            for (int i = 0; i < 3; i++) {
                actors.add(ada.expect("event").at("/fields/agent").stringValue());
            }
            assertThat(actors).containsExactly("ada", "zoe", "zoe");
        }
    }

    @Test
    void moreActsThanMayBeInFlightAreRefusedAtOnceAndTheOthersAreDone() throws IOException {
        try (TestClient ada = room.join("ada")) {
            int allowed = AgentRoom.CONFIG.limits().actsInFlight();
            for (int i = 0; i <= allowed; i++) {
                ada.say("{'t':'act','id':" + i + ",'item':'duck','action':'wind-up'}");
            }
            ada.sync();
            assertThat(ada.expect("result", "too-many-acts").get("id").intValue())
                    .isEqualTo(allowed);
            room.step();
            for (int i = 0; i < allowed; i++) {
                JsonNode result = ada.expect("result");
                assertThat(result.get("id").intValue()).isEqualTo(i);
                assertThat(result.get("accepted").booleanValue()).isTrue();
            }
            for (int i = 0; i < allowed; i++) {
                ada.expect("event");
            }
            ada.say("{'t':'act','id':99,'item':'duck','action':'wind-up'}").sync();
            room.step();
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
        }
    }

    @Test
    void aFullWorldRefusesActsAndHellosButNeverALeave() throws IOException {
        try (AgentRoom busy = new AgentRoom(AgentRoom.CONFIG, AgentRoom.making(), 1);
                TestClient ada = busy.join("ada");
                TestClient bob = busy.connect()) {
            ada.say("{'t':'act','id':1,'item':'duck','action':'wind-up'}")
                    .say("{'t':'act','id':2,'item':'duck','action':'wind-up'}")
                    .sync();
            assertThat(ada.expect("result", "world-busy").get("id").longValue()).isEqualTo(2);
            bob.say("{'t':'hello','protocol':1,'name':'bob'}").expectBye("world-busy");
            ada.say("{'t':'bye'}").expectBye("goodbye");
            busy.stepUntil("the leave has found room", () -> !busy.has("ada"));
        }
    }

    @Test
    void everybodyHearsWhatHappensFromTheirWelcomeOn() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient bob = room.join("bob")) {
            assertThat(ada.expect("event"))
                    .isEqualTo(
                            TestClient.json(
                                    "{'t':'event','frame':2,'type':'joined',"
                                            + "'fields':{'agent':'bob','body':'bob'}}"));
            bob.say("{'t':'bye'}").expectBye("goodbye");
            room.step();
            assertThat(ada.expect("event"))
                    .isEqualTo(
                            TestClient.json(
                                    "{'t':'event','frame':3,'type':'left',"
                                            + "'fields':{'agent':'bob','body':'bob','reason':'goodbye'}}"));
        }
    }

    @Test
    void aMadeBodyComesToTheFirstPlaceThatNoAgentHas() throws IOException {
        var policy =
                new AgentPolicy(
                        List.of(),
                        AgentRoom.making().template(),
                        List.of(
                                new AgentPolicy.Place(0, 0.5, 0),
                                new AgentPolicy.Place(3, 0.5, 1)));
        try (AgentRoom hall = new AgentRoom(AgentRoom.CONFIG, policy, 64);
                TestClient ada = hall.join("ada");
                TestClient bob = hall.join("bob");
                TestClient eve = hall.connect()) {
            assertThat(hall.item("ada").physical().location()).containsExactly(0, 0.5, 0);
            assertThat(hall.item("bob").physical().location()).containsExactly(3, 0.5, 1);
            eve.say("{'t':'hello','protocol':1,'name':'eve'}");
            hall.stepUntil("eve was refused", eve::hasNews);
            eve.expectBye("no-body-free");
            ada.say("{'t':'bye'}").skipToBye("goodbye");
            hall.step();
            hall.join("zoe").close();
            assertThat(hall.item("zoe").physical().location()).containsExactly(0, 0.5, 0);
            bob.say("{'t':'ping','id':1}").skipTo("pong");
        }
    }

    @Test
    void aWorldTakesNoFewerAgentsThanItHasBodiesForThem() throws IOException {
        var duck = AgentRoom.duck();
        var goose = ItemDefinition.named("goose").shape(Shape.sphere(0.3)).build();
        try (AgentRoom hall =
                        new AgentRoom(
                                AgentRoom.CONFIG,
                                AgentRoom.lending("duck", "goose").withMost(1),
                                64,
                                List.of(duck, goose));
                TestClient ada = hall.join("ada");
                TestClient bob = hall.join("bob")) {
            ada.say("{'t':'ping','id':1}").skipTo("pong");
            bob.say("{'t':'ping','id':1}").skipTo("pong");
        }
    }

    @Test
    void aWorldTakesAsManyAgentsAsItsFileAllowsThoseIncludedWhoMayComeBack() throws IOException {
        try (AgentRoom hall = new AgentRoom(AgentRoom.CONFIG, AgentRoom.making().withMost(2), 64);
                TestClient bob = hall.join("bob");
                TestClient eve = hall.connect();
                TestClient eye = hall.connect()) {
            try (TestClient ada = hall.connect()) {
                ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':60}").sync();
                hall.step();
                ada.expect("welcome");
            }
            eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}").expect("welcome");
            eve.say("{'t':'hello','protocol':1,'name':'eve'}");
            hall.stepUntil("eve was refused", eve::hasNews);
            eve.expectBye("world-full");
            assertThat(hall.has("ada")).as("it may come back").isTrue();
            bob.say("{'t':'bye'}").skipToBye("goodbye");
            hall.step();
            hall.join("zoe").close();
        }
    }

    @Test
    void aMadeBodyGoesWithItsAgentHoweverItLeaves() throws IOException {
        TestClient ada = room.join("ada");
        TestClient bob = room.join("bob");
        assertThat(room.has("ada") && room.has("bob")).isTrue();
        ada.expect("event"); // bob joined
        ada.say("{'t':'bye'}").expectBye("goodbye");
        room.step();
        assertThat(room.has("ada")).isFalse();
        bob.socket.setSoLinger(true, 0); // closing it resets, as a crash does
        bob.close();
        room.stepUntil("the body of who is gone is gone too", () -> !room.has("bob"));
        assertThat(room.has("duck")).isTrue();
    }

    @Test
    void aLentBodyStaysAndIsFreeAgain() throws IOException {
        try (AgentRoom lending = new AgentRoom(AgentRoom.CONFIG, AgentRoom.lending("duck"), 64)) {
            try (TestClient ada = lending.join("ada");
                    TestClient bob = lending.connect();
                    TestClient cleo = lending.connect()) {
                bob.say("{'t':'hello','protocol':1,'name':'bob'}").sync();
                cleo.say("{'t':'hello','protocol':1,'name':'cleo','body':'duck'}").sync();
                lending.step();
                bob.expectBye("no-body-free");
                cleo.expectBye("body-taken");
                ada.say("{'t':'bye'}").expectBye("goodbye");
            }
            lending.step();
            assertThat(lending.has("duck")).isTrue();
            try (TestClient dan = lending.connect()) {
                dan.say("{'t':'hello','protocol':1,'name':'dan','body':'duck'}").sync();
                lending.step();
                assertThat(dan.expect("welcome").get("body").stringValue()).isEqualTo("duck");
            }
        }
    }

    @Test
    void aLentBodyThatIsGoneIsNotGivenOut() throws IOException {
        try (AgentRoom lending = new AgentRoom(AgentRoom.CONFIG, AgentRoom.lending("duck"), 64);
                TestClient ada = lending.connect()) {
            lending.world.remove(lending.item("duck").id());
            ada.say("{'t':'hello','protocol':1,'name':'ada','body':'duck'}").sync();
            lending.step();
            assertThat(ada.expectBye("no-such-body").get("message").stringValue())
                    .contains("no longer");
        }
    }

    @Test
    void aWorldThatGrantsNoBodiesSaysWhatToAddToItsFile() throws IOException {
        try (AgentRoom closed = new AgentRoom(AgentRoom.CONFIG, AgentPolicy.none(), 64);
                TestClient ada = closed.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada'}")
                    .say("{'t':'act','id':1,'item':'duck','action':'wind-up'}")
                    .sync();
            closed.step();
            assertThat(ada.expectBye("no-bodies").get("hint").stringValue())
                    .contains("agents:", "world file");
            assertThat(closed.item("duck").semantic().get("wound")).isEqualTo(Optional.empty());
        }
    }

    @Test
    void aNameIsHeldByOneAgentAndFreeAgainWhenItHasLeft() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient second = room.connect()) {
            second.say("{'t':'hello','protocol':1,'name':'ada'}").expectBye("name-taken");
            ada.say("{'t':'bye'}").expectBye("goodbye");
        }
        try (TestClient again = room.connect()) {
            // The old body leaves and the new one comes in the same frame.
            again.say("{'t':'hello','protocol':1,'name':'ada'}").sync();
            room.step();
            assertThat(again.expect("welcome").get("body").stringValue()).isEqualTo("ada");
        }
    }

    @Test
    void anAgentCannotHaveTheNameOfAnItem() throws IOException {
        try (TestClient duck = room.connect()) {
            duck.say("{'t':'hello','protocol':1,'name':'duck'}").sync();
            room.step();
            assertThat(duck.expectBye("name-taken").get("hint").stringValue())
                    .contains("another name");
        }
    }

    /** An agent with the name of a part would prevent a change to its level. */
    @Test
    void anAgentCannotHaveTheNameOfAPartOfALevel() throws IOException {
        ItemDefinition core = ItemDefinition.named("core").physics("mass", 1).build();
        Level whole = new Level("whole", false, List.of(core), Optional.empty());
        Level parts = new Level("parts", true, List.of(core), Optional.empty());
        room.world.add(
                ItemDefinition.named("drop")
                        .physics("mass", 1)
                        .symbol("level", "whole")
                        .levels(List.of(whole, parts))
                        .build());
        try (TestClient drop = room.connect()) {
            drop.say("{'t':'hello','protocol':1,'name':'drop.core'}").sync();
            room.step();
            drop.expectBye("name-taken");
        }
    }

    @Test
    void whoIsRefusedANameIsNotToldWhetherAnItemHasIt() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient second = room.connect();
                TestClient duck = room.connect()) {
            second.say("{'t':'hello','protocol':1,'name':'ada'}");
            duck.say("{'t':'hello','protocol':1,'name':'duck'}").sync();
            room.step();
            assertThat(duck.expectBye("name-taken").toString().replace("duck", "ada"))
                    .isEqualTo(second.expectBye("name-taken").toString());
            ada.say("{'t':'bye'}").expectBye("goodbye");
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            quoteCharacter = '`',
            value = {
                "'protocol':2,'name':'ada' | protocol-unsupported",
                "'protocol':0,'name':'ada' | protocol-unsupported",
                "'protocol':1,'name':'ada','role':'god' | role-unsupported",
                "'protocol':1,'name':'ada','resume':{'session':'0011','frame':3} | no-such-session",
                "'protocol':1,'name':'-ada' | bad-name",
                "'protocol':1,'name':'a da' | bad-name",
                "'protocol':1,'name':'ä' | bad-name",
                "'protocol':1,'name':'ada\\u202e' | bad-name",
            })
    void aHelloThatCannotBeGrantedEndsTheConnectionWithAHint(String fields, String code)
            throws IOException {
        try (TestClient client = room.connect()) {
            JsonNode bye = client.say("{'t':'hello'," + fields + "}").expectBye(code);
            assertThat(bye.get("message").stringValue()).isNotBlank();
            assertThat(bye.get("hint").stringValue()).isNotBlank();
        }
    }

    @Test
    void foreignTextComesBackWithoutWhatCouldForgeOrHideALine() throws IOException {
        try (TestClient client = room.connect()) {
            client.say("{'t':'hello','protocol':1,'name':'ada','body':'x\\n\\u0000\\u202e'}")
                    .sync();
            room.step();
            assertThat(client.expectBye("no-such-body").get("message").stringValue())
                    .endsWith("no item \"x\\u{a}\\u{0}\\u{202e}\"");
        }
    }

    @Test
    void helloComesFirstAndOnce() throws IOException {
        try (TestClient client = room.connect()) {
            client.say("{'t':'perceive','id':4}");
            assertThat(client.expect("error", "hello-expected").get("id").longValue()).isEqualTo(4);
            client.say("{'t':'hello','protocol':1,'name':'ada'}").sync();
            room.step();
            client.expect("welcome");
            client.expect("event");
            client.say("{'t':'hello','protocol':1,'name':'eve'}").sync();
            client.expect("error", "hello-again");
        }
    }

    @Test
    void theWorldsThreadAllocatesNothingForAgentsThatOnlyPerceive() throws IOException {
        var threads = (com.sun.management.ThreadMXBean) ManagementFactory.getThreadMXBean();
        List<TestClient> agents = new ArrayList<>();
        for (int i = 0; i < 20; i++) {
            agents.add(
                    room.connect()
                            .say("{'t':'hello','protocol':1,'name':'agent%d'}".formatted(i))
                            .say("{'t':'perceive','every':1}")
                            .sync());
        }
        for (int i = 0; i < 2000; i++) {
            room.step();
        }
        // If the machine is busy, a slow reader may receive an event late. Such an event has no
        // frame.
        long least = Long.MAX_VALUE;
        for (int batch = 0; batch < 4; batch++) {
            long before = threads.getCurrentThreadAllocatedBytes();
            for (int i = 0; i < 250; i++) {
                room.step();
            }
            least = Math.min(least, threads.getCurrentThreadAllocatedBytes() - before);
        }
        assertThat(least).as("bytes of 250 frames").isZero();
        // A busy machine may encode no frame of a burst for the agents.
        room.stepUntil("perceptions", () -> room.server.stats().perceptions() > 20);
        for (TestClient agent : agents) {
            agent.close();
        }
    }

    @Test
    void closingSaysByeToEverybody() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient stranger = room.connect()) {
            stranger.say("{'t':'ping'}").expect("error"); // it has been accepted
            room.server.close();
            ada.expectBye("closing");
            stranger.expectBye("closing");
            room.server.close();
        }
        assertThat(room.server.stats().open()).isZero();
        assertThat(room.server.stats().agents()).isZero();
    }

    @ParameterizedTest
    @ValueSource(strings = {"0.0.0.0", "192.0.2.1", "::"})
    void otherAddressesThanLoopbackTakeTokensAndTls(String address) {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> AgentServerConfig.on(new InetSocketAddress(address, 7777)))
                .withMessageContaining("without tokens and TLS");
    }

    @Test
    void aPortThatIsTakenIsNamed() {
        int port = room.server.address().getPort();
        assertThatThrownBy(() -> new AgentRoom(AgentServerConfig.onPort(port)).close())
                .isInstanceOf(IOException.class)
                .hasMessageContaining("127.0.0.1 port " + port);
    }

    @Test
    void theCountersAddUp() throws IOException {
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'nonsense'}").say("{'t':'perceive'}").sync();
            room.step();
            ada.expect("error");
            ada.expect("perception");
            AgentStats stats = room.server.stats();
            assertThat(stats).isEqualTo(new AgentStats(1, 1, 1, 1, 5, 1, 1, 0, 0, 0, 0));
        }
    }
}
