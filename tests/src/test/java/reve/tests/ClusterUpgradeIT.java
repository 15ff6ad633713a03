// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.FaultCluster.Node;
import reve.tests.Reve.Outcome;
import reve.worlds.Product;
import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** A cluster that gets a new version, node by node, while agents act. */
@Tag("slow")
class ClusterUpgradeIT {
    private static final List<String> WORLDS = List.of("w1", "w2", "w3");
    private static final Map<String, String> AGENTS = Map.of("ada", "w1", "bob", "w2", "eve", "w3");
    private static final String NEXT = "99.0";

    private static Postgres postgres;

    @TempDir private Path folder;
    private final List<AutoCloseable> open = new ArrayList<>();

    @BeforeAll
    static void start() throws Exception {
        postgres = new Postgres();
    }

    @AfterAll
    static void stop() throws Exception {
        postgres.close();
    }

    @AfterEach
    void end() throws Exception {
        for (AutoCloseable each : open) {
            each.close();
        }
    }

    /**
     * Returns the environment of a program with another version: the same program, with another
     * file VERSION before its own one.
     */
    private Map<String, String> nextVersion() throws Exception {
        Path classes = folder.resolve("next");
        Files.createDirectories(classes.resolve("reve/worlds"));
        Files.writeString(classes.resolve("reve/worlds/VERSION"), NEXT);
        return Map.of("REVE_JAVA_OPTIONS", "-Xbootclasspath/a:" + classes);
    }

    private static JsonNode cluster(Node asked, String... arguments) throws Exception {
        List<String> command = new ArrayList<>(List.of("cluster"));
        command.addAll(List.of(arguments));
        command.addAll(List.of("--json", "--port", asked.agents().split(":")[1]));
        Outcome outcome = Reve.run(command.toArray(String[]::new));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private static List<String> versions(Node asked) throws Exception {
        return cluster(asked, "status")
                .path("nodes")
                .valueStream()
                .map(node -> node.path("version").asString(""))
                .toList();
    }

    /**
     * Each node is drained, ended and started again with another version. No agent loses its
     * session or its body, no world has two writers, and a replay of each world gives its state.
     */
    @Test
    void eachNodeIsReplacedWhileAgentsAct() throws Exception {
        FaultCluster cluster =
                new FaultCluster(
                        folder,
                        postgres,
                        "upgrade",
                        Collections.nCopies(3, Optional.empty()),
                        WORLDS,
                        List.of());
        open.add(cluster); // ends first, because agents wait for their worlds
        List<Resident> residents = new ArrayList<>();
        for (Map.Entry<String, String> agent : AGENTS.entrySet()) {
            Resident resident = cluster.resident(agent.getKey(), agent.getValue());
            residents.add(resident);
            open.add(resident);
        }
        assertThat(versions(cluster.alive().getLast())).containsOnly(Product.version());
        cluster.change(nextVersion());
        for (FaultCluster.Place place : cluster.places()) {
            Node old = cluster.at(place);
            Node other =
                    cluster.alive().stream().filter(node -> node != old).findFirst().orElseThrow();
            JsonNode drained = cluster(other, "drain", old.address());
            assertThat(drained.path("drained").asBoolean()).isTrue();
            for (PostgresStore.World world : cluster.worlds().values()) {
                assertThat(world.agents()).isNotEqualTo(old.agents());
            }
            old.server().process().toHandle().destroy();
            assertThat(old.server().exitCode()).isZero();
            cluster.startAt(place);
            Resident.requireAtHome(residents);
        }
        cluster.awaitRunning();
        Node asked = cluster.alive().getFirst();
        cluster.await("all nodes have the next version", _ -> isUpgraded(asked));
        Resident.requireAtHome(residents);
        residents.forEach(Resident::close);
        cluster.requireOneWriter();
        cluster.requireWholeStores();
        for (String world : WORLDS) {
            Outcome replay = Reve.run("replay", world, "--store", cluster.url(), "--json");
            assertThat(replay.code()).as(replay.out() + replay.err()).isZero();
            assertThat(new JsonMapper().readTree(replay.out()).path("frames").asLong())
                    .as(world)
                    .isPositive();
        }
    }

    private static boolean isUpgraded(Node asked) {
        try {
            return versions(asked).equals(Collections.nCopies(3, NEXT));
        } catch (Exception e) {
            throw new AssertionError(e);
        }
    }

    private Server started(Path place, String... command) throws Exception {
        Server server = Server.start(Files.createDirectory(place), command);
        open.add(server);
        return server;
    }

    /** Returns the message of a node that ends by itself. */
    private String refusal(String which, String... command) throws Exception {
        Path place = folder.resolve(which);
        assertThat(started(place, command).exitCode()).isEqualTo(1);
        return Files.readString(place.resolve("server.err"));
    }

    /** A row of the list of nodes stands for a running node of a later program. */
    @Test
    void aNodeWhoseVersionDoesNotFitIsRefused() throws Exception {
        String url = postgres.create("versions");
        try (PostgresCatalog catalog = new PostgresCatalog(PostgresUrl.find(url).orElseThrow())) {
            catalog.prepare();
        }
        postgres.execute(
                "versions",
                "INSERT INTO reve.node VALUES ('10.0.0.2:2551', '99.0', 9, 8, '', 0, 0, 0,"
                        + " clock_timestamp() + interval '1 h')");
        String[] serve = {"serve", "--cluster", "lab", "--store", url, "--port", "0", "--json"};
        assertThat(refusal("earlier", serve))
                .contains(
                        "the node 10.0.0.2:2551 runs REVE 99.0, which speaks version 9 between"
                                + " nodes and understands 8 to 9; this program is REVE "
                                + Product.version()
                                + ", which speaks version 2 ",
                        "Start a version that fits, or end all other nodes first");
        assertThat(postgres.query("versions", "SELECT version FROM reve.node"))
                .containsExactly("99.0");
        postgres.execute("versions", "UPDATE reve.node SET oldest = 1");
        Server joins = started(folder.resolve("fits"), serve);
        joins.events().await("cluster", event -> event.path("status").asString().equals("up"));
        assertThat(postgres.query("versions", "SELECT version FROM reve.node ORDER BY 1"))
                .containsExactlyInAnyOrder("99.0", Product.version());
        joins.process().toHandle().destroy();
        assertThat(joins.exitCode()).isZero();
        assertThat(postgres.query("versions", "SELECT version FROM reve.node"))
                .as("a node that has ended blocks no other version")
                .containsExactly("99.0");
        postgres.execute("versions", "UPDATE reve.version SET version = 2");
        assertThat(refusal("other-tables", serve))
                .contains("versions have the version 2, this program reads and writes 1; use the");
    }
}
