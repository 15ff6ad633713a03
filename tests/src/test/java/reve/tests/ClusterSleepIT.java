// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;

/** Worlds of a cluster that sleep while no client is connected to them. */
@Tag("slow")
class ClusterSleepIT {
    private static final int RATE = 20;
    private static final int SLEEP_AFTER_SECONDS = 8;
    private static final String DATABASE = "sleep";

    @TempDir private Path folder;
    private final List<Server> servers = new ArrayList<>();
    private Postgres postgres;
    private String url;

    /**
     * @param address where other nodes reach it
     * @param agents port for agents
     */
    private record Node(Server server, String address, int agents) {
        JsonNode ready(String world, long epoch) throws IOException {
            return event("ready", world, epoch);
        }

        JsonNode asleep(String world, long epoch) throws IOException {
            return event("world-asleep", world, epoch);
        }

        private JsonNode event(String type, String world, long epoch) throws IOException {
            return server.events()
                    .await(
                            type,
                            event ->
                                    event.path("world").asString().equals(world)
                                            && event.path("epoch").asLong() == epoch);
        }
    }

    @BeforeEach
    void start() throws Exception {
        postgres = new Postgres();
        url = postgres.create(DATABASE);
    }

    @AfterEach
    void end() throws Exception {
        servers.forEach(Server::close);
        postgres.close();
    }

