// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.actor.ActorRef;
import org.apache.pekko.actor.ActorSystem;
import org.apache.pekko.cluster.sharding.ShardCoordinator;

import reve.worlds.journal.PostgresCatalog;

import scala.collection.immutable.IndexedSeq;
import scala.collection.immutable.Map;
import scala.collection.immutable.Set;
import scala.concurrent.Future;
import scala.jdk.javaapi.CollectionConverters;
import scala.jdk.javaapi.FutureConverters;

import java.util.ArrayList;
import java.util.Collection;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Optional;
import java.util.TreeSet;
import java.util.concurrent.CompletableFuture;
import java.util.function.BooleanSupplier;
import java.util.function.Function;
import java.util.function.LongSupplier;
import java.util.function.Supplier;

/**
 * Decides which node runs which world. A world for which there is an order runs on the node that
 * the order names, while this node is in the cluster. A drained node runs no worlds. Pekko's
 * strategy places the other worlds: each on the node with the fewest worlds. A world that sleeps
 * loses its place and does not count, so it is placed again when it wakes. Pekko calls this object
 * on one node, the oldest one, with one call at a time.
 */
final class WorldPlacement implements ShardCoordinator.ActorSystemDependentAllocationStrategy {
    /** Minimum interval between two moves that give each node its share of the worlds [ns]. */
    private static final long BALANCE_NANOSECONDS = 5_000_000_000L;

    /** Maximum number of worlds that move at the same time. */
    private static final int MOST_AT_ONCE = 20;

    /** Maximum share of the worlds that move at the same time to give each node its share. */
    private static final double BALANCED_AT_ONCE = 0.1;

    /**
     * Time for which a world keeps a new place although it still counts as asleep [ns]. It is
     * longer than the time in which a node opens a world.
     */
    private static final long WAKING_NANOSECONDS = 30_000_000_000L;

    /**
     * Time for which a world that sleeps keeps its place [ns]. Clients often return soon. A world
     * that loses its place at the moment at which a client wakes it is opened twice.
     */
    private static final long ASLEEP_NANOSECONDS = 10_000_000_000L;

    private final ShardCoordinator.ActorSystemDependentAllocationStrategy balance;
    private final Supplier<PostgresCatalog.Places> orders;
    private final Supplier<java.util.Set<String>> asleep;
    private final Function<ActorRef, String> nodeOf;
    private final BooleanSupplier isDatabaseThere;
    private final LongSupplier clock;
    private long balancedNanos;

    /** The times at which worlds were last placed [ns]. */
    private final java.util.Map<String, Long> placedNanos = new HashMap<>();

    /** The times at which this object first found the worlds that sleep asleep [ns]. */
    private final java.util.Map<String, Long> asleepNanos = new HashMap<>();

    /**
     * @param balance places worlds without an order
     * @param orders returns the orders of operators, as they are known to this node; any thread
     * @param asleep returns the worlds that sleep; any thread
     * @param nodeOf returns the text by which orders name the node of a region
     * @param isDatabaseThere returns false while the database is away. No world moves then, because
     *     its last frames could not be stored for the other node
     * @param clock returns the time of a clock that is never set back [ns]
     */
    WorldPlacement(
            ShardCoordinator.ActorSystemDependentAllocationStrategy balance,
            Supplier<PostgresCatalog.Places> orders,
            Supplier<java.util.Set<String>> asleep,
            Function<ActorRef, String> nodeOf,
            BooleanSupplier isDatabaseThere,
            LongSupplier clock) {
        this.balance = balance;
        this.orders = orders;
        this.asleep = asleep;
        this.nodeOf = nodeOf;
        this.isDatabaseThere = isDatabaseThere;
        this.clock = clock;
        this.balancedNanos = clock.getAsLong();
    }

    @Override
    public void start(ActorSystem system) {
        balance.start(system);
    }

    @Override
    public Future<ActorRef> allocateShard(
            ActorRef requester, String world, Map<ActorRef, IndexedSeq<String>> worlds) {
        PostgresCatalog.Places known = orders.get();
        var open = open(worlds, known, asleep());
        placedNanos.put(world, clock.getAsLong());
        return place(world, open.keySet(), known)
                .map(node -> FutureConverters.asScala(CompletableFuture.completedFuture(node)))
                .orElseGet(() -> balance.allocateShard(requester, world, scala(open)));
    }

