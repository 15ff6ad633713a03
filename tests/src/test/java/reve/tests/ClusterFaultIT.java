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
import reve.worlds.journal.PostgresStore;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Collections;
import java.util.HashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;
import java.util.TreeSet;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.stream.IntStream;

/** Nodes of a cluster that are killed or paused, again and again, while agents act. */
@Tag("slow")
class ClusterFaultIT {
    /** 30 in a long run; a multiple of the 3 nodes. */
    private static final List<String> WORLDS =
            IntStream.rangeClosed(1, Integer.getInteger("reve.test.cluster.worlds", 6))
                    .mapToObj(number -> "w" + number)
                    .toList();

    /** 300 in a long run. */
    private static final int AGENTS = Integer.getInteger("reve.test.cluster.agents", 3);

    /** Pause between two acts of an agent. All agents together act at most 30 times a second. */
    private static final Duration PAUSE = Resident.PAUSE.multipliedBy(Math.max(1, AGENTS / 3));

    private static final long SEED = Long.getLong("reve.test.seed", 20261130);

    /** 100 in a long run. */
    private static final int KILLS = Integer.getInteger("reve.test.node.kills", 1);

    /** 100 in a long run. */
    private static final int STOPS = Integer.getInteger("reve.test.node.stops", 1);

    /** 30 in a long run. A pause of less than 12 s may not cost a node its worlds. */
    private static final int STOP_SECONDS = Integer.getInteger("reve.test.node.stop.seconds", 16);

    private static Postgres postgres;

    @TempDir private Path folder;
    private final Random random = new Random(SEED);
    private final List<Resident> residents = new ArrayList<>();
    private FaultCluster cluster;

    @BeforeAll
    static void start() throws Exception {
        postgres = new Postgres();
    }

    @AfterAll
    static void stop() throws Exception {
        postgres.close();
    }

    @AfterEach
    void end() {
        if (cluster != null) {
            cluster.close(); // first, because agents wait for their worlds
        }
        residents.forEach(Resident::close);
    }

    private void startCluster(String database) throws Exception {
        cluster =
                new FaultCluster(
                        folder,
                        postgres,
                        database,
                        Collections.nCopies(3, Optional.empty()),
                        WORLDS,
                        List.of());
        for (int i = 0; i < AGENTS; i++) {
            residents.add(cluster.resident("a" + i, agentsWorld(i), PAUSE));
        }
    }

    /** Returns the world of an agent. Each second world has agents; the others are undisturbed. */
    private static String agentsWorld(int agent) {
        return WORLDS.get(2 * agent % WORLDS.size());
    }

    private List<String> worldsOf(Node node, Map<String, PostgresStore.World> now) {
        return WORLDS.stream()
                .filter(world -> now.get(world).agents().equals(node.agents()))
                .toList();
    }

    /** Selects the oldest node, which places worlds, first; then any. */
    private Node victim(int round) {
        List<Node> alive = cluster.alive();
        return round == 1 ? alive.getFirst() : alive.get(random.nextInt(alive.size()));
    }

    /**
     * All worlds of each killed node run on other nodes, in one later epoch, from the last frame
     * that was published or the one before it, and with the state of a world that was never
     * disturbed. All agents keep their sessions and their bodies. The node is started again at its
     * address.
     */
    @Test
    void worldsAndSessionsOutliveEachKilledNode() throws Exception {
        startCluster("kills");
        List<Double> seconds = new ArrayList<>();
        for (int kill = 1; kill <= KILLS; kill++) {
            Map<String, PostgresStore.World> before = cluster.awaitBalance();
            Node victim = victim(kill);
            List<String> lost = worldsOf(victim, before);
            String which = "kill " + kill + " of seed " + SEED;
            assertThat(lost).as(which).isNotEmpty();
            long began = System.nanoTime();
            victim.server().process().destroyForcibly().onExit().join();
            LockSupport.parkNanos(TimeUnit.SECONDS.toNanos(1)); // results may still be read
            Map<String, Long> published = new HashMap<>();
            residents.forEach(each -> published.merge(each.world(), each.lastFrame(), Math::max));
            Map<String, PostgresStore.World> after = awaitElsewhere(lost, before, began, seconds);
            for (String world : WORLDS) {
                boolean isLost = lost.contains(world);
                assertThat(after.get(world).epoch())
                        .as("%s, %s", which, world)
                        .isEqualTo(before.get(world).epoch() + (isLost ? 1 : 0));
                if (isLost && published.containsKey(world)) {
                    assertThat(firstFrame(after.get(world)))
                            .as("%s, frame from which %s resumes", which, world)
                            .isGreaterThanOrEqualTo(published.get(world) - 1);
                } else if (isLost) {
                    cluster.requireUndisturbed(after.get(world));
                }
            }
            Resident.requireAtHome(residents);
            cluster.startMissing();
        }
        cluster.awaitBalance();
        report("killed nodes", seconds);
        requireOrder();
    }