    private Node node(String... more) throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of(
                                "serve",
                                "--cluster",
                                "lab",
                                "--port",
                                "0",
                                "--json",
                                "--sleep-after",
                                Integer.toString(SLEEP_AFTER_SECONDS),
                                "--store",
                                url));
        arguments.addAll(List.of(more));
        Server server =
                Server.start(
                        Files.createDirectory(folder.resolve("node" + servers.size())),
                        arguments.toArray(String[]::new));
        servers.add(server);
        JsonNode starts =
                server.events()
                        .await(
                                "cluster",
                                event -> event.path("status").asString().equals("starts"));
        return new Node(server, starts.path("node").asString(), starts.path("agentPort").asInt());
    }

    /** Writes a world of this name: two bodies at 20 frames a second. */
    private Path world(String name) throws IOException {
        Path file = folder.resolve(name + ".yaml");
        String sample = Files.readString(Project.WORLDS.resolve("spring-orbit/world.yaml"));
        Files.writeString(
                file,
                sample.replace("name: spring-orbit", "name: " + name)
                        .replace("rate: 60, steps: 4", "rate: " + RATE + ", steps: 12"));
        return file;
    }

    private PostgresStore.World stored(String name) throws IOException {
        return PostgresStore.worlds(PostgresUrl.find(url).orElseThrow()).stream()
                .filter(world -> world.name().equals(name))
                .findFirst()
                .orElseThrow();
    }

    private static AgentClient join(Node node, Join join, String world) throws IOException {
        return Agents.join(node.agents(), join.withWorld(world));
    }

    private static AgentClient watch(Node node, String world) throws IOException {
        return join(node, Join.as("watcher").withRole("observer"), world);
    }

    /** Returns the hash of a world that makes this number of frames by itself. */
    private String undisturbedHash(String world, long frames) throws Exception {
        Outcome run =
                Reve.run(
                        "run",
                        world(world).toString(),
                        "--seconds",
                        Double.toString((double) frames / RATE),
                        "--json");
        assertThat(run.code()).as(run.err()).isZero();
        return new JsonMapper().readTree(run.out()).path("stateHash").asString();
    }

    /**
     * Requires that a world does nothing for longer than a world without clients continues, and
     * longer than a lease.
     */
    private void requireStill(String world, long epoch, long frame) throws IOException {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(12);
        while (System.nanoTime() < end) {
            requireStillNow(world, epoch, frame);
            LockSupport.parkNanos(200_000_000);
        }
    }

    private void requireStillNow(String world, long epoch, long frame) throws IOException {
        PostgresStore.World now = stored(world);
        assertThat(now.epoch()).as("no server takes %s", now).isEqualTo(epoch);
        assertThat(now.frame()).as("the time of %s stands still", now).isEqualTo(frame);
    }

    private static long engines(Node node) {
        return node.server().process().descendants().count();
    }

    /**
     * Waits until a node has ended the engines of its worlds. One engine stays, which is ready for
     * the next world.
     */
    private static void awaitNoWorldsEngine(Node node) {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(300);
        while (engines(node) > 1) {
            assertThat(System.nanoTime()).as("an engine still runs").isLessThan(end);
            LockSupport.parkNanos(100_000_000);
        }
    }

    private static JsonNode status(Node node) throws Exception {
        Outcome told =
                Reve.run("cluster", "status", "--port", Integer.toString(node.agents()), "--json");
        assertThat(told.code()).as(told.err()).isZero();
        return new JsonMapper().readTree(told.out());
    }

    /** Asks a node until it knows whether a world sleeps; it reads the database once a second. */
    private static void awaitKnown(Node node, String world, boolean isAsleep) throws Exception {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(300);
        while (isAsleep(status(node), world) != isAsleep) {
            assertThat(System.nanoTime()).as(world).isLessThan(end);
        }
    }

    private static boolean isAsleep(JsonNode state, String world) {
        return state.path("worlds")
                .valueStream()
                .filter(each -> each.path("world").asString().equals(world))
                .findFirst()
                .orElseThrow()
                .path("asleep")
                .asBoolean();
    }

    /**
     * A world runs while an observer is connected, then sleeps, and wakes for an agent at another
     * node, with the state that it had. It sleeps again, its node is killed, and it wakes on the
     * node that is left, with the change that the agent made.
     */
    @Test
    void aWorldWithoutClientsSleepsUntilAClientAsksForIt() throws Exception {
        Node first = node(world("w1").toString());
        long epoch = 1;
        try (AgentClient watcher = watch(first, "w1")) {
            long joined = watcher.welcome().frame();
            first.ready("w1", epoch);
            long frame = joined;
            while (frame < joined + 3L * SLEEP_AFTER_SECONDS * RATE) {
                frame = watcher.perceive().frame();
            }
            assertThat(engines(first)).as("that of the world and spare ones").isGreaterThan(1);
        }
        long slept = first.asleep("w1", epoch).path("frame").asLong();
        awaitKnown(first, "w1", true); // asks the node, which wakes no world
        requireStill("w1", epoch, slept);
        awaitNoWorldsEngine(first);
        assertThat(first.server().process().isAlive()).isTrue();
        assertThat(postgres.query(DATABASE, "SELECT world, epoch FROM reve.asleep"))
                .containsExactly("w1,1");

        Node second = node("--seed", first.address());
        first.server()
                .events()
                .await(
                        "cluster",
                        event ->
                                event.path("status").asString().equals("up")
                                        && event.path("node").asString().equals(second.address()));
        requireStill("w1", epoch, slept);
        epoch = 2;
        Node owner;
        long left;
        try (AgentClient agent = join(second, Join.as("ada"), "w1")) {
            PostgresStore.World awake = stored("w1");
            assertThat(awake.epoch()).isEqualTo(epoch);
            owner = awake.agents().endsWith(":" + first.agents()) ? first : second;
            JsonNode ready = owner.ready("w1", epoch);
            assertThat(ready.path("frame").asLong()).isEqualTo(slept);
            assertThat(ready.path("stateHash").asString()).isEqualTo(undisturbedHash("w1", slept));
            assertThat(agent.act("red", "paint", Map.of("colour", "#00ff00")).accepted()).isTrue();
            left = System.nanoTime();
        }
        long sleptAgain = owner.asleep("w1", epoch).path("frame").asLong();
        assertThat(System.nanoTime() - left)
                .isGreaterThanOrEqualTo(TimeUnit.SECONDS.toNanos(SLEEP_AFTER_SECONDS));
        assertThat(sleptAgain).isGreaterThan(slept);
        awaitNoWorldsEngine(owner);

        Node other = owner == first ? second : first;
        owner.server().close();
        requireStill("w1", epoch, sleptAgain);
        assertThat(other.server().process().isAlive()).isTrue();
        epoch = 3;
        try (AgentClient watcher = watch(other, "w1")) {
            assertThat(other.ready("w1", epoch).path("frame").asLong()).isEqualTo(sleptAgain);
            assertThat(watcher.perceive().find("red").orElseThrow().symbols())
                    .as("the symbol that the agent's act has set")
                    .containsEntry("painted", true);
            assertThat(watcher.perceive().find("ada")).as("the body of the agent").isEmpty();
        }
    }

    /** A world is added asleep, so it makes its first frame for its first client. */
    @Test
    void aWorldMayBeginAsleep() throws Exception {
        Node node = node(world("w1").toString());
        String[] command = {
            "cluster", "add-world", world("w2").toString(), "--store", url, "--asleep", "--json"
        };
        Outcome added = Reve.run(command);
        assertThat(added.code()).as(added.err()).isZero();
        JsonNode result = new JsonMapper().readTree(added.out());
        assertThat(result.path("world").asString()).isEqualTo("w2");
        assertThat(result.path("asleep").asBoolean()).isTrue();
        assertThat(Reve.run(command).err()).contains("has a world 'w2' already");
        Outcome several =
                Reve.run(
                        "cluster",
                        "add-world",
                        world("w3").toString(),
                        world("w2").toString(),
                        world("w4").toString(),
                        "--store",
                        url,
                        "--asleep");
        assertThat(several.code()).as("w2 is taken").isEqualTo(1);
        assertThat(several.err()).contains("has a world 'w2' already, which was not changed");
        assertThat(several.out())
                .contains("world w3: added to " + url + ", sleeps until", "world w4: added to ")
                .doesNotContain("w2");
        node.ready("w1", 1);
        requireStill("w2", 0, -1);
        requireStillNow("w3", 0, -1);
        requireStillNow("w4", 0, -1);
        awaitKnown(node, "w2", true);
        try (AgentClient _ = watch(node, "w1")) { // awake, because operators ask through it
            operatorsAddWorldsThroughANode(node);
        }
        Outcome text = Reve.run("cluster", "status", "--port", Integer.toString(node.agents()));
        assertThat(text.out()).contains("world w2: frame -1, epoch 0, asleep");
        try (AgentClient agent = join(node, Join.as("ada"), "w2")) {
            assertThat(node.ready("w2", 1).path("frame").asLong()).isZero();
            assertThat(agent.perceive().find("ada")).isPresent();
            awaitKnown(node, "w2", false);
        }
        assertThat(node.asleep("w2", 1).path("frame").asLong()).isPositive();
    }

    /** Adds worlds with {@code control} and with the client in Python. */
    private void operatorsAddWorldsThroughANode(Node node) throws Exception {
        String port = Integer.toString(node.agents());
        List<String> control =
                List.of("control", "add-world", "--port", port, "--world", "w1", "--json");
        List<String> added = new ArrayList<>(control);
        added.addAll(List.of("file=" + world("w5"), "asleep=true"));
        Outcome first = Reve.run(added.toArray(String[]::new));
        assertThat(first.code()).as(first.err()).isZero();
        assertThat(new JsonMapper().readTree(first.out()).at("/value/world").asString())
                .isEqualTo("w5");
        requireStillNow("w5", 0, -1);
        Outcome again = Reve.run(added.toArray(String[]::new));
        assertThat(again.code()).isEqualTo(1);
        assertThat(again.out()).contains("world-exists", "has a world 'w5' already");
        List<String> wrong = new ArrayList<>(control);
        wrong.addAll(List.of("text=reve: 1\nname: w6\nlaws: []\nitems: [{nmae: ball}]\n"));
        Outcome refused = Reve.run(wrong.toArray(String[]::new));
        assertThat(refused.code()).isEqualTo(1);
        assertThat(refused.out()).contains("bad-world", "world.yaml:4");
        List<String> large = new ArrayList<>(control);
        large.add("text=reve: 1\nname: w6\nitems: [{name: 'a{i}', repeat: 10001}]\n");
        assertThat(Reve.run(large.toArray(String[]::new)).out())
                .contains(
                        "bad-world", "more than 10000 items with their repetitions in one message");
        Outcome python =
                Reve.run(
                        List.of(
                                "env",
                                "PYTHONPATH=" + Project.ROOT.resolve("agents/python"),
                                "python3",
                                "-c",
                                """
                                import asyncio, reve, reve.aio, sys
                                port, text = int(sys.argv[1]), open(sys.argv[2]).read()
                                with reve.control(port=port, world="w1") as control:
                                    print(control.add_world(text).value["world"])
                                with reve.connect(port=port, name="ada", world="w7", timeout=60) as ada:
                                    print(ada.perceive().frame > 0)
                                print(reve.cluster(port=port).value["cluster"])
                                also = asyncio.run(reve.aio.cluster(port=port))
                                print(len(also.value["nodes"]) > 0)
                                """,
                                port,
                                world("w7").toString()));
        assertThat(python.code()).as(python.err()).isZero();
        assertThat(python.out()).isEqualTo("w7\nTrue\nlab\nTrue\n");
    }

    @Test
    void timesThatDoNotFitAreRefused() throws Exception {
        String nowhere = "postgresql://reve@127.0.0.1:1/worlds";
        Outcome alone =
                Reve.run(
                        "serve",
                        Project.WORLDS.resolve("spring-orbit").toString(),
                        "--sleep-after",
                        "9");
        assertThat(alone.code()).isEqualTo(2);
        assertThat(alone.err()).contains("--sleep-after takes --cluster NAME");
        for (String time : List.of("0.5", "-1", "1e9")) {
            Outcome refused =
                    Reve.run(
                            "serve", "--cluster", "lab", "--store", nowhere, "--sleep-after", time);
            assertThat(refused.code()).as(time).isEqualTo(2);
            assertThat(refused.err()).contains("--sleep-after is ", "expected 1 to 2592000 s");
        }
        Outcome noNumber =
                Reve.run("serve", "--cluster", "lab", "--store", nowhere, "--sleep-after", "NaN");
        assertThat(noNumber.code()).isEqualTo(2);
        assertThat(noNumber.err())
                .contains("'--sleep-after': found 'NaN', expected a finite number");
    }
}
