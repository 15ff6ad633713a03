// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.agent.port.Cameras;
import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.Elsewhere;
import reve.core.agent.port.WorldPort;
import reve.core.derive.DerivedColumns;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.OffHeapArena;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.time.Duration;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.TimeUnit;

/** Two worlds behind one port, stepped by hand independently. */
class SeveralWorldsTest {

    private final Pond pond = new Pond("pond");
    private final Pond lake = new Pond("lake");
    private AgentServer server;

    private static final class Pond {
        private final World world;
        private final FrameLoop loop;
        private final WorldPort port;

        Pond(String name) {
            world = new World(name, WorldPrototype.standard("si-f64"), new OffHeapArena());
            world.add(AgentRoom.duck());
            var bus = new FrameBus();
            var commands = new CommandQueue(64);
            commands.subscribeTo(bus);
            DerivedColumns.subscribeTo(bus);
            var snapshots = new SnapshotRing(world, 3);
            bus.subscribe(
                    FramePhase.PUBLISH,
                    "snapshots",
                    event -> snapshots.publish(event.frame(), event.timeSeconds()));
            loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
            port =
                    new WorldPort(
                            name,
                            60,
                            AgentRoom.making(),
                            bus,
                            commands,
                            snapshots,
                            loop,
                            new RoomControl(world, loop),
                            Cameras.none());
        }
    }

    @BeforeEach
    void open() throws IOException {
        server =
                AgentServer.start(
                        AgentRoom.CONFIG, List.of(pond.port, lake.port), (source, message) -> {});
    }

    @AfterEach
    void close() {
        server.close();
    }

    @Test
    void helloSaysWhichWorldAndTheWelcomeNamesIt() throws IOException {
        try (TestClient _ = join("ada", pond);
                TestClient _ = join("bob", lake)) {
            assertThat(pond.world.find("ada")).isPresent();
            assertThat(pond.world.find("bob")).isEmpty();
            assertThat(lake.world.find("bob")).isPresent();
        }
    }

    @Test
    void whoNamesNoWorldOrAnotherIsToldWhichThereAre() throws IOException {
        for (String hello :
                List.of(
                        "{'t':'hello','protocol':1,'name':'ada'}",
                        "{'t':'hello','protocol':1,'name':'ada','world':'sea'}")) {
            try (TestClient ada = new TestClient(server.address())) {
                assertThat(ada.say(hello).expectBye("no-such-world").get("hint").stringValue())
                        .contains("\"pond\"")
                        .contains("\"lake\"");
            }
        }
    }

    @Test
    void worldsShareNeitherNamesNorEventsNorFrames() throws IOException {
        try (TestClient ada = join("ada", pond);
                TestClient other = join("ada", lake)) {
            ada.say("{'t':'act','id':1,'item':'duck','action':'wind-up'}").sync();
            pond.loop.step();
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
            assertThat(pond.world.find("duck").orElseThrow().semantic().get("wound")).isPresent();
            assertThat(lake.world.find("duck").orElseThrow().semantic().get("wound")).isEmpty();
            other.say("{'t':'perceive','id':2}").sync();
            lake.loop.step();
            assertThat(other.expect("perception").get("frame").longValue()).isEqualTo(2);
        }
    }

    @Test
    void aWorldThatEndsSaysByeToItsOwnAndIsNotThereAnyMore() throws IOException {
        try (TestClient ada = join("ada", pond);
                TestClient bob = join("bob", lake);
                TestClient late = new TestClient(server.address())) {
            server.end("pond");
            ada.expectBye("closing");
            late.say("{'t':'hello','protocol':1,'name':'eve','world':'pond'}")
                    .expectBye("no-such-world");
            bob.say("{'t':'perceive','id':1}").sync();
            lake.loop.step();
            bob.expect("perception");
        }
    }

    @Test
    void aWorldComesAndGoesWhileTheServerRuns() throws IOException {
        Pond sea = new Pond("sea");
        server.add(sea.port);
        assertThatIllegalArgumentException()
                .isThrownBy(() -> server.add(new Pond("sea").port))
                .withMessageContaining("sea");
        try (TestClient bob = join("bob", lake);
                TestClient ada = join("ada", sea);
                TestClient late = new TestClient(server.address());
                TestClient again = new TestClient(server.address())) {
            TestClient eve = new TestClient(server.address());
            eve.say("{'t':'hello','protocol':1,'name':'eve','world':'sea','graceSeconds':60}")
                    .sync();
            sea.loop.step();
            String token = eve.expect("welcome").at("/session/token").stringValue();
            eve.close(); // its session waits for another connection
            server.remove("sea");
            ada.skipToBye("closing");
            assertThat(server.stats().agents()).as("bob").isEqualTo(1);
            late.say("{'t':'hello','protocol':1,'name':'ada','world':'sea'}")
                    .expectBye("no-such-world");
            again.say(
                            "{'t':'hello','protocol':1,'name':'eve','world':'sea','resume':{'session':'"
                                    + token
                                    + "','frame':1}}")
                    .expectBye("no-such-session");
            Pond next = new Pond("sea");
            server.add(next.port);
            try (TestClient _ = join("ada", next)) {
                assertThat(next.world.find("ada")).isPresent();
            }
            bob.say("{'t':'perceive','id':1}").sync();
            lake.loop.step();
            bob.expect("perception");
        }
    }

