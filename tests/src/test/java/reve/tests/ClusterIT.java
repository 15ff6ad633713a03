// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.jspecify.annotations.Nullable;
import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.DisconnectedException;
import reve.agent.Join;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.TreeMap;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Predicate;
import java.util.stream.Collectors;

/** Nodes of a cluster, each a process of its own, which share the worlds of a database. */
@Tag("slow")
class ClusterIT {
    private static final int NODES = 3;
    private static final int RATE = 20;
    private static final long PATIENCE_SECONDS = 90;
    private static final List<String> WORLDS = List.of("w1", "w2", "w3", "w4", "w5", "w6");
    private static final long SEED = Long.getLong("reve.test.seed", 20261129);

    /** 100 in a long run. */
    private static final int KILLS = Integer.getInteger("reve.test.cluster.kills", 1);

    private static Postgres postgres;
    private static int databases;

    @TempDir private Path folder;
    private final List<Node> nodes = new ArrayList<>();
    private String url;
    private int started;
    private @Nullable NodeCertificates certificates;

    /**
     * @param address where other nodes reach it
     * @param agents where agents reach it
     */
    private record Node(Server server, String address, String agents) {
        JsonNode ready(String world, long epoch) throws IOException {
            return server.events()
                    .await(
                            "ready",
                            event ->
                                    event.path("world").asString().equals(world)
                                            && event.path("epoch").asLong() == epoch);
        }

        JsonNode cluster(String status, String other) throws IOException {
            return server.events()
                    .await(
                            "cluster",
                            event ->
                                    event.path("status").asString().equals(status)
                                            && event.path("node").asString().equals(other));
        }
    }

    @BeforeAll
    static void start() throws Exception {
        postgres = new Postgres();
    }

    @AfterAll
    static void stop() throws Exception {
        postgres.close();
    }

    @AfterEach
    void endNodes() {
        nodes.forEach(node -> node.server().close());
    }

    private void database() throws Exception {
        url = postgres.create("cluster" + ++databases);
    }

