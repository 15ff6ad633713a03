// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.jspecify.annotations.Nullable;

import reve.agent.Join;
import reve.agent.Trust;
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
import java.util.Collection;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Predicate;

/**
 * A cluster for tests of faults: each node is a process in a place of its own, and may be started
 * again there. Triggers in the database record each frame and image when it is committed.
 */
final class FaultCluster implements AutoCloseable {
    static final int RATE = 20;
    private static final long PATIENCE_SECONDS = 120;
    private static final Duration GRACE = Duration.ofSeconds(60);
    private static final String HEAP = "256m";
    private static final int AGENTS_PORT = 7777;
    private static final int NODES_PORT = 2551;

    /**
     * Records what is committed. The triggers run at the commit, when the transaction has locked
     * the row of the world. The order of the record is therefore that of the commits of a world.
     */
    private static final String RECORD =
            """
            CREATE TABLE written (number bigserial PRIMARY KEY, kind text, world text,
                epoch bigint, owned bigint, frame bigint, peer text);
            CREATE FUNCTION note_write() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
                INSERT INTO written (kind, world, epoch, owned, frame, peer) VALUES (TG_TABLE_NAME,
                    NEW.world, NEW.epoch, (SELECT epoch FROM reve.world WHERE name = NEW.world),
                    NEW.frame, host(inet_client_addr()));
                RETURN NULL;
            END $$;
            CREATE CONSTRAINT TRIGGER written_frame AFTER INSERT ON reve.frame
                DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION note_write();
            CREATE CONSTRAINT TRIGGER written_image AFTER INSERT ON reve.image
                DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION note_write();
            """;

    private final Path folder;
    private final Postgres postgres;
    private final String database;
    private final String url;
    private final List<String> worlds;
    private final List<Place> places = new ArrayList<>();
    private final Map<Place, Node> nodes = new HashMap<>();
    private final List<Server> servers = new ArrayList<>();
    private @Nullable NodeCertificates certificates;
    private Map<String, String> changed = Map.of();
    private int started;

    /** Where a node runs. */
    static final class Place {
        private final Optional<Network.Member> member;

        /** Port for agents; 0 until a first node has selected one. */
        private int port;

        private Place(Optional<Network.Member> member) {
            this.member = member;
            this.port = member.isPresent() ? AGENTS_PORT : 0;
        }

        Network.Member member() {
            return member.orElseThrow();
        }

        private String host() {
            return member.map(Network.Member::address).orElse("127.0.0.1");
        }
    }

    /**
     * @param address where other nodes reach it
     * @param agents where agents reach it
     */
    record Node(Place place, Server server, String address, String agents) {
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

        boolean isAlive() {
            return server.process().isAlive();
        }
    }

    /**
     * Starts a cluster of processes, and waits until all worlds run.
     *
     * @param folder an empty folder
     * @param members the place of each node; none for a node on loopback, with neither TLS nor
     *     tokens
     */
    FaultCluster(
            Path folder,
            Postgres postgres,
            String database,
            List<Optional<Network.Member>> members,
            List<String> worlds,
            List<String> agents)
            throws Exception {
        this.folder = folder;
        this.postgres = postgres;
        this.database = database;
        this.url = postgres.create(database);
        this.worlds = worlds;
        members.forEach(member -> places.add(new Place(member)));
        if (members.getFirst().isPresent()) {
            certificates = new NodeCertificates(folder);
            makeTokens(agents);
        }
        try {
            Place oldest = places.getFirst();
            Node first =
                    await(
                            oldest,
                            launch(
                                    oldest,
                                    List.of(),
                                    oldest == places.getLast() ? worlds : List.of()));
            postgres.execute(database, RECORD);
            List<Server> others = new ArrayList<>();
            for (Place place : places.subList(1, places.size())) {
                others.add(
                        launch(
                                place,
                                List.of(first.address()),
                                place == places.getLast() ? worlds : List.of()));
            }
            for (int i = 0; i < others.size(); i++) {
                await(places.get(i + 1), others.get(i));
            }
            awaitUp();
            awaitBalance();
        } catch (Exception | Error failed) {
            close();
            throw failed;
        }
    }