    @Test
    void aClientIsSentToTheServerThatHasItsWorld() throws IOException {
        server.sendTo(
                () ->
                        Map.of(
                                "sea", "10.0.0.2:7777",
                                "pond", "10.0.0.3:7777",
                                "well", ""));
        JsonNode bye = refused("sea", "moved");
        assertThat(bye.get("address").stringValue()).isEqualTo("10.0.0.2:7777");
        assertThat(bye.get("message").stringValue()).contains("10.0.0.2:7777", "\"sea\"");
        assertThat(refused("well", "world-starting").has("address")).isFalse();
        assertThat(refused("dew", "no-such-world").get("hint").stringValue())
                .endsWith("\"lake\" or \"pond\" or \"sea\" or \"well\"");
        try (TestClient _ = join("ada", pond)) { // this server has it, whatever others say
            assertThat(pond.world.find("ada")).isPresent();
        }
    }

    @Test
    void aSessionKnowsTheOtherServers() throws IOException {
        server.sendTo(
                new Elsewhere() {
                    @Override
                    public Map<String, String> worlds() {
                        return Map.of();
                    }

                    @Override
                    public List<String> servers() {
                        return List.of("10.0.0.2:7777", "10.0.0.3:7777");
                    }
                });
        String hello = "{'t':'hello','protocol':1,'name':'eye','role':'observer','world':'pond'";
        try (TestClient eye = new TestClient(server.address())) {
            JsonNode servers =
                    eye.say(hello + ",'graceSeconds':5}").expect("welcome").at("/session/servers");
            assertThat(servers.valueStream().map(JsonNode::stringValue))
                    .containsExactly("10.0.0.2:7777", "10.0.0.3:7777");
        }
        try (TestClient other = new TestClient(server.address())) {
            JsonNode welcome = other.say(hello.replace("eye", "other") + "}").expect("welcome");
            assertThat(welcome.has("session")).as("without a grace").isFalse();
        }
    }

    /** A server that does not know the other worlds yet refuses no client for good. */
    @Test
    void aServerThatHasNotJoinedItsClusterAsksToTryAgain() throws IOException {
        server.sendTo(Elsewhere.UNKNOWN);
        assertThat(refused("dew", "world-starting").has("address")).isFalse();
        for (int i = 0; i < 12; i++) { // more than wrong sessions are permitted
            try (TestClient client = new TestClient(server.address())) {
                client.say(
                                "{'t':'hello','protocol':1,'name':'ada','world':'dew','resume':"
                                        + "{'session':'"
                                        + "0".repeat(32)
                                        + "','frame':1}}")
                        .expectBye("world-starting");
            }
        }
        try (TestClient client = new TestClient(server.address())) {
            client.say("{'t':'hello','protocol':1,'name':'ada'}").expectBye("world-starting");
        }
        try (TestClient _ = join("ada", pond)) { // a world that it has is open
            assertThat(pond.world.find("ada")).isPresent();
        }
    }

    /** The answer comes instead of a session: no world is joined, and none wakes. */
    @Test
    void aControlClientAsksForTheClusterInsteadOfJoining() throws IOException {
        String hello = "{'t':'hello','protocol':1,'name':'op','id':7,'role':'control','ask':";
        try (TestClient alone = new TestClient(server.address())) {
            alone.say(hello + "'cluster'}").expectBye("unsupported");
        }
        server.sendTo(Elsewhere.UNKNOWN);
        try (TestClient early = new TestClient(server.address())) {
            early.say(hello + "'cluster'}").expectBye("world-starting");
        }
        var wanted = new CopyOnWriteArrayList<String>();
        ClusterPort cluster = new OneNode();
        server.sendTo(
                new Elsewhere() {
                    @Override
                    public Map<String, String> worlds() {
                        return Map.of("well", "");
                    }

                    @Override
                    public Optional<ClusterPort> cluster() {
                        return Optional.of(cluster);
                    }

                    @Override
                    public void wanted(String world) {
                        wanted.add(world);
                    }
                });
        try (TestClient op = new TestClient(server.address())) {
            JsonNode result = op.say(hello + "'cluster','world':'well'}").expect("result");
            assertThat(result.get("id").intValue()).isEqualTo(7);
            assertThat(result.at("/value/cluster").stringValue()).isEqualTo("lab");
            op.expectBye("answered");
        }
        assertThat(wanted).isEmpty();
        try (TestClient op = new TestClient(server.address())) {
            op.say(hello + "'weather'}").expectBye("bad-question");
        }
        try (TestClient agent = new TestClient(server.address())) {
            agent.say(hello.replace("control", "agent") + "'cluster'}").expectBye("bad-question");
        }
    }

