// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import com.typesafe.config.Config;
import com.typesafe.config.ConfigFactory;

import org.apache.pekko.actor.Address;
import org.apache.pekko.actor.typed.ActorSystem;
import org.apache.pekko.actor.typed.Behavior;
import org.apache.pekko.actor.typed.javadsl.Behaviors;
import org.apache.pekko.cluster.ClusterEvent;
import org.apache.pekko.cluster.Member;
import org.apache.pekko.cluster.MemberStatus;
import org.apache.pekko.cluster.sharding.typed.ShardingEnvelope;
import org.apache.pekko.cluster.sharding.typed.ShardingMessageExtractor;
import org.apache.pekko.cluster.sharding.typed.javadsl.ClusterSharding;
import org.apache.pekko.cluster.sharding.typed.javadsl.Entity;
import org.apache.pekko.cluster.sharding.typed.javadsl.EntityTypeKey;
import org.apache.pekko.cluster.typed.Cluster;
import org.apache.pekko.cluster.typed.JoinSeedNodes;
import org.apache.pekko.cluster.typed.Subscribe;
import org.apache.pekko.remote.RemoteTransportException;
import org.jspecify.annotations.Nullable;

import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;
import reve.worlds.server.ServerEvents;
import reve.worlds.server.WorldHost;
import reve.worlds.server.WorldPlan;

import java.io.IOException;
import java.net.BindException;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeMap;
import java.util.concurrent.locks.LockSupport;

/**
 * A node of a cluster whose nodes share the worlds of a database. Cluster sharding places each
 * world on one node. The node opens the world from the database, in a new epoch. After the loss of
 * the node, another node does so. For any thread.
 */
public final class ClusterNode implements AutoCloseable {
    /** Interval between two readings of the list of worlds [ns]. */
    private static final long LOOK_NANOSECONDS = 1_000_000_000L;

    /** Time without an extension after which a lease of 10 s counts as ended [ns]. */
    private static final long SILENCE_NANOSECONDS = 11_000_000_000L;

    /** Begins the role of a node that contains its address for agents. */
    private static final String AGENTS = "agents=";

    private static final EntityTypeKey<WorldCommand> WORLDS =
            EntityTypeKey.create(WorldCommand.class, "world");

    private final NodeSettings settings;
    private final WorldHost host;
    private final Plans plans;
    private final ServerEvents events;
    private final PostgresCatalog catalog;
    private final ActorSystem<ClusterEvent.MemberEvent> system;
    private final Cluster cluster;
    private final Thread keeper =
            Thread.ofPlatform().name("worlds of the cluster").unstarted(this::keep);
    private volatile boolean stops;

    /** Addresses for agents of the worlds of other nodes, by name; for the agent server. */
    private volatile Map<String, String> elsewhere = Map.of();

    /** The worlds of the database when they were last read. */
    private volatile List<PostgresStore.World> worlds = List.of();

    /** Leases of the worlds as this node saw them first. For the thread of the keeper. */
    private final Map<String, Lease> leases = new HashMap<>();

    /**
     * @param until end of the lease by the clock of the database
     */
    private record Lease(String until, long sinceNanos) {}

    /** Makes the plans of the worlds of a database. */
    public interface Plans {
        /**
         * Makes the plan of a world. Called on the thread of the world.
         *
         * @throws Exception if the world cannot be opened on this node; the message is reported
         */
        WorldPlan of(String world) throws Exception;
    }

    /** Each world is a shard of its own, so that sharding places worlds one by one. */
    private static final class ShardPerWorld
            extends ShardingMessageExtractor<ShardingEnvelope<WorldCommand>, WorldCommand> {
        @Override
        public String entityId(ShardingEnvelope<WorldCommand> envelope) {
            return envelope.entityId();
        }

        @Override
        public String shardId(String world) {
            return world;
        }

        @Override
        public WorldCommand unwrapMessage(ShardingEnvelope<WorldCommand> envelope) {
            return envelope.message();
        }
    }

    private ClusterNode(NodeSettings settings, WorldHost host, Plans plans, ServerEvents events)
            throws IOException {
        this.settings = settings;
        this.host = host;
        this.plans = plans;
        this.events = events;
        this.catalog = new PostgresCatalog(settings.database());
        try {
            catalog.prepare();
            this.system =
                    ActorSystem.create(members(), settings.cluster(), config(settings, agents()));
        } catch (RemoteTransportException unbound) {
            catalog.close();
            throw unbound(settings, unbound);
        } catch (IOException | RuntimeException refused) {
            catalog.close();
            throw refused;
        }
        this.cluster = Cluster.get(system);
    }

    /**
     * Starts a node, which joins the cluster in the background and then runs its share of the
     * worlds.
     *
     * @param host runs the worlds; the caller closes it after the node
     * @throws BindException if the address for the other nodes cannot be bound
     * @throws IOException if the database is away
     */
    public static ClusterNode start(
            NodeSettings settings, WorldHost host, Plans plans, ServerEvents events)
            throws IOException {
        ClusterNode node = new ClusterNode(settings, host, plans, events);
        node.join();
        return node;
    }