    private void makeTokens(List<String> agents) throws Exception {
        for (String agent : agents) {
            Outcome made =
                    Reve.run(
                            "token",
                            "new",
                            agent,
                            "--file",
                            file("tokens.json"),
                            "--out",
                            file(agent + ".token"));
            assertThat(made.code()).as(made.err()).isZero();
        }
    }

    private String file(String name) {
        return folder.resolve(name).toString();
    }

    private Server launch(Place place, Collection<String> seeds, List<String> added)
            throws IOException {
        List<String> arguments =
                new ArrayList<>(List.of("serve", "--cluster", "lab", "--json", "--store", url));
        arguments.addAll(List.of("--port", Integer.toString(place.port)));
        seeds.forEach(seed -> arguments.addAll(List.of("--seed", seed)));
        if (certificates != null) {
            String host = place.host();
            arguments.addAll(List.of("--cluster-listen", host + ":" + NODES_PORT));
            arguments.addAll(certificates.options(host, host));
            arguments.addAll(
                    List.of(
                            "--listen",
                            host,
                            "--tls-certificate",
                            certificates.certificate(host, host).toString(),
                            "--tls-key",
                            certificates.key(host).toString(),
                            "--tokens",
                            file("tokens.json")));
        }
        for (String world : added) {
            arguments.add(world(world).toString());
        }
        return started(place, arguments);
    }

    private Server started(Place place, List<String> arguments) throws IOException {
        Map<String, String> environment = new HashMap<>(changed);
        environment.put("REVE_HEAP", HEAP);
        Server server =
                Server.start(
                        Files.createDirectory(folder.resolve("node" + ++started)),
                        place.member.map(Network.Member::entering).orElse(List.of()),
                        environment,
                        arguments.toArray(String[]::new));
        servers.add(server);
        return server;
    }

    /** Starts a server that belongs to no cluster, with one world of the database. */
    Server alone(Place place, String world) throws IOException {
        return started(
                place,
                List.of(
                        "serve",
                        world,
                        "--store",
                        url,
                        "--port",
                        Integer.toString(place.port),
                        "--json"));
    }

    /** Waits until a node listens. */
    private Node await(Place place, Server server) throws IOException {
        JsonNode starts =
                server.events()
                        .await(
                                "cluster",
                                event -> event.path("status").asString().equals("starts"));
        Node node =
                new Node(
                        place,
                        server,
                        starts.path("node").asString(),
                        starts.path("agents").asString());
        place.port = starts.path("agentPort").asInt();
        nodes.put(place, node);
        return node;
    }

    /** Writes a world of this name: two bodies at 20 frames a second. */
    private Path world(String name) throws IOException {
        Path written = folder.resolve(name + ".yaml");
        String sample = Files.readString(Project.WORLDS.resolve("spring-orbit/world.yaml"));
        Files.writeString(
                written,
                sample.replace("name: spring-orbit", "name: " + name)
                        .replace("rate: 60, steps: 4", "rate: " + RATE + ", steps: 12"));
        return written;
    }

    List<Place> places() {
        return List.copyOf(places);
    }

    /** Returns the nodes that have not ended, in the order of their places. */
    List<Node> alive() {
        return places.stream()
                .map(nodes::get)
                .filter(node -> node != null && node.isAlive())
                .toList();
    }

    Node at(Place place) {
        return nodes.get(place);
    }

    /** Sets variables of the environment of all nodes that are started from now on. */
    void change(Map<String, String> environment) {
        changed = Map.copyOf(environment);
    }

    /** Returns the database, as {@code --store} takes it. */
    String url() {
        return url;
    }