    private Server launch(String... more) throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of("serve", "--cluster", "lab", "--port", "0", "--json", "--store"));
        arguments.add(url);
        if (certificates != null) {
            arguments.addAll(certificates.options("node" + (started + 1), "127.0.0.1"));
        }
        arguments.addAll(List.of(more));
        return Server.start(
                Files.createDirectory(folder.resolve("node" + ++started)),
                arguments.toArray(String[]::new));
    }

    /** Waits until a node listens. Its events are read from now on. */
    private Node node(Server server) throws IOException {
        JsonNode starts =
                server.events()
                        .await(
                                "cluster",
                                event -> event.path("status").asString().equals("starts"));
        Node node =
                new Node(server, starts.path("node").asString(), starts.path("agents").asString());
        nodes.add(node);
        return node;
    }

    /** Starts nodes through a first one; the last of them adds the worlds. */
    private void startCluster(int count, List<String> worlds) throws IOException {
        Node first = node(launch());
        List<Server> others = new ArrayList<>();
        for (int i = 2; i <= count; i++) {
            List<String> more = new ArrayList<>(List.of("--seed", first.address()));
            if (i == count) {
                for (String world : worlds) {
                    more.add(world(world).toString());
                }
            }
            others.add(launch(more.toArray(String[]::new)));
        }
        for (Server other : others) {
            node(other);
        }
        for (Node node : nodes) {
            first.cluster("up", node.address());
        }
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

    private Map<String, PostgresStore.World> worlds() throws IOException {
        Map<String, PostgresStore.World> worlds = new TreeMap<>();
        for (PostgresStore.World world :
                PostgresStore.worlds(PostgresUrl.find(url).orElseThrow())) {
            worlds.put(world.name(), world);
        }
        return worlds;
    }

    /** Waits until all worlds run and meet a condition. */
    private Map<String, PostgresStore.World> awaitAll(
            List<String> names, Predicate<PostgresStore.World> wanted) throws IOException {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (true) {
            Map<String, PostgresStore.World> now = worlds();
            if (now.keySet().containsAll(names)
                    && names.stream()
                            .map(now::get)
                            .allMatch(world -> !world.agents().isEmpty() && wanted.test(world))) {
                return now;
            }
            if (System.nanoTime() > end) {
                StringBuilder errors = new StringBuilder();
                for (int i = 1; i <= started; i++) {
                    errors.append(Files.readString(folder.resolve("node" + i + "/server.err")));
                }
                throw new AssertionError("the worlds do not run: " + now + "\n" + errors);
            }
            LockSupport.parkNanos(100_000_000);
        }
    }

    private Node ownerOf(PostgresStore.World world) {
        return nodes.stream()
                .filter(node -> node.agents().equals(world.agents()))
                .findFirst()
                .orElseThrow(() -> new AssertionError(world + " is at none of " + nodes));
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
     * A node is killed, first the oldest, which places the worlds; then others at random. All its
     * worlds run on the other nodes, from the last frame that the database had, with the state of a
     * world that was never disturbed. Then worlds move as operators order, and a node ends
     * regularly, and hands its worlds over.
     */
    @Test
    void theWorldsOfALostNodeRunOnTheOthers() throws Exception {
        database();
        Random random = new Random(SEED);
        certificates = new NodeCertificates(folder);
        startCluster(NODES, WORLDS);
        awaitBalance();
        eachNodeSendsAgentsToAllWorlds();
        eachNodeKnowsAllNodesAndWorlds();
        for (int kill = 1; kill <= KILLS; kill++) {
            String which = "kill " + kill + " of seed " + SEED;
            Map<String, PostgresStore.World> before = worlds();
            Node victim = kill == 1 ? nodes.getFirst() : nodes.get(random.nextInt(nodes.size()));
            List<String> lost =
                    WORLDS.stream().filter(world -> ownerOf(before.get(world)) == victim).toList();
            assertThat(lost).as(which).hasSize(WORLDS.size() / NODES);
            victim.server().process().destroyForcibly().onExit().join();
            nodes.remove(victim);
            Map<String, PostgresStore.World> after =
                    awaitAll(
                            lost,
                            world ->
                                    world.epoch() > before.get(world.name()).epoch()
                                            && world.isOwned());
            for (String world : lost) {
                PostgresStore.World old = before.get(world);
                PostgresStore.World now = after.get(world);
                assertThat(now.epoch()).as(which).isEqualTo(old.epoch() + 1);
                JsonNode ready = ownerOf(now).ready(world, now.epoch());
                long frame = ready.path("frame").asLong();
                assertThat(frame).as(which).isGreaterThanOrEqualTo(old.frame());
                assertThat(ready.path("stateHash").asString())
                        .as("%s, %s at frame %s", which, world, frame)
                        .isEqualTo(undisturbedHash(world, frame));
            }
            for (String world : WORLDS) {
                if (!lost.contains(world)) {
                    assertThat(after.get(world).epoch())
                            .as("%s does not touch %s", which, world)
                            .isEqualTo(before.get(world).epoch());
                }
            }
            nodes.getFirst().cluster("lost", victim.address());
            if (kill < KILLS) {
                Node next = node(launch("--seed", nodes.getFirst().address()));
                nodes.getFirst().cluster("up", next.address());
                awaitBalance();
            }
        }
        try (AgentClient resident = movesWorldsAsOrdered()) {
            handsItsWorldsOver(resident);
        }
    }

    /**
     * One of two nodes gets a world of the other one, is then drained of all worlds, and may run
     * worlds again. Each time, worlds continue with the state of a world that never moved. Returns
     * an agent whose world has moved, and whose session continues.
     */
    private AgentClient movesWorldsAsOrdered() throws Exception {
        Node first = nodes.getFirst();
        Node last = nodes.getLast();
        Map<String, PostgresStore.World> before = worlds();
        String moved =
                WORLDS.stream()
                        .filter(world -> ownerOf(before.get(world)) == first)
                        .findFirst()
                        .orElseThrow();
        try (AgentClient watcher = watch(first, moved)) {
            JsonNode order = cluster("move", moved, last.address());
            assertThat(order.path("world").asString()).isEqualTo(moved);
            assertThat(order.path("from").asString()).isEqualTo(first.address());
            assertThat(order.path("to").asString()).isEqualTo(last.address());
            assertThat(order.path("agents").asString()).isEqualTo(last.agents());
            requireUndisturbed(before, Map.of(moved, last));
            assertThatExceptionOfType(DisconnectedException.class)
                    .isThrownBy(watcher::perceive)
                    .satisfies(
                            bye -> {
                                assertThat(bye.code()).isEqualTo("moved");
                                assertThat(bye.address().orElseThrow().getPort())
                                        .isEqualTo(Integer.parseInt(last.agents().split(":")[1]));
                            });
        }
        watch(first, moved).close();
        Map<String, PostgresStore.World> between = awaitAll(WORLDS, PostgresStore.World::isOwned);
        List<String> own =
                WORLDS.stream().filter(world -> ownerOf(between.get(world)) == last).toList();
        String home = own.stream().filter(world -> !world.equals(moved)).findFirst().orElseThrow();
        AgentClient resident = resident(first, home);
        JsonNode drain = cluster("drain", last.address());
        // The cluster may have moved another world meanwhile, so that each node has its share.
        assertThat(drain.path("worlds").valueStream().map(JsonNode::asString))
                .contains(moved)
                .isSubsetOf(own);
        Map<String, Node> places = new TreeMap<>();
        own.forEach(world -> places.put(world, first));
        places.remove(home);
        requireUndisturbed(between, places);
        requireAtHome(resident);
        assertThat(drain.path("to").propertyStream().map(to -> to.getValue().asString()))
                .containsOnly(first.address());
        JsonNode state = cluster("status");
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (worldsOf(state, first) < WORLDS.size() && System.nanoTime() - end < 0) {
            LockSupport.parkNanos(100_000_000);
            state = cluster("status");
        }
        for (JsonNode node : state.path("nodes")) {
            boolean isDrained = node.path("node").asString().equals(last.address());
            assertThat(node.path("drained").asBoolean()).isEqualTo(isDrained);
            assertThat(node.path("worlds").asInt()).isEqualTo(isDrained ? 0 : WORLDS.size());
        }
        for (JsonNode world : state.path("worlds")) {
            assertThat(world.path("ordered").asString(""))
                    .isEqualTo(world.path("world").asString().equals(moved) ? last.address() : "");
        }
        ordersThatCannotBeFollowedAreRefused(moved, first, last);
        Map<String, PostgresStore.World> drained = worlds();
        cluster("drain", last.address(), "--end");
        awaitAll(List.of(moved), world -> world.agents().equals(last.agents()));
        requireUndisturbed(drained, Map.of(moved, last));
        assertThat(cluster("move", moved, "any").path("to").asString()).isEqualTo("any");
        assertThat(postgres.query("cluster" + databases, "SELECT * FROM reve.place")).isEmpty();
        addsAWorld();
        return resident;
    }

    /** A world that is added while the cluster runs is run by a node, and is added once only. */
    private void addsAWorld() throws Exception {
        String[] command = {"cluster", "add-world", world("w7").toString(), "--store", url};
        Outcome added = Reve.run(command);
        assertThat(added.code()).as(added.err()).isZero();
        PostgresStore.World runs = awaitAll(List.of("w7"), world -> world.frame() > 0).get("w7");
        assertThat(added.out()).startsWith("world w7: runs, agents at 127.0.0.1:");
        assertThat(ownerOf(runs).ready("w7", 1).path("frame").asLong()).isZero();
        Outcome again = Reve.run(command);
        assertThat(again.code()).isEqualTo(1);
        assertThat(again.err())
                .contains(
                        url + " has a world 'w7' already, which was not changed",
                        "Its worlds are w1, w2, w3, w4, w5, w6, w7; give the world in ");
        assertThat(worlds().get("w7").frame()).isGreaterThanOrEqualTo(runs.frame());
    }

    private static int worldsOf(JsonNode state, Node node) {
        return state.path("nodes")
                .valueStream()
                .filter(each -> each.path("node").asString().equals(node.address()))
                .mapToInt(each -> each.path("worlds").asInt())
                .sum();
    }

    /** Joins a world with a grace, through a node that sends the agent on. */
    private AgentClient resident(Node node, String world) throws IOException {
        String[] at = node.agents().split(":");
        AgentClient resident =
                Agents.join(
                        at[0],
                        Integer.parseInt(at[1]),
                        Join.as("resident").withWorld(world).withGrace(Duration.ofSeconds(60)));
        requireAtHome(resident);
        return resident;
    }

    /** Requires that an agent still has the body with which it joined. */
    private static void requireAtHome(AgentClient resident) {
        assertThat(resident.perceive().find("resident")).isPresent();
        assertThat(resident.act("red", "paint", Map.of("colour", "#00ff00")).accepted()).isTrue();
        assertThat(resident.events()).noneMatch(event -> event.type().equals("left"));
    }

    /** Requires that worlds began one later epoch on these nodes, as if they had never moved. */
    private void requireUndisturbed(
            Map<String, PostgresStore.World> before, Map<String, Node> places) throws Exception {
        for (Map.Entry<String, Node> place : places.entrySet()) {
            String world = place.getKey();
            JsonNode ready = place.getValue().ready(world, before.get(world).epoch() + 1);
            long frame = ready.path("frame").asLong();
            assertThat(frame).as(world).isGreaterThanOrEqualTo(before.get(world).frame());
            assertThat(ready.path("stateHash").asString())
                    .as("%s at frame %s", world, frame)
                    .isEqualTo(undisturbedHash(world, frame));
        }
    }

    private void ordersThatCannotBeFollowedAreRefused(String world, Node up, Node drained)
            throws Exception {
        assertThat(refusal("move", world, drained.address()))
                .contains(
                        "node-drained: the node " + drained.address() + " is drained",
                        "cluster drain " + drained.address() + " --end");
        assertThat(refusal("drain", up.address()))
                .contains("last-node: no other node than " + up.address() + " can run worlds");
        assertThat(refusal("move", world, "127.0.0.1:1"))
                .contains("no-such-node: the cluster has no node '127.0.0.1:1', expected one of ")
                .contains(up.address(), drained.address());
        assertThat(refusal("move", "w0", up.address(), "--world", world))
                .contains("no-such-world: the cluster has no world 'w0', expected one of w1, w2");
    }

    /** Returns the message of an order that a node refuses. */
    private String refusal(String... arguments) throws Exception {
        Outcome refused = Reve.run(toFirst(arguments));
        assertThat(refused.code()).as(refused.out()).isEqualTo(1);
        return refused.err();
    }

    /** Runs a command {@code cluster} with the first node, and returns its result. */
    private JsonNode cluster(String... arguments) throws Exception {
        Outcome outcome = Reve.run(toFirst(arguments));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private String[] toFirst(String... arguments) {
        List<String> command = new ArrayList<>(List.of("cluster"));
        command.addAll(List.of(arguments));
        command.addAll(List.of("--json", "--port", nodes.getFirst().agents().split(":")[1]));
        return command.toArray(String[]::new);
    }

    private static AgentClient watch(Node node, String world) throws IOException {
        String[] at = node.agents().split(":");
        return Agents.join(
                at[0],
                Integer.parseInt(at[1]),
                Join.as("watcher").withRole("observer").withWorld(world));
    }

    /** Waits until each node has its share of the worlds; a new node begins with none. */
    private void awaitBalance() throws IOException {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (true) {
            Map<String, Long> shares =
                    awaitAll(WORLDS, world -> world.isOwned() && world.frame() > 0)
                            .values()
                            .stream()
                            .collect(
                                    Collectors.groupingBy(
                                            PostgresStore.World::agents, Collectors.counting()));
            if (shares.size() == NODES
                    && shares.values().stream().allMatch(share -> share == WORLDS.size() / NODES)) {
                return;
            }
            if (System.nanoTime() > end) {
                throw new AssertionError("the nodes have these numbers of worlds: " + shares);
            }
            LockSupport.parkNanos(100_000_000);
        }
    }

    /** Asks until the node knows that all have their shares; it reads them once a second. */
    private static JsonNode awaitShares(String port) throws Exception {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (true) {
            Outcome told = Reve.run("cluster", "status", "--port", port, "--json");
            assertThat(told.code()).as(told.err()).isZero();
            JsonNode state = new JsonMapper().readTree(told.out());
            boolean isShared = true;
            for (JsonNode node : state.path("nodes")) {
                isShared &= node.path("worlds").asInt() == WORLDS.size() / NODES;
            }
            if (isShared || System.nanoTime() > end) {
                return state;
            }
        }
    }

    /** The state as one node tells it equals the one that this test knows. */
    private void eachNodeKnowsAllNodesAndWorlds() throws Exception {
        Node asked = nodes.getLast();
        String port = asked.agents().split(":")[1];
        JsonNode state = awaitShares(port);
        assertThat(state.path("cluster").asString()).isEqualTo("lab");
        Map<String, String> agents = new TreeMap<>();
        for (JsonNode node : state.path("nodes")) {
            assertThat(node.path("status").asString()).isEqualTo("up");
            assertThat(node.path("worlds").asInt()).isEqualTo(WORLDS.size() / NODES);
            agents.put(node.path("node").asString(), node.path("agents").asString());
        }
        assertThat(agents)
                .isEqualTo(nodes.stream().collect(Collectors.toMap(Node::address, Node::agents)));
        Map<String, PostgresStore.World> known = worlds();
        assertThat(state.path("worlds")).hasSize(WORLDS.size());
        for (JsonNode world : state.path("worlds")) {
            PostgresStore.World stored = known.get(world.path("world").asString());
            assertThat(world.path("node").asString()).isEqualTo(ownerOf(stored).address());
            assertThat(world.path("epoch").asLong()).isEqualTo(stored.epoch());
        }
        Outcome text = Reve.run("cluster", "status", "--port", port);
        assertThat(text.out())
                .contains("node " + asked.address() + ": up, worlds: 2", "world w1: frame ");
    }

    /** Observers change nothing, so the worlds stay undisturbed. */
    private void eachNodeSendsAgentsToAllWorlds() throws IOException {
        for (Node node : nodes) {
            for (String world : WORLDS) {
                try (AgentClient client = watch(node, world)) {
                    assertThat(client.welcome().world()).isEqualTo(world);
                }
            }
        }
    }

    private void handsItsWorldsOver(AgentClient resident) throws Exception {
        Node leaves = nodes.getFirst();
        Node stays = nodes.getLast();
        Map<String, PostgresStore.World> before = worlds();
        leaves.server().process().toHandle().destroy();
        assertThat(leaves.server().exitCode()).isZero();
        assertThat(leaves.server().events().untilEnd())
                .noneMatch(Server::isFault)
                .last()
                .satisfies(end -> assertThat(end.path("event").asString()).isEqualTo("end"));
        awaitAll(WORLDS, world -> world.agents().equals(stays.agents()));
        requireAtHome(resident);
        String acted = WORLDS.getFirst();
        String[] at = stays.agents().split(":");
        try (AgentClient agent =
                Agents.join(at[0], Integer.parseInt(at[1]), Join.as("ada").withWorld(acted))) {
            assertThat(agent.act("red", "paint", Map.of("colour", "#00ff00")).accepted()).isTrue();
        }
        stays.server().process().toHandle().destroy();
        JsonNode end = stays.server().events().await("end", event -> true);
        assertThat(stays.server().exitCode()).isZero();
        Map<String, String> hashes = new HashMap<>();
        for (JsonNode report : end.path("worlds")) {
            hashes.put(report.path("world").asString(), report.path("stateHash").asString());
        }
        for (String world : List.of(acted, WORLDS.getLast())) {
            Outcome checked = Reve.run("store", "check", url, "--world", world, "--json");
            assertThat(checked.code()).as(checked.out() + checked.err()).isZero();
            JsonNode store = new JsonMapper().readTree(checked.out());
            assertThat(hashes.get(world)).isEqualTo(store.path("stateHash").asString());
            assertThat(store.path("frame").asLong())
                    .isGreaterThanOrEqualTo(before.get(world).frame());
        }
    }

    @Test
    void aNodeReportsThatNoSeedLetsItIn() throws Exception {
        database();
        Server server = launch("--seed", "127.0.0.1:1");
        node(server);
        JsonNode fault = server.events().await("fault", _ -> true);
        assertThat(fault.path("source").asString()).isEqualTo("cluster");
        assertThat(fault.path("message").asString())
                .contains("has not joined the cluster lab for 10 s", "no seed (127.0.0.1:1)");
        server.process().toHandle().destroy();
        assertThat(server.exitCode()).isZero();
    }

    @Test
    void optionsThatDoNotFitAreRefused() throws Exception {
        String world = Project.WORLDS.resolve("spring-orbit").toString();
        Outcome soon = Reve.run("cluster", "move", "w1", "127.0.0.1:1", "--timeout", "-1");
        assertThat(soon.code()).isEqualTo(2);
        assertThat(soon.err()).contains("--timeout is -1, expected 0 to 86400 seconds");
        Outcome noDatabase = Reve.run("cluster", "add-world", world, "--store", "my.db");
        assertThat(noDatabase.code()).isEqualTo(2);
        assertThat(noDatabase.err())
                .contains("--store is my.db, expected the URL of the cluster's");
        Outcome half = Reve.run("cluster", "move", "w1");
        assertThat(half.code()).isEqualTo(2);
        assertThat(half.err()).contains("Missing required parameter: 'NODE'");
        String nowhere = "postgresql://reve@127.0.0.1:1/worlds";
        Outcome file = Reve.run("serve", world, "--cluster", "lab", "--store", "my.db");
        assertThat(file.code()).isEqualTo(2);
        assertThat(file.err()).contains("--cluster takes --store postgresql://", "my.db");
        Outcome alone = Reve.run("serve", world, "--seed", "127.0.0.1:2551");
        assertThat(alone.code()).isEqualTo(2);
        assertThat(alone.err()).contains("--seed takes --cluster NAME");
        Outcome name = Reve.run("serve", "--cluster", "my lab", "--store", nowhere);
        assertThat(name.code()).isEqualTo(2);
        assertThat(name.err()).contains("the cluster is called 'my lab'", "expected 1 to 64 of");
        Outcome seed = Reve.run("serve", "--cluster", "lab", "--store", nowhere, "--seed", "here");
        assertThat(seed.code()).isEqualTo(2);
        assertThat(seed.err()).contains("--seed: found 'here', expected HOST:PORT");
        Outcome standby = Reve.run("serve", "--cluster", "lab", "--store", nowhere, "--standby");
        assertThat(standby.code()).isEqualTo(2);
        assertThat(standby.err()).contains("--standby is for a server whose worlds are known");
        Outcome record =
                Reve.run("serve", "--cluster", "lab", "--store", nowhere, "--record", "a.log");
        assertThat(record.code()).isEqualTo(2);
        assertThat(record.err())
                .contains("--record is for a server whose worlds", "replay WORLD --store URL");
        Outcome open =
                Reve.run(
                        "serve",
                        "--cluster",
                        "lab",
                        "--store",
                        nowhere,
                        "--cluster-listen",
                        "0.0.0.0:0");
        assertThat(open.code()).isEqualTo(2);
        assertThat(open.err()).contains("--cluster-listen 0.0.0.0:0 stands for all addresses");
        Outcome plain =
                Reve.run(
                        "serve",
                        "--cluster",
                        "lab",
                        "--store",
                        nowhere,
                        "--cluster-listen",
                        "192.0.2.1:2551");
        assertThat(plain.code()).isEqualTo(5);
        assertThat(plain.err())
                .contains(
                        "--cluster-listen 192.0.2.1:2551: other machines reach it, so nodes take"
                                + " TLS there");
        Outcome some =
                Reve.run("serve", "--cluster", "lab", "--store", nowhere, "--cluster-ca", "ca.crt");
        assertThat(some.code()).isEqualTo(2);
        assertThat(some.err()).contains("--cluster-key and --cluster-ca belong together");
        Outcome away = Reve.run("serve", "--cluster", "lab", "--store", nowhere, "--port", "0");
        assertThat(away.code()).isEqualTo(1);
        assertThat(away.err()).contains(nowhere + " could not be opened: ");
    }
}