    @Override
    public Future<Set<String>> rebalance(
            Map<ActorRef, IndexedSeq<String>> worlds, Set<String> moving) {
        if (!isDatabaseThere.getAsBoolean()) {
            return done(List.of());
        }
        PostgresCatalog.Places known = orders.get();
        java.util.Set<String> sleeping = asleep();
        noteAsleep(sleeping);
        var open = open(worlds, known, sleeping);
        var wrong = new TreeSet<String>();
        CollectionConverters.asJava(worlds)
                .forEach(
                        (node, own) -> {
                            for (String world : CollectionConverters.asJava(own)) {
                                boolean isRight =
                                        !hasSlept(world)
                                                && place(world, open.keySet(), known)
                                                        .map(node::equals)
                                                        .orElse(open.containsKey(node));
                                if (!isRight && !moving.contains(world)) {
                                    wrong.add(world);
                                }
                            }
                        });
        if (!wrong.isEmpty()) {
            return done(wrong.stream().limit(MOST_AT_ONCE).toList());
        }
        long now = clock.getAsLong();
        if (now - balancedNanos < BALANCE_NANOSECONDS) {
            return done(List.of());
        }
        balancedNanos = now;
        // The strategy takes the first worlds of a node, so worlds that may move come first.
        var sorted = new LinkedHashMap<ActorRef, IndexedSeq<String>>();
        open.forEach(
                (node, own) -> {
                    var free = new ArrayList<String>();
                    var placed = new ArrayList<String>();
                    for (String world : CollectionConverters.asJava(own)) {
                        (known.nodes().containsKey(world) ? placed : free).add(world);
                    }
                    free.addAll(placed);
                    sorted.put(node, CollectionConverters.asScala(free).toIndexedSeq());
                });
        long count = sorted.values().stream().mapToLong(IndexedSeq::length).sum();
        long most = Math.max(1, Math.min(MOST_AT_ONCE, (long) (BALANCED_AT_ONCE * count)));
        return FutureConverters.asScala(
                FutureConverters.asJava(balance.rebalance(scala(sorted), moving))
                        .thenApply(
                                chosen ->
                                        set(
                                                CollectionConverters.asJava(chosen).stream()
                                                        .filter(
                                                                world ->
                                                                        place(
                                                                                        world,
                                                                                        open
                                                                                                .keySet(),
                                                                                        known)
                                                                                .isEmpty())
                                                        .sorted()
                                                        .limit(most)
                                                        .toList())));
    }

    /** Returns the worlds that sleep and were not placed a short time ago, when they woke. */
    private java.util.Set<String> asleep() {
        long now = clock.getAsLong();
        placedNanos.values().removeIf(placed -> now - placed > WAKING_NANOSECONDS);
        var sleeping = new HashSet<>(asleep.get());
        sleeping.removeAll(placedNanos.keySet());
        return sleeping;
    }

    private void noteAsleep(java.util.Set<String> sleeping) {
        asleepNanos.keySet().retainAll(sleeping);
        sleeping.forEach(world -> asleepNanos.putIfAbsent(world, clock.getAsLong()));
    }

    /** Returns whether a world has slept for so long that it loses its place. */
    private boolean hasSlept(String world) {
        Long since = asleepNanos.get(world);
        return since != null && clock.getAsLong() - since >= ASLEEP_NANOSECONDS;
    }

    /** Returns the worlds that do not sleep, by node. */
    private static java.util.Map<ActorRef, IndexedSeq<String>> awake(
            Map<ActorRef, IndexedSeq<String>> worlds, java.util.Set<String> sleeping) {
        var awake = new LinkedHashMap<ActorRef, IndexedSeq<String>>();
        CollectionConverters.asJava(worlds)
                .forEach(
                        (node, own) ->
                                awake.put(
                                        node,
                                        CollectionConverters.asScala(
                                                        CollectionConverters.asJava(own).stream()
                                                                .filter(
                                                                        world ->
                                                                                !sleeping.contains(
                                                                                        world))
                                                                .toList())
                                                .toIndexedSeq()));
        return awake;
    }

    /**
     * Returns the nodes that may run worlds, with their worlds that do not sleep: all nodes that
     * are not drained, or all if each is.
     */
    private java.util.Map<ActorRef, IndexedSeq<String>> open(
            Map<ActorRef, IndexedSeq<String>> worlds,
            PostgresCatalog.Places known,
            java.util.Set<String> sleeping) {
        var all = awake(worlds, sleeping);
        var open = new LinkedHashMap<ActorRef, IndexedSeq<String>>();
        all.forEach(
                (node, own) -> {
                    if (!known.drained().contains(nodeOf.apply(node))) {
                        open.put(node, own);
                    }
                });
        return open.isEmpty() ? all : open;
    }

    /** Returns the node that an order names for a world, if this node may run worlds. */
    private Optional<ActorRef> place(
            String world, Collection<ActorRef> open, PostgresCatalog.Places known) {
        String wanted = known.nodes().get(world);
        return open.stream().filter(node -> nodeOf.apply(node).equals(wanted)).findFirst();
    }

    private static Map<ActorRef, IndexedSeq<String>> scala(
            java.util.Map<ActorRef, IndexedSeq<String>> worlds) {
        return Map.from(CollectionConverters.asScala(worlds));
    }

    private static Future<Set<String>> done(Collection<String> worlds) {
        return FutureConverters.asScala(CompletableFuture.completedFuture(set(worlds)));
    }

    private static Set<String> set(Collection<String> worlds) {
        return Set.from(CollectionConverters.asScala(worlds));
    }
}