    /** Starts nodes where none is alive. */
    void startMissing() throws IOException {
        for (Place place : places) {
            if (!nodes.get(place).isAlive()) {
                startAt(place);
            }
        }
    }

    /** Starts a node where none is alive, with the other ones as seeds, and waits for it. */
    void startAt(Place place) throws IOException {
        await(place, launch(place, alive().stream().map(Node::address).toList(), List.of()));
        awaitUp();
    }

    private void awaitUp() throws IOException {
        for (Node node : alive()) {
            node.cluster("up", node.address());
        }
    }

    Map<String, PostgresStore.World> worlds() throws IOException {
        Map<String, PostgresStore.World> found = new TreeMap<>();
        for (PostgresStore.World world :
                PostgresStore.worlds(PostgresUrl.find(url).orElseThrow())) {
            found.put(world.name(), world);
        }
        return found;
    }

    /** Returns the node that runs a world; empty if none of those that are alive does. */
    Optional<Node> ownerOf(PostgresStore.World world) {
        return alive().stream().filter(node -> node.agents().equals(world.agents())).findFirst();
    }

    /** A condition of the whole cluster. */
    interface Condition {
        boolean isMet(Map<String, PostgresStore.World> worlds) throws IOException;
    }

    /** Waits for a condition, and returns the worlds that met it. */
    Map<String, PostgresStore.World> await(String what, Condition condition) throws IOException {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (true) {
            Map<String, PostgresStore.World> now = worlds();
            if (condition.isMet(now)) {
                return now;
            }
            if (System.nanoTime() > end) {
                throw new AssertionError(what + " is not so: " + now + "\n" + errors());
            }
            LockSupport.parkNanos(50_000_000);
        }
    }

    private String errors() throws IOException {
        StringBuilder errors = new StringBuilder();
        for (int i = 1; i <= started; i++) {
            errors.append("node").append(i).append(": ");
            errors.append(Files.readString(folder.resolve("node" + i + "/server.err")));
        }
        return errors.toString();
    }

    /** Waits until all worlds run on nodes that are alive, and each has stored a further frame. */
    Map<String, PostgresStore.World> awaitRunning() throws IOException {
        Map<String, PostgresStore.World> before = worlds();
        return await(
                "all worlds run",
                now ->
                        all(
                                now,
                                world ->
                                        world.isOwned()
                                                && ownerOf(world).isPresent()
                                                && world.frame()
                                                        > before.get(world.name()).frame()));
    }

    /** Waits until each node runs its share of the worlds. */
    Map<String, PostgresStore.World> awaitBalance() throws IOException {
        return await(
                "each node has its share",
                now ->
                        all(now, world -> world.isOwned() && world.frame() > 0)
                                && alive().stream()
                                        .allMatch(
                                                node ->
                                                        now.values().stream()
                                                                        .filter(
                                                                                world ->
                                                                                        world.agents()
                                                                                                .equals(
                                                                                                        node
                                                                                                                .agents()))
                                                                        .count()
                                                                == worlds.size() / places.size()));
    }

    private boolean all(
            Map<String, PostgresStore.World> now, Predicate<PostgresStore.World> wanted) {
        return now.keySet().containsAll(worlds) && worlds.stream().map(now::get).allMatch(wanted);
    }

