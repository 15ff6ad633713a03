// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import static org.assertj.core.api.Assertions.assertThat;

import org.apache.pekko.actor.ActorRef;
import org.apache.pekko.actor.ActorSystem;
import org.apache.pekko.actor.Props;
import org.apache.pekko.cluster.sharding.ShardCoordinator;
import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Test;

import reve.worlds.journal.PostgresCatalog.Places;

import scala.collection.immutable.IndexedSeq;
import scala.concurrent.Future;
import scala.jdk.javaapi.CollectionConverters;
import scala.jdk.javaapi.FutureConverters;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;
import java.util.concurrent.CompletableFuture;

/** The node that runs each world, with orders of operators. */
class WorldPlacementTest {
    private static final long SECOND = 1_000_000_000L;

    private static ActorSystem system;
    private static ActorRef one;
    private static ActorRef two;
    private static ActorRef three;

    private Places orders = Places.NONE;
    private Set<String> asleep = Set.of();
    private boolean isDatabaseThere = true;
    private long nanos;
    private final Balance balance = new Balance();
    private final WorldPlacement placement =
            new WorldPlacement(
                    balance,
                    () -> orders,
                    () -> asleep,
                    node -> node.path().name(),
                    () -> isDatabaseThere,
                    () -> nanos);

    /** Replaces Pekko's strategy. Records the worlds of each node that it was shown. */
    private static final class Balance
            implements ShardCoordinator.ActorSystemDependentAllocationStrategy {
        private final List<Map<String, List<String>>> shown = new ArrayList<>();
        private Set<String> moves = Set.of();

        @Override
        public void start(ActorSystem started) {}

        private void show(scala.collection.immutable.Map<ActorRef, IndexedSeq<String>> worlds) {
            Map<String, List<String>> seen = new TreeMap<>();
            CollectionConverters.asJava(worlds)
                    .forEach(
                            (node, own) ->
                                    seen.put(
                                            node.path().name(),
                                            List.copyOf(CollectionConverters.asJava(own))));
            shown.add(seen);
        }

        /** Chooses the first of the nodes by name. */
        @Override
        public Future<ActorRef> allocateShard(
                ActorRef requester,
                String world,
                scala.collection.immutable.Map<ActorRef, IndexedSeq<String>> worlds) {
            show(worlds);
            return FutureConverters.asScala(
                    CompletableFuture.completedFuture(
                            CollectionConverters.asJava(worlds).keySet().stream()
                                    .sorted()
                                    .findFirst()
                                    .orElseThrow()));
        }

        @Override
        public Future<scala.collection.immutable.Set<String>> rebalance(
                scala.collection.immutable.Map<ActorRef, IndexedSeq<String>> worlds,
                scala.collection.immutable.Set<String> moving) {
            show(worlds);
            return FutureConverters.asScala(CompletableFuture.completedFuture(set(moves)));
        }
    }

    @BeforeAll
    static void start() {
        system = ActorSystem.create("placement");
        one = system.actorOf(Props.empty(), "one");
        two = system.actorOf(Props.empty(), "two");
        three = system.actorOf(Props.empty(), "three");
    }

    @AfterAll
    static void stop() {
        system.terminate();
        system.getWhenTerminated().toCompletableFuture().join();
    }

    private static scala.collection.immutable.Set<String> set(Set<String> texts) {
        return scala.collection.immutable.Set.from(CollectionConverters.asScala(texts));
    }

    private static scala.collection.immutable.Map<ActorRef, IndexedSeq<String>> worlds(
            Map<ActorRef, List<String>> worlds) {
        Map<ActorRef, IndexedSeq<String>> map = new LinkedHashMap<>();
        worlds.forEach(
                (node, own) -> map.put(node, CollectionConverters.asScala(own).toIndexedSeq()));
        return scala.collection.immutable.Map.from(CollectionConverters.asScala(map));
    }

    private ActorRef place(String world, Map<ActorRef, List<String>> now) {
        return FutureConverters.asJava(placement.allocateShard(one, world, worlds(now)))
                .toCompletableFuture()
                .join();
    }

    private Set<String> moves(Map<ActorRef, List<String>> now, String... moving) {
        return CollectionConverters.asJava(
                FutureConverters.asJava(placement.rebalance(worlds(now), set(Set.of(moving))))
                        .toCompletableFuture()
                        .join());
    }

    @Test
    void aWorldRunsWhereAnOrderSays() {
        orders = new Places(Map.of("w1", "three"), Set.of());
        Map<ActorRef, List<String>> now =
                Map.of(one, List.of("w1", "w2"), two, List.of(), three, List.of("w3"));
        assertThat(moves(now)).containsExactly("w1");
        assertThat(moves(now, "w1")).as("w1 moves already").isEmpty();
        assertThat(place("w1", now)).isEqualTo(three);
        assertThat(balance.shown).isEmpty();
        assertThat(moves(Map.of(one, List.of("w2"), two, List.of(), three, List.of("w1"))))
                .isEmpty();
        assertThat(place("w2", now)).as("without an order").isEqualTo(one);
    }

    @Test
    void anOrderForANodeThatIsAwayHasNoEffect() {
        orders = new Places(Map.of("w1", "three"), Set.of());
        Map<ActorRef, List<String>> now = Map.of(one, List.of("w1"), two, List.of());
        assertThat(moves(now)).isEmpty();
        assertThat(place("w1", now)).isEqualTo(one);
    }

