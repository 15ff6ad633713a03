// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.junit.jupiter.api.Assumptions.abort;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.FaultCluster.Node;
import reve.tests.FaultCluster.Place;
import reve.worlds.journal.PostgresStore;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.stream.Collectors;

/**
 * A cluster of three nodes whose network is divided, with the database in a place of its own. Each
 * node and the database have a network namespace.
 */
@Tag("slow")
class ClusterPartitionIT {
    private static final List<String> WORLDS = List.of("w1", "w2", "w3", "w4", "w5", "w6");

    /** The worlds with an agent, by the agent. */
    private static final Map<String, String> AGENTS = Map.of("ada", "w1", "bob", "w3", "eve", "w5");

    /** Number of partitions of each shape; 50 in a long run. 0 makes a short run of two shapes. */
    private static final int EACH = Integer.getInteger("reve.test.partitions", 0);

    /** Names of the shapes that are tested, separated by commas; all if it is empty. */
    private static final String SHAPES = System.getProperty("reve.test.partition.shapes", "");

    /** How long a node is cut off from the database only: longer than a lease [s]. */
    private static final long DATABASE_SECONDS = 13;

    @TempDir private Path folder;
    private final List<Resident> residents = new ArrayList<>();

    /** The places of the nodes, the oldest first. The oldest node places the worlds. */
    private List<Place> byAge = List.of();

    private Network network;
    private Network.Member machine;
    private Postgres postgres;
    private FaultCluster cluster;

    /** The shapes of a partition, and whether a short run contains it. */
    private enum Shape {
        /** The youngest node does not reach the database, but the other nodes. */
        NO_DATABASE(true),
        /** The oldest node is alone, and reaches the database. */
        OLDEST_ALONE(false),
        /** The youngest node is alone, and reaches the database. */
        YOUNGEST_ALONE(false),
        /** The oldest node is alone, and does not reach the database. */
        OLDEST_CUT_OFF(true),
        /** Each node is alone, and reaches the database. */
        ALL_ALONE(false),
        /** No packet of the oldest node reaches the youngest one. Packets arrive from there. */
        ONE_WAY(false);

        private final boolean isShort;

        Shape(boolean isShort) {
            this.isShort = isShort;
        }
    }

    @BeforeEach
    void start() throws Exception {
        try {
            network = new Network(4);
        } catch (IOException refused) {
            System.err.println("no partitions are tested: " + refused.getMessage());
            abort("no partitions are tested: " + refused.getMessage());
        }
        List<Network.Member> members = network.members();
        machine = members.getLast();
        postgres = new Postgres(machine);
        cluster =
                new FaultCluster(
                        folder,
                        postgres,
                        "partitions",
                        members.subList(0, 3).stream().map(Optional::of).toList(),
                        WORLDS,
                        List.copyOf(AGENTS.keySet()));
        byAge = cluster.places();
        for (Map.Entry<String, String> agent : AGENTS.entrySet()) {
            residents.add(cluster.resident(agent.getKey(), agent.getValue()));
        }
    }

    @AfterEach
    void end() throws Exception {
        if (cluster != null) {
            cluster.close();
        }
        residents.forEach(Resident::close);
        if (postgres != null) {
            postgres.close();
        }
        if (network != null) {
            network.close();
        }
    }

    /**
     * A division never gives a world two writers: one part continues, with all worlds, and the
     * nodes of the other parts end. After the division, all worlds run on all nodes again, and all
     * agents have the sessions and bodies that they had.
     */
    @Test
    void aDividedNetworkNeverGivesAWorldTwoWriters() throws Exception {
        requireThatLossesAreLosses();
        for (Shape shape : Shape.values()) {
            boolean isMeant = SHAPES.isEmpty() || List.of(SHAPES.split(",")).contains(shape.name());
            int count = !isMeant ? 0 : EACH > 0 ? EACH : shape.isShort ? 1 : 0;
            for (int i = 1; i <= count; i++) {
                try {
                    divide(shape);
                } catch (Exception | AssertionError failed) {
                    throw new AssertionError("partition " + i + " of shape " + shape, failed);
                }
            }
        }
        Resident.requireAtHome(residents);
        residents.forEach(Resident::close);
        cluster.requireOneWriter();
        cluster.requireWholeStores();
    }

    /** The network of the test loses packets in one direction, without an error. */
    private void requireThatLossesAreLosses() throws IOException {
        Network.Member one = byAge.get(0).member();
        Network.Member other = byAge.get(1).member();
        assertThat(network.reaches(one, other)).isTrue();
        network.lose(one, other);
        assertThat(network.reaches(one, other)).isFalse();
        assertThat(network.reaches(one, machine)).isTrue();
        network.heal();
        assertThat(network.reaches(one, other)).isTrue();
    }