    /** Requires that no world had two writers, and that no write of an older epoch was accepted. */
    void requireOneWriter() throws Exception {
        assertThat(
                        postgres.query(
                                database,
                                "SELECT world, epoch, frame, owned FROM written WHERE epoch <>"
                                        + " owned"))
                .as("writes in an epoch that was not granted to the writer")
                .isEmpty();
        assertThat(
                        postgres.query(
                                database,
                                "SELECT * FROM (SELECT world, number, frame, lag(frame) OVER"
                                        + " in_order, epoch, lag(epoch) OVER in_order AS before"
                                        + " FROM written WINDOW in_order AS (PARTITION BY world"
                                        + " ORDER BY number)) AS each WHERE epoch < before"))
                .as("writes after another server has taken the world")
                .isEmpty();
        assertThat(
                        postgres.query(
                                database,
                                "SELECT * FROM (SELECT world, epoch, frame, lag(frame) OVER"
                                        + " (PARTITION BY world ORDER BY number) AS before FROM"
                                        + " written WHERE kind = 'frame') AS each WHERE frame <="
                                        + " before"))
                .as("frames that were written twice")
                .isEmpty();
        assertThat(
                        postgres.query(
                                database,
                                "SELECT world, epoch FROM written GROUP BY world, epoch HAVING"
                                        + " count(DISTINCT peer) > 1"))
                .as("epochs in which two machines wrote")
                .isEmpty();
        assertThat(postgres.query(database, "SELECT DISTINCT world FROM written ORDER BY world"))
                .as("worlds that were recorded")
                .containsExactlyElementsOf(worlds);
    }

    /** Returns the settings of an agent of a world, which keeps its session for a minute. */
    Join join(String agent, String world) throws IOException {
        Join join =
                Join.as(agent)
                        .withWorld(world)
                        .withGrace(GRACE)
                        .withPatience(Duration.ofSeconds(PATIENCE_SECONDS));
        return certificates == null
                ? join
                : join.withToken(Files.readString(folder.resolve(agent + ".token")).strip())
                        .withTls(Trust.file(certificates.authority()));
    }

    /** Lets an agent join a world through a node that does not have it. */
    Resident resident(String agent, String world) throws IOException {
        return resident(agent, world, Resident.PAUSE);
    }

    /** Lets an agent with a pause between its acts join a world, as above. */
    Resident resident(String agent, String world, Duration pause) throws IOException {
        PostgresStore.World now = worlds().get(world);
        Node other =
                alive().stream()
                        .filter(node -> !node.agents().equals(now.agents()))
                        .findFirst()
                        .orElseThrow();
        String[] at = other.agents().split(":");
        return new Resident(at[0], Integer.parseInt(at[1]), join(agent, world), pause);
    }

    /**
     * Requires that a world without agents has, at the first frame of an epoch, the state of a
     * world that was never disturbed.
     */
    void requireUndisturbed(PostgresStore.World world) throws Exception {
        JsonNode ready = ownerOf(world).orElseThrow().ready(world.name(), world.epoch());
        long frame = ready.path("frame").asLong();
        Outcome run =
                Reve.run(
                        "run",
                        world(world.name()).toString(),
                        "--seconds",
                        Double.toString((double) frame / RATE),
                        "--json");
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(ready.path("stateHash").asString())
                .as("%s at frame %s", world.name(), frame)
                .isEqualTo(new JsonMapper().readTree(run.out()).path("stateHash").asString());
    }

    /**
     * Ends all nodes, and requires that the state of each world is that which a replay of its
     * journal gives.
     */
    void requireWholeStores() throws Exception {
        Map<String, String> hashes = new HashMap<>();
        List<Node> last = alive();
        last.forEach(node -> node.server().process().toHandle().destroy());
        for (Node node : last) {
            assertThat(node.server().exitCode()).isZero();
            List<JsonNode> events = node.server().events().untilEnd();
            events.getLast()
                    .path("worlds")
                    .forEach(
                            report ->
                                    hashes.put(
                                            report.path("world").asString(),
                                            report.path("stateHash").asString()));
        }
        for (String world : worlds) {
            Outcome checked = Reve.run("store", "check", url, "--world", world, "--json");
            assertThat(checked.code()).as(checked.out() + checked.err()).isZero();
            if (hashes.containsKey(world)) {
                assertThat(new JsonMapper().readTree(checked.out()).path("stateHash").asString())
                        .as(world)
                        .isEqualTo(hashes.get(world));
            }
        }
    }

    /** Ends all processes of the cluster. */
    @Override
    public void close() {
        servers.forEach(Server::close);
    }
}