    /** A world that moved then would lose the frames that its node could not store. */
    @Test
    void noWorldMovesWhileTheDatabaseIsAway() {
        orders = new Places(Map.of("w1", "two"), Set.of());
        balance.moves = Set.of("w2");
        nanos = 5 * SECOND;
        Map<ActorRef, List<String>> now = Map.of(one, List.of("w1", "w2"), two, List.of());
        isDatabaseThere = false;
        assertThat(moves(now)).isEmpty();
        isDatabaseThere = true;
        assertThat(moves(now)).containsExactly("w1");
    }

    @Test
    void aDrainedNodeRunsNoWorlds() {
        orders = new Places(Map.of("w1", "one"), Set.of("one"));
        Map<ActorRef, List<String>> now = Map.of(one, List.of("w1", "w2"), two, List.of("w3"));
        assertThat(moves(now)).containsExactlyInAnyOrder("w1", "w2");
        assertThat(place("w1", now)).isEqualTo(two);
        assertThat(place("w2", now)).isEqualTo(two);
        assertThat(balance.shown).containsOnly(Map.of("two", List.of("w3")));
        nanos = 5 * SECOND;
        assertThat(moves(Map.of(one, List.of(), two, List.of("w1", "w2", "w3")))).isEmpty();
        assertThat(balance.shown.getLast())
                .as("the drained node gets no share")
                .containsOnlyKeys("two");
    }

    /** Worlds must run somewhere. */
    @Test
    void ifAllNodesAreDrainedAllRunWorlds() {
        orders = new Places(Map.of(), Set.of("one", "two"));
        Map<ActorRef, List<String>> now = Map.of(one, List.of("w1"), two, List.of());
        assertThat(moves(now)).isEmpty();
        assertThat(place("w2", now)).isEqualTo(one);
    }

    @Test
    void onlyWorldsWithoutAnOrderMoveForTheSakeOfBalance() {
        orders = new Places(Map.of("w1", "one", "w2", "one"), Set.of());
        balance.moves = Set.of("w1", "w3", "w4");
        Map<ActorRef, List<String>> now =
                Map.of(one, List.of("w1", "w2", "w3", "w4"), two, List.of());
        nanos = 5 * SECOND - 1;
        assertThat(moves(now)).as("before the interval has passed").isEmpty();
        nanos = 5 * SECOND;
        assertThat(moves(now)).as("a tenth of the worlds, at least one").containsExactly("w3");
        assertThat(balance.shown)
                .as("worlds that may move come first")
                .containsExactly(Map.of("one", List.of("w3", "w4", "w1", "w2"), "two", List.of()));
        assertThat(moves(now)).as("again within the interval").isEmpty();
        nanos = 10 * SECOND;
        assertThat(moves(now)).containsExactly("w3");
    }

    /** A world that wakes then runs on the node with the fewest worlds that are awake. */
    @Test
    void aWorldThatSleepsHasNoPlaceAndDoesNotCount() {
        asleep = Set.of("w1", "w3");
        Map<ActorRef, List<String>> now = Map.of(one, List.of("w1", "w2"), two, List.of("w3"));
        assertThat(moves(now)).as("a client may return soon").isEmpty();
        nanos = 10 * SECOND - 1;
        assertThat(moves(now)).isEmpty();
        nanos = 10 * SECOND;
        assertThat(moves(now, "w3")).as("w3 loses its place already").containsExactly("w1");
        nanos = 15 * SECOND;
        assertThat(moves(Map.of(one, List.of("w2"), two, List.of()))).isEmpty();
        assertThat(place("w1", Map.of(one, List.of("w2"), two, List.of("w3")))).isEqualTo(one);
        assertThat(balance.shown).containsOnly(Map.of("one", List.of("w2"), "two", List.of()));
    }

    /** Otherwise it would be opened twice if a client woke it just before it lost its place. */
    @Test
    void aWorldThatWakesSoonKeepsItsPlace() {
        Map<ActorRef, List<String>> now = Map.of(one, List.of("w1"), two, List.of());
        asleep = Set.of("w1");
        assertThat(moves(now)).isEmpty();
        nanos = 9 * SECOND;
        asleep = Set.of();
        assertThat(moves(now)).isEmpty();
        nanos = 11 * SECOND;
        asleep = Set.of("w1");
        assertThat(moves(now)).as("it fell asleep again a moment ago").isEmpty();
        orders = new Places(Map.of(), Set.of("one"));
        assertThat(moves(now)).as("its node is drained").containsExactly("w1");
    }

    /** The database names the world as asleep until a node has taken it. */
    @Test
    void aWorldThatWakesKeepsItsPlaceUntilANodeHasTakenIt() {
        asleep = Set.of("w1");
        Map<ActorRef, List<String>> now = Map.of(one, List.of("w1"), two, List.of());
        place("w1", Map.of(one, List.of(), two, List.of()));
        nanos = 30 * SECOND;
        assertThat(moves(now)).isEmpty();
        assertThat(balance.shown.getLast()).containsEntry("one", List.of("w1"));
        nanos = 30 * SECOND + 1;
        assertThat(moves(now)).isEmpty();
        nanos = 41 * SECOND;
        assertThat(moves(now)).as("no node has taken it").containsExactly("w1");
        orders = new Places(Map.of("w1", "two"), Set.of());
        assertThat(place("w1", Map.of(one, List.of(), two, List.of()))).isEqualTo(two);
    }

    @Test
    void atMostTwentyWorldsLeaveADrainedNodeAtATime() {
        List<String> many = new ArrayList<>();
        for (int i = 10; i < 60; i++) {
            many.add("w" + i);
        }
        orders = new Places(Map.of(), Set.of("one"));
        assertThat(moves(Map.of(one, many, two, List.of())))
                .containsExactlyInAnyOrderElementsOf(many.subList(0, 20));
    }
}