    private static Config config(NodeSettings settings, String agents) {
        Map<String, Object> values = new HashMap<>();
        values.put("pekko.remote.artery.transport", settings.tls().isPresent() ? "tls-tcp" : "tcp");
        values.put("pekko.remote.artery.canonical.hostname", settings.listen().host());
        values.put("pekko.remote.artery.canonical.port", settings.listen().port());
        values.put("pekko.cluster.roles", List.of(AGENTS + agents));
        values.put("reve.lease.store", settings.store());
        settings.tls()
                .ifPresent(
                        files -> {
                            values.put("reve.tls.certificate", files.certificate().toString());
                            values.put("reve.tls.key", files.key().toString());
                            values.put("reve.tls.authority", files.authority().toString());
                        });
        return ConfigFactory.parseMap(values)
                .withFallback(ConfigFactory.parseResources(ClusterNode.class, "cluster.conf"))
                .withFallback(ConfigFactory.load());
    }

    private static BindException unbound(NodeSettings settings, RuntimeException failure) {
        Throwable cause = failure.getCause() == null ? failure : failure.getCause();
        BindException unbound =
                new BindException(
                        "cannot listen for nodes on "
                                + settings.listen()
                                + ": "
                                + cause.getMessage()
                                + "; name another address or port (0: any free one)");
        unbound.initCause(failure);
        return unbound;
    }

    private void join() {
        ClusterSharding.get(system)
                .init(
                        Entity.of(WORLDS, context -> WorldActor.of(opener(context.getEntityId())))
                                .withMessageExtractor(new ShardPerWorld())
                                .withStopMessage(new WorldCommand.Stop()));
        List<Address> seeds =
                settings.seeds().isEmpty()
                        ? List.of(cluster.selfMember().address())
                        : settings.seeds().stream().map(this::addressOf).toList();
        cluster.manager().tell(new JoinSeedNodes(seeds));
        Map<String, Object> fields = fields("starts", cluster.selfMember().address());
        fields.put("agents", agents());
        fields.put("agentPort", host.address().getPort());
        fields.put("pid", ProcessHandle.current().pid());
        events.happened("cluster", fields);
        host.join(() -> elsewhere, this::state);
        keeper.start();
    }

    private Address addressOf(NodeAddress seed) {
        return new Address("pekko", settings.cluster(), seed.host(), seed.port());
    }

    private WorldActor.Opener opener(String world) {
        return whenClosed -> host.open(world, () -> plans.of(world), whenClosed);
    }

    /** Returns the address at which the other nodes reach this node. */
    public NodeAddress address() {
        return textOf(cluster.selfMember().address());
    }

    private static NodeAddress textOf(Address address) {
        return new NodeAddress(address.getHost().orElse(""), address.getPort().orElse(0));
    }