    private long firstFrame(PostgresStore.World world) throws IOException {
        return cluster.ownerOf(world)
                .orElseThrow()
                .ready(world.name(), world.epoch())
                .path("frame")
                .asLong();
    }

    /** Waits until lost worlds have stored a frame elsewhere, and measures the time of each. */
    private Map<String, PostgresStore.World> awaitElsewhere(
            List<String> lost,
            Map<String, PostgresStore.World> before,
            long beganNanos,
            List<Double> seconds)
            throws IOException {
        Set<String> waiting = new TreeSet<>(lost);
        return cluster.await(
                lost + " run elsewhere",
                now -> {
                    waiting.removeIf(
                            world -> {
                                PostgresStore.World old = before.get(world);
                                PostgresStore.World each = now.get(world);
                                boolean runs =
                                        each.epoch() > old.epoch()
                                                && each.frame() > old.frame()
                                                && !each.agents().equals(old.agents())
                                                && cluster.ownerOf(each).isPresent();
                                if (runs) {
                                    seconds.add((System.nanoTime() - beganNanos) * 1e-9);
                                }
                                return runs;
                            });
                    return waiting.isEmpty();
                });
    }

    /** Prints how long it took until worlds ran elsewhere. */
    private static void report(String what, List<Double> seconds) {
        Collections.sort(seconds);
        System.out.printf(
                Locale.ROOT,
                "%s: %d worlds ran elsewhere after %.1f s (median), %.1f s (p99), %.1f s (max)%n",
                what,
                seconds.size(),
                seconds.get(seconds.size() / 2),
                seconds.get((int) Math.ceil(0.99 * seconds.size()) - 1),
                seconds.getLast());
    }

    /**
     * A paused node loses its worlds to the other nodes. When it continues, none of its writes is
     * accepted, no world gets another owner, and the node ends. All agents keep their sessions.
     */
    @Test
    void aPausedNodeWritesNothingAfterItsWorldsRunElsewhere() throws Exception {
        startCluster("stops");
        List<Double> seconds = new ArrayList<>();
        for (int stop = 1; stop <= STOPS; stop++) {
            Map<String, PostgresStore.World> before = cluster.awaitBalance();
            Node victim = victim(stop);
            List<String> lost = worldsOf(victim, before);
            String which = "stop " + stop + " of seed " + SEED;
            long began = System.nanoTime();
            signal("STOP", victim);
            try {
                awaitElsewhere(lost, before, began, seconds);
                long left = began + TimeUnit.SECONDS.toNanos(STOP_SECONDS) - System.nanoTime();
                LockSupport.parkNanos(Math.max(0, left));
            } finally {
                signal("CONT", victim);
            }
            assertThat(victim.server().exitCode()).as(which).isEqualTo(1);
            List<JsonNode> faults =
                    victim.server().events().untilEnd().stream()
                            .filter(event -> event.path("event").asString().equals("fault"))
                            .toList();
            for (String world : lost) {
                assertThat(faults)
                        .as("%s, %s", which, world)
                        .anySatisfy(
                                fault -> {
                                    assertThat(fault.path("world").asString("")).isEqualTo(world);
                                    assertThat(fault.path("message").asString())
                                            .contains("can store nothing after frame");
                                });
            }
            Map<String, PostgresStore.World> after = cluster.awaitRunning();
            for (String world : WORLDS) {
                assertThat(after.get(world).epoch())
                        .as("%s, %s", which, world)
                        .isEqualTo(before.get(world).epoch() + (lost.contains(world) ? 1 : 0));
            }
            Resident.requireAtHome(residents);
            cluster.startMissing();
        }
        cluster.awaitBalance();
        report("paused nodes", seconds);
        requireOrder();
    }

    /** A server that belongs to no cluster takes the world of a killed node, at its address. */
    @Test
    void aSessionContinuesOnAServerWithoutACluster() throws Exception {
        cluster =
                new FaultCluster(
                        folder, postgres, "alone", List.of(Optional.empty()), WORLDS, List.of());
        Node node = cluster.alive().getFirst();
        String[] at = node.agents().split(":");
        residents.add(
                new Resident(
                        at[0], Integer.parseInt(at[1]), cluster.join("ada", "w1"), Resident.PAUSE));
        Resident.requireAtHome(residents);
        node.server().process().destroyForcibly().onExit().join();
        Server alone = cluster.alone(node.place(), "w1");
        assertThat(alone.events().await("ready", _ -> true).path("epoch").asLong()).isEqualTo(2);
        Resident.requireAtHome(residents);
        cluster.requireOneWriter();
    }

    private static void signal(String name, Node node) throws Exception {
        Process sent =
                new ProcessBuilder("kill", "-" + name, Long.toString(node.server().process().pid()))
                        .inheritIO()
                        .start();
        assertThat(sent.waitFor()).isZero();
    }

    /** Requires that all writes of the test came from one owner after the other. */
    private void requireOrder() throws Exception {
        Resident.requireAtHome(residents);
        residents.forEach(Resident::close);
        cluster.requireOneWriter();
        cluster.requireWholeStores();
    }
}