    private void divide(Shape shape) throws Exception {
        // A short run does not wait until each node has its share again, which takes 10 s.
        Map<String, PostgresStore.World> before =
                EACH > 0 ? cluster.awaitBalance() : cluster.awaitRunning();
        Network.Member oldest = byAge.get(0).member();
        Network.Member youngest = byAge.get(2).member();
        Set<Set<Place>> divided = new HashSet<>();
        switch (shape) {
            case OLDEST_ALONE -> separate(divided, 0, 1, 2);
            case YOUNGEST_ALONE -> separate(divided, 2, 0, 1);
            case OLDEST_CUT_OFF -> {
                separate(divided, 0, 1, 2);
                network.separate(oldest, machine);
            }
            case ALL_ALONE -> {
                separate(divided, 0, 1, 2);
                separate(divided, 1, 2);
            }
            case NO_DATABASE -> network.separate(youngest, machine);
            case ONE_WAY -> {
                network.lose(oldest, youngest);
                divided.add(Set.of(byAge.get(0), byAge.get(2)));
            }
        }
        try {
            if (shape == Shape.NO_DATABASE) {
                requireThatAllStay(before, byAge.get(2));
            } else {
                if (shape == Shape.OLDEST_CUT_OFF) {
                    requireThatNothingIsLost(before, byAge.get(0));
                }
                awaitOnePart(divided);
            }
        } finally {
            network.heal();
        }
        cluster.awaitRunning();
        Resident.requireAtHome(residents);
        startEnded();
        cluster.awaitRunning();
        cluster.requireOneWriter();
    }

    private void separate(Set<Set<Place>> divided, int one, int... others) {
        for (int other : others) {
            network.separate(byAge.get(one).member(), byAge.get(other).member());
            divided.add(Set.of(byAge.get(one), byAge.get(other)));
        }
    }

    /** Waits until nodes that do not reach each other are not alive both, and all worlds run. */
    private void awaitOnePart(Set<Set<Place>> divided) throws Exception {
        cluster.await(
                "one part of the nodes continues",
                _ -> {
                    Set<Place> alive = placesOf(cluster.alive());
                    assertThat(alive).as("nodes that continue").isNotEmpty();
                    return divided.stream().noneMatch(alive::containsAll);
                });
        for (Place place : byAge) {
            Node node = cluster.at(place);
            if (!node.isAlive()) {
                assertThat(node.server().exitCode()).isEqualTo(1);
                assertThat(node.server().events().untilEnd())
                        .as("what the node at " + node.address() + " reports")
                        .anySatisfy(
                                event -> {
                                    assertThat(event.path("source").asString(""))
                                            .isEqualTo("cluster");
                                    assertThat(event.path("message").asString())
                                            .contains("has removed this node");
                                });
            }
        }
        cluster.awaitRunning();
    }

    private static Set<Place> placesOf(List<Node> nodes) {
        return nodes.stream().map(Node::place).collect(Collectors.toSet());
    }

    /**
     * A node without the database keeps its worlds, because the others reach it. It stores their
     * frames when it reaches the database again.
     */
    private void requireThatAllStay(Map<String, PostgresStore.World> before, Place without)
            throws Exception {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(DATABASE_SECONDS);
        while (System.nanoTime() < end) {
            Resident.awaitActs(residents);
        }
        assertThat(cluster.alive()).hasSize(3);
        network.heal();
        Map<String, PostgresStore.World> after = cluster.awaitRunning();
        for (String world : WORLDS) {
            assertThat(after.get(world).epoch())
                    .as("%s, of %s", world, before.get(world).agents())
                    .isEqualTo(before.get(world).epoch());
        }
        assertThat(cluster.at(without).isAlive()).isTrue();
    }

    /**
     * After another node has taken the worlds of a node that is cut off, this node makes no more
     * frames: no act of an agent is accepted that would be lost.
     */
    private void requireThatNothingIsLost(Map<String, PostgresStore.World> before, Place cutOff)
            throws Exception {
        Node node = cluster.at(cutOff);
        List<String> lost =
                WORLDS.stream()
                        .filter(world -> before.get(world).agents().equals(node.agents()))
                        .toList();
        cluster.await(
                "the others run " + lost,
                now ->
                        lost.stream()
                                .allMatch(
                                        world ->
                                                now.get(world).epoch() > before.get(world).epoch()
                                                        && now.get(world).isOwned()));
        Map<Resident, Integer> acts =
                residents.stream()
                        .filter(resident -> lost.contains(resident.world()))
                        .collect(Collectors.toMap(each -> each, Resident::accepted));
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(5);
        while (System.nanoTime() < end) {
            LockSupport.parkNanos(100_000_000);
            Map<Resident, Integer> now = new HashMap<>();
            acts.keySet().forEach(resident -> now.put(resident, resident.accepted()));
            if (!node.isAlive()) {
                break; // the residents act on another node
            }
            acts.forEach(
                    (resident, count) ->
                            assertThat(now.get(resident) - count)
                                    .as("acts of %s that are lost", resident)
                                    .isLessThanOrEqualTo(1));
        }
        node.server()
                .events()
                .await(
                        "fault",
                        event -> event.path("message").asString().contains("make no frames until"));
    }

    /** Starts the nodes that have ended; they are younger than the others from now on. */
    private void startEnded() throws Exception {
        Set<Place> alive = placesOf(cluster.alive());
        List<Place> order = new ArrayList<>(byAge);
        order.removeIf(place -> !alive.contains(place));
        for (Place place : byAge) {
            if (!alive.contains(place)) {
                cluster.startAt(place);
                order.add(place);
            }
        }
        byAge = order;
    }
}