    private Map<String, Object> fields(String status, Address address) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("cluster", settings.cluster());
        fields.put("node", textOf(address).toString());
        fields.put("status", status);
        return fields;
    }

    /** Returns the actor that reports nodes that come and go. */
    private Behavior<ClusterEvent.MemberEvent> members() {
        return Behaviors.setup(
                context -> {
                    Cluster.get(context.getSystem())
                            .subscriptions()
                            .tell(
                                    new Subscribe<>(
                                            context.getSelf(), ClusterEvent.MemberEvent.class));
                    return Behaviors.receiveMessage(
                            event -> {
                                tell(event);
                                return Behaviors.same();
                            });
                });
    }

    private void tell(ClusterEvent.MemberEvent event) {
        String status =
                switch (event) {
                    case ClusterEvent.MemberUp _ -> "up";
                    case ClusterEvent.MemberRemoved removed ->
                            removed.previousStatus() == MemberStatus.down() ? "lost" : "left";
                    default -> "";
                };
        if (!status.isEmpty()) {
            events.happened("cluster", fields(status, event.member().address()));
        }
    }

    /** Waits until the node has joined the cluster, or ends. */
    public void awaitUp() {
        while (!stops
                && !system.getWhenTerminated().toCompletableFuture().isDone()
                && cluster.selfMember().status() != MemberStatus.up()) {
            LockSupport.parkNanos(LOOK_NANOSECONDS / 20);
        }
    }

    /**
     * Returns whether the owner of a world has not extended its lease for as long as a lease lasts,
     * by the clock of this process. The clock of the database may have been set back.
     */
    private boolean isSilent(PostgresStore.World world) {
        long now = System.nanoTime();
        Lease seen = leases.get(world.name());
        if (seen == null || !seen.until().equals(world.lease())) {
            leases.put(world.name(), new Lease(world.lease(), now));
            return false;
        }
        return now - seen.sinceNanos() > SILENCE_NANOSECONDS;
    }

    /** Wakes the worlds that no server runs. */
    private void keep() {
        ClusterSharding sharding = ClusterSharding.get(system);
        boolean isAway = false;
        while (!stops) {
            LockSupport.parkNanos(LOOK_NANOSECONDS);
            if (stops || cluster.selfMember().status() != MemberStatus.up()) {
                continue;
            }
            try {
                worlds = catalog.worlds();
                elsewhere = elsewhere(worlds);
                for (PostgresStore.World world : worlds) {
                    if (!world.isOwned() || isSilent(world)) {
                        sharding.entityRefFor(WORLDS, world.name())
                                .tell(WorldCommand.Wake.INSTANCE);
                    }
                }
                isAway = false;
            } catch (IOException | RuntimeException away) {
                if (!isAway && !stops) {
                    fault(away.getMessage() + "; this node starts no worlds until it can");
                }
                isAway = true;
            }
        }
    }

    /**
     * Returns the addresses of worlds for clients of this node. A world that this node closes is at
     * no address until another node opens it.
     */
    private Map<String, String> elsewhere(List<PostgresStore.World> worlds) {
        String here = agents();
        Map<String, String> found = new HashMap<>();
        worlds.forEach(
                world ->
                        found.put(world.name(), world.agents().equals(here) ? "" : world.agents()));
        return Map.copyOf(found);
    }

    /** Returns the address of this node for agents. */
    private String agents() {
        return host.address().getHostString() + ":" + host.address().getPort();
    }

    /**
     * Returns the nodes and worlds of the cluster, for operators: as this node knows them, and as
     * the database had them at most about a second ago.
     */
    public Map<String, Object> state() {
        List<PostgresStore.World> known = worlds;
        var members = cluster.state();
        Set<Address> unreachable = new HashSet<>();
        members.getUnreachable().forEach(member -> unreachable.add(member.address()));
        Map<String, Member> sorted = new TreeMap<>();
        members.getMembers()
                .forEach(member -> sorted.put(textOf(member.address()).toString(), member));
        List<Map<String, Object>> nodes = new ArrayList<>();
        Map<String, String> nodesByAgents = new HashMap<>();
        sorted.forEach(
                (address, member) -> {
                    String agents = agentsOf(member);
                    nodesByAgents.put(agents, address);
                    Map<String, Object> node = new LinkedHashMap<>();
                    node.put("node", address);
                    node.put(
                            "status",
                            unreachable.contains(member.address())
                                    ? "unreachable"
                                    : member.status().toString().toLowerCase(Locale.ROOT));
                    node.put("agents", agents);
                    node.put(
                            "worlds",
                            known.stream().filter(world -> world.agents().equals(agents)).count());
                    nodes.add(node);
                });
        Map<String, Object> state = new LinkedHashMap<>();
        state.put("cluster", settings.cluster());
        state.put("node", address().toString());
        state.put("nodes", nodes);
        state.put(
                "worlds",
                known.stream()
                        .map(world -> fields(world, nodesByAgents.get(world.agents())))
                        .toList());
        return state;
    }

    private static Map<String, Object> fields(PostgresStore.World world, @Nullable String node) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", world.name());
        if (node != null) {
            fields.put("node", node);
        }
        fields.put("agents", world.agents());
        fields.put("frame", world.frame());
        fields.put("epoch", world.epoch());
        fields.put("running", world.isOwned());
        return fields;
    }

    /** Returns the address for agents that a node announces as one of its roles. */
    private static String agentsOf(Member member) {
        for (String role : member.getRoles()) {
            if (role.startsWith(AGENTS)) {
                return role.substring(AGENTS.length());
            }
        }
        return "";
    }

    private void fault(String message) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", "cluster");
        fields.put("message", message);
        events.happened("fault", fields);
    }

    /**
     * Leaves the cluster: the worlds of this node are closed, and other nodes run them. Returns at
     * once; {@link #await} waits for the end.
     */
    public void stop() {
        stops = true;
        host.willClose();
        system.terminate();
    }

    /**
     * Waits until the node has left the cluster.
     *
     * @return why the cluster has removed the node; empty if {@link #stop} was called
     */
    public Optional<String> await() {
        system.getWhenTerminated().toCompletableFuture().join();
        if (stops) {
            return Optional.empty();
        }
        stops = true;
        String reason =
                "the cluster "
                        + settings.cluster()
                        + " has removed this node, because the others could not reach it; its"
                        + " worlds run elsewhere. See that the nodes and the database can be"
                        + " reached, and start it again";
        fault(reason);
        return Optional.of(reason);
    }

    /** Leaves the cluster and waits for the end. Idempotent. */
    @Override
    public void close() {
        if (!stops) {
            stop();
        }
        system.getWhenTerminated().toCompletableFuture().join();
        try {
            keeper.join();
            catalog.close();
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        } catch (IOException disconnected) {
            // The exception is ignored, because the connection is not needed any more.
        }
    }
}