    private static final class OneNode implements ClusterPort {
        @Override
        public Map<String, Object> state() {
            return Map.of("cluster", "lab");
        }

        @Override
        public Map<String, Object> move(String world, String node) {
            throw new AssertionError("not asked for");
        }

        @Override
        public Map<String, Object> drain(String node, boolean isDrained) {
            throw new AssertionError("not asked for");
        }

        @Override
        public Map<String, Object> add(String text, boolean isAsleep) {
            throw new AssertionError("not asked for");
        }
    }

    /** A world that sleeps wakes by this; a world that is known elsewhere needs no waking. */
    @Test
    void theOtherServersLearnThatAClientWantsAWorldThatNoServerRuns() throws IOException {
        var wanted = new CopyOnWriteArrayList<String>();
        server.sendTo(
                new Elsewhere() {
                    @Override
                    public Map<String, String> worlds() {
                        return Map.of("sea", "10.0.0.2:7777", "well", "");
                    }

                    @Override
                    public void wanted(String world) {
                        wanted.add(world);
                    }
                });
        refused("sea", "moved");
        refused("dew", "no-such-world");
        assertThat(wanted).isEmpty();
        refused("well", "world-starting");
        refused("well", "world-starting");
        assertThat(wanted).containsExactly("well", "well");
    }

    @Test
    void onlyAWorldWithoutClientsEndsAsUnused() throws Exception {
        assertThat(server.endIfUnused("pond", Duration.ofHours(1))).as("it is new").isFalse();
        assertThat(server.endIfUnused("sea", Duration.ZERO)).as("no such world").isFalse();
        TestClient ada = new TestClient(server.address());
        ada.say("{'t':'hello','protocol':1,'name':'ada','world':'pond','graceSeconds':60}").sync();
        pond.loop.step();
        String token = ada.expect("welcome").at("/session/token").stringValue();
        assertThat(server.endIfUnused("pond", Duration.ZERO)).as("ada is there").isFalse();
        ada.close(); // its session waits for another connection
        try (TestClient bob = new TestClient(server.address())) {
            bob.say(
                            "{'t':'hello','protocol':1,'name':'ada','world':'pond','resume':{'session':'"
                                    + token
                                    + "','frame':1}}")
                    .expect("welcome");
            assertThat(server.endIfUnused("pond", Duration.ZERO)).as("ada is back").isFalse();
            bob.say("{'t':'bye'}").skipToBye("goodbye");
        }
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(300);
        while (!server.endIfUnused("pond", Duration.ZERO)) {
            assertThat(System.nanoTime()).as("the world does not end").isLessThan(end);
            pond.loop.step();
        }
        assertThat(server.endIfUnused("pond", Duration.ZERO)).as("it has ended").isFalse();
        refused("pond", "no-such-world");
        assertThat(server.endIfUnused("lake", Duration.ofHours(1))).isFalse();
        try (TestClient _ = join("ada", lake)) {
            assertThat(lake.world.find("ada")).isPresent();
        }
    }

    private JsonNode refused(String world, String code) throws IOException {
        try (TestClient client = new TestClient(server.address())) {
            return client.say("{'t':'hello','protocol':1,'name':'ada','world':'" + world + "'}")
                    .expectBye(code);
        }
    }

    @Test
    void aBrokenConnectionGoesOnInItsOwnWorld() throws IOException {
        TestClient ada = new TestClient(server.address());
        ada.say("{'t':'hello','protocol':1,'name':'ada','world':'lake','graceSeconds':60}").sync();
        lake.loop.step();
        String token = ada.expect("welcome").at("/session/token").stringValue();
        ada.close();
        String resume = "'name':'ada','resume':{'session':'" + token + "','frame':1}}";
        try (TestClient wrong = new TestClient(server.address());
                TestClient right = new TestClient(server.address())) {
            wrong.say("{'t':'hello','protocol':1,'world':'pond'," + resume)
                    .expectBye("no-such-session");
            right.say("{'t':'hello','protocol':1,'world':'lake'," + resume);
            assertThat(right.expect("welcome").get("world").stringValue()).isEqualTo("lake");
        }
    }

    private TestClient join(String name, Pond in) throws IOException {
        var client = new TestClient(server.address());
        client.say(
                        "{'t':'hello','protocol':1,'name':'"
                                + name
                                + "','world':'"
                                + in.world.name()
                                + "'}")
                .sync();
        in.loop.step();
        assertThat(client.expect("welcome").get("world").stringValue()).isEqualTo(in.world.name());
        client.expect("event");
        return client;
    }
}
