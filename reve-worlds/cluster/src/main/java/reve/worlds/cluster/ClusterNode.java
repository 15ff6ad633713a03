// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import com.sun.management.UnixOperatingSystemMXBean;
import com.typesafe.config.Config;
import com.typesafe.config.ConfigFactory;

import org.apache.pekko.actor.Address;
import org.apache.pekko.actor.CoordinatedShutdown;
import org.apache.pekko.actor.typed.ActorSystem;
import org.apache.pekko.actor.typed.Behavior;
import org.apache.pekko.actor.typed.javadsl.Behaviors;
import org.apache.pekko.cluster.ClusterEvent;
import org.apache.pekko.cluster.MemberStatus;
import org.apache.pekko.cluster.sharding.ShardCoordinator;
import org.apache.pekko.cluster.sharding.typed.ShardingEnvelope;
import org.apache.pekko.cluster.sharding.typed.ShardingMessageExtractor;
import org.apache.pekko.cluster.sharding.typed.javadsl.ClusterSharding;
import org.apache.pekko.cluster.sharding.typed.javadsl.Entity;
import org.apache.pekko.cluster.sharding.typed.javadsl.EntityTypeKey;
import org.apache.pekko.cluster.typed.Cluster;
import org.apache.pekko.cluster.typed.JoinSeedNodes;
import org.apache.pekko.cluster.typed.Subscribe;
import org.jspecify.annotations.Nullable;

import reve.core.agent.port.ClusterPort;
import reve.core.world.ActionRefused;
import reve.worlds.Product;
import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;
import reve.worlds.server.FrameSource;
import reve.worlds.server.HostCluster;
import reve.worlds.server.ServerEvents;
import reve.worlds.server.WorldHost;
import reve.worlds.server.WorldPlan;

import java.io.IOException;
import java.lang.management.ManagementFactory;
import java.net.BindException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.ServerSocket;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Comparator;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.locks.LockSupport;
import java.util.stream.Collectors;

/**
 * A node of a cluster whose nodes share the worlds of a database. Cluster sharding places each
 * world on one node. The node opens the world from the database, in a new epoch (a number that
 * grows each time a server takes the world). Another node opens the world if this node is lost. For
 * any thread.
 */
public final class ClusterNode implements HostCluster, AutoCloseable {
    /** Interval between two readings of the list of worlds [ns]. */
    private static final long LOOK_NANOSECONDS = 1_000_000_000L;

    /** Time without a reading of the database after which it counts as away [ns]. */
    private static final long AWAY_NANOSECONDS = 3_000_000_000L;

    /**
     * Time without a reading of the database after which the leases of this node's worlds may have
     * ended [ns].
     */
    private static final long LEASE_NANOSECONDS = PostgresStore.LEASE_SECONDS * 1_000_000_000L;

    /** Time without an extension after which the lease of a world counts as ended [ns]. */
    private static final long SILENCE_NANOSECONDS = LEASE_NANOSECONDS + 1_000_000_000L;

    /** Interval between two checks whether this node is cut off [ns]. */
    private static final long CUT_OFF_NANOSECONDS = 500_000_000L;

    /** Time without a member of the cluster after which a node reports its seeds [ns]. */
    private static final long SEEDS_NANOSECONDS = 10_000_000_000L;

    /** Interval between two checks whether a world can be handed over [ns]. */
    private static final long HAND_OVER_NANOSECONDS = 200_000_000L;

    /** Maximum time for the answer of another node. */
    private static final Duration ANSWER = Duration.ofSeconds(5);

    /**
     * Version of what nodes send to each other and store for each other. A change that nodes of
     * earlier versions do not understand raises it. {@link #OLDEST_PROTOCOL} then stays, as long as
     * this program also understands and writes the earlier form.
     */
    private static final int PROTOCOL = 2;

    /** Oldest version of other nodes that this program understands. */
    private static final int OLDEST_PROTOCOL = 1;

    /** Oldest version of other nodes that can send frames to a node that watches. */
    private static final int WATCHING_PROTOCOL = 2;

    private static final EntityTypeKey<WorldCommand> WORLDS =
            EntityTypeKey.create(WorldCommand.class, "world");

    private final NodeSettings settings;
    private final WorldHost host;
    private final Plans plans;
    private final ServerEvents events;
    private final PostgresCatalog catalog;
    private final NodeDoor door;
    private final ActorSystem<ClusterEvent.MemberEvent> system;
    private final Cluster cluster;
    private final ClusterOrders orders;
    private final Thread keeper =
            Thread.ofPlatform().name("worlds of the cluster").unstarted(this::keep);
    private final Thread watcher =
            Thread.ofPlatform().name("reach of the node").unstarted(this::watch);
    private volatile boolean stops;

    /** Whether the cluster has removed this node. */
    private volatile boolean isRemoved;

    /** Addresses for agents of the other nodes, as this node knew them when it was up. */
    private volatile List<String> others = List.of();

    /** The time at which the last reading of the database began [ns]. */
    private volatile long readNanos = System.nanoTime() - AWAY_NANOSECONDS;

    /** Whether worlds of the command line are being added to the database. */
    private volatile boolean isAdding;

    /** The time at which worlds of the command line were added [ns]. */
    private volatile long addedNanos = readNanos;

    /** Addresses for agents of the worlds of other nodes, by name; for the agent server. */
    private volatile Map<String, String> elsewhere = Map.of();

    /** Addresses for agents of the other nodes that are watching. */
    private volatile List<String> watchers = List.of();

    /** Whether the list of worlds was read since the node has joined. */
    private volatile boolean hasRead;

    /** The orders about the places of worlds when they were last read. */
    private volatile PostgresCatalog.Places places = PostgresCatalog.Places.NONE;

    /** The reports of the nodes when the database was last read. */
    private volatile Map<String, PostgresCatalog.Report> reports = Map.of();

    /** The load of this machine. For the thread of the keeper. */
    private final MachineLoad machine = new MachineLoad();

    /** The worlds that slept when the database was last read. */
    private volatile Set<String> asleep = Set.of();

    /** The worlds of the database when they were last read. */
    private volatile List<PostgresStore.World> worlds = List.of();

    /** Leases of the worlds as this node saw them first. For the thread of the keeper. */
    private final Map<String, Lease> leases = new HashMap<>();

    /**
     * A lease as this node saw it first.
     *
     * @param until end of the lease by the clock of the database
     */
    private record Lease(String until, long sinceNanos) {}

    /** A function that makes the plans of the worlds of a database. */
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
        InetSocketAddress inside = freeLoopback();
        try {
            catalog.prepare();
            this.door =
                    new NodeDoor(
                            settings.listen(), inside, NodeDoor.most(descriptors()), this::fault);
        } catch (BindException unbound) {
            catalog.close();
            throw unbound(settings, unbound);
        } catch (IOException | RuntimeException refused) {
            catalog.close();
            throw refused;
        }
        try {
            this.system =
                    ActorSystem.create(
                            members(),
                            settings.cluster(),
                            config(settings, door.port(), inside, agents()));
        } catch (RuntimeException refused) {
            catalog.close();
            door.close();
            throw refused;
        }
        door.open();
        this.cluster = Cluster.get(system);
        this.orders = new ClusterOrders(catalog, this::nodes);
    }

    /**
     * Starts a node, which joins the cluster in the background and then runs its share of the
     * worlds.
     *
     * @param host runs the worlds; the caller closes it after the node
     * @throws BindException if the address for the other nodes cannot be bound
     * @throws IOException if the database is away, or other nodes have a version that does not fit
     */
    public static ClusterNode start(
            NodeSettings settings, WorldHost host, Plans plans, ServerEvents events)
            throws IOException {
        ClusterNode node = new ClusterNode(settings, host, plans, events);
        try {
            node.join();
        } catch (IOException | RuntimeException refused) {
            node.close();
            throw refused;
        }
        return node;
    }

    /** Returns an address of the loopback interface that is free now. */
    private static InetSocketAddress freeLoopback() throws IOException {
        try (ServerSocket any = new ServerSocket(0, 1, InetAddress.getLoopbackAddress())) {
            return (InetSocketAddress) any.getLocalSocketAddress();
        }
    }

    private static long descriptors() {
        return ((UnixOperatingSystemMXBean) ManagementFactory.getOperatingSystemMXBean())
                .getMaxFileDescriptorCount();
    }

    /**
     * @param port port at which other nodes reach this one
     * @param inside address of Pekko's own listener
     */
    private static Config config(
            NodeSettings settings, int port, InetSocketAddress inside, String agents) {
        Map<String, Object> values = new HashMap<>();
        values.put("pekko.remote.artery.transport", settings.tls().isPresent() ? "tls-tcp" : "tcp");
        values.put("pekko.remote.artery.canonical.hostname", settings.listen().host());
        values.put("pekko.remote.artery.canonical.port", port);
        values.put("pekko.remote.artery.bind.hostname", inside.getHostString());
        values.put("pekko.remote.artery.bind.port", inside.getPort());
        List<String> roles = new ArrayList<>(List.of(KnownNode.AGENTS + agents));
        if (settings.isWatching()) {
            roles.add(KnownNode.WATCHES);
        }
        values.put("pekko.cluster.roles", roles);
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

    private static BindException unbound(NodeSettings settings, BindException failure) {
        BindException unbound =
                new BindException(
                        "cannot listen for nodes on "
                                + settings.listen()
                                + ": "
                                + failure.getMessage()
                                + "; name another address or port (0: any free one)");
        unbound.initCause(failure);
        return unbound;
    }

    private void join() throws IOException {
        catalog.enter(address().toString(), report());
        catalog.drain(address().toString(), false); // an earlier node at this address was drained
        var balance =
                ShardCoordinator.ShardAllocationStrategy$.MODULE$.leastShardAllocationStrategy(
                        Integer.MAX_VALUE, 1.0);
        var placement =
                new WorldPlacement(
                        (ShardCoordinator.ActorSystemDependentAllocationStrategy) balance,
                        this::usablePlaces,
                        () -> asleep,
                        region -> textOf(region.path().address()),
                        () -> System.nanoTime() - readNanos < AWAY_NANOSECONDS,
                        System::nanoTime);
        ClusterSharding.get(system)
                .init(
                        Entity.of(
                                        WORLDS,
                                        context ->
                                                WorldActor.of(
                                                        opener(context.getEntityId()),
                                                        this::handOver))
                                .withMessageExtractor(new ShardPerWorld())
                                .withAllocationStrategy(placement)
                                .withStopMessage(new WorldCommand.Stop()));
        List<Address> seeds =
                settings.seeds().isEmpty()
                        ? List.of(cluster.selfMember().address())
                        : settings.seeds().stream().map(this::addressOf).toList();
        cluster.manager().tell(new JoinSeedNodes(seeds));
        Map<String, Object> fields = fields("starts", cluster.selfMember().address());
        fields.put("agents", agents());
        fields.put("agentPort", host.address().getPort());
        host.web().ifPresent(address -> fields.put("web", address + "nodes"));
        fields.put("pid", ProcessHandle.current().pid());
        events.happened("cluster", fields);
        host.join(this);
        keeper.start();
        watcher.start();
    }

    private Address addressOf(NodeAddress seed) {
        return new Address("pekko", settings.cluster(), seed.host(), seed.port());
    }

    private WorldActor.Opener opener(String world) {
        return whenClosed ->
                settings.isWatching()
                        ? refuse(world)
                        : host.open(
                                world,
                                () -> plans.of(world),
                                (reason, isAsleep) -> {
                                    whenClosed.accept(reason);
                                    if (reason.isEmpty() && !isAsleep && !stops) {
                                        wake(world); // another node opens it without a wait
                                    }
                                });
    }

    /**
     * Refuses a world that was placed here because no other node is left. The cluster places it
     * again when another node joins.
     */
    private WorldHost.Hosting refuse(String world) {
        throw new IllegalStateException("this node only watches, so it does not run " + world);
    }

    /**
     * Closes a world, so that another node opens it, as soon as the database has all of its frames.
     * Until then the world continues here. Returns at once.
     */
    private void handOver(WorldHost.Hosting hosting) {
        Thread.ofVirtual()
                .name("hand-over of a world")
                .start(
                        () -> {
                            while (!stops
                                    && !hosting.isStopped()
                                    && !(hosting.isKept() && readPlaces())) {
                                LockSupport.parkNanos(HAND_OVER_NANOSECONDS);
                            }
                            hosting.handOver();
                        });
    }

    /**
     * Reads the orders about the places of worlds, so that the agents of a world are sent to the
     * node that was ordered just now. Returns false if the database does not answer.
     */
    private boolean readPlaces() {
        try {
            places = catalog.places();
            return true;
        } catch (IOException away) {
            return false;
        }
    }

    private void wake(String world) {
        ClusterSharding.get(system).entityRefFor(WORLDS, world).tell(WorldCommand.Wake.INSTANCE);
    }

    /** Returns the address at which the other nodes reach this node. */
    public NodeAddress address() {
        return KnownNode.textOf(cluster.selfMember().address());
    }

    /** Returns the text of a node's address, which has no host if it is that of this node. */
    private String textOf(Address address) {
        return KnownNode.textOf(
                        address.getHost().isPresent() ? address : cluster.selfMember().address())
                .toString();
    }

    private List<KnownNode> nodes() {
        return KnownNode.of(cluster.state());
    }

    /** Returns the orders that can be followed now: those that name a node that is up. */
    private PostgresCatalog.Places usablePlaces() {
        PostgresCatalog.Places known = places;
        Set<String> up = new HashSet<>();
        Set<String> withoutWorlds = new HashSet<>(known.drained());
        for (KnownNode node : nodes()) {
            if (node.isUp()) {
                up.add(node.address());
            }
            if (node.isWatching()) {
                withoutWorlds.add(node.address());
            }
        }
        Map<String, String> usable = new HashMap<>(known.nodes());
        usable.values().retainAll(up);
        return new PostgresCatalog.Places(usable, withoutWorlds);
    }

    private Map<String, Object> fields(String status, Address address) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("cluster", settings.cluster());
        fields.put("node", textOf(address));
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
     * Returns whether the owner of a world has not extended its lease for the duration of a lease.
     * The clock of this process decides, because the clock of the database may have been set back.
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

    /**
     * Stops the frames of the worlds of this node while it reaches neither the database nor all
     * other nodes. Another node may then run these worlds, and would lose what their clients did
     * here. Also reports seeds that do not let the node join. Runs on a thread of its own, because
     * a read from a database that is cut off takes long.
     */
    private void watch() {
        boolean wasCutOff = false;
        boolean waits = true; // for the first member of the cluster
        long began = System.nanoTime();
        while (!stops) {
            LockSupport.parkNanos(CUT_OFF_NANOSECONDS);
            if (waits && !nodes().isEmpty()) {
                waits = false;
            } else if (waits && System.nanoTime() - began > SEEDS_NANOSECONDS) {
                waits = false;
                fault(
                        "this node has not joined the cluster "
                                + settings.cluster()
                                + " for 10 s, so it runs no worlds: no seed ("
                                + settings.seeds().stream()
                                        .map(NodeAddress::toString)
                                        .collect(Collectors.joining(", "))
                                + ") lets it in; start a node of this cluster at one of these"
                                + " addresses, and give all nodes certificates of one authority;"
                                + " this node tries again");
            }
            boolean isCutOff = isCutOff();
            host.suspend(isCutOff);
            if (isCutOff != wasCutOff) {
                fault(
                        isCutOff
                                ? "this node has not reached the database for "
                                        + PostgresStore.LEASE_SECONDS
                                        + " s, nor all other nodes, which may run its worlds: its"
                                        + " worlds make no frames until it reaches them"
                                : "this node reaches the database or the other nodes again; its"
                                        + " worlds go on");
            }
            wasCutOff = isCutOff;
        }
    }

    private boolean isCutOff() {
        return hasRead
                && !settings.isWatching()
                && System.nanoTime() - readNanos > LEASE_NANOSECONDS
                && nodes().stream().anyMatch(node -> !node.isReached());
    }

    private List<String> otherNodes() {
        String self = address().toString();
        return nodes().stream()
                .filter(node -> !node.address().equals(self) && !node.agents().isEmpty())
                .sorted(Comparator.comparing(node -> !node.isUp() || node.isWatching()))
                .map(KnownNode::agents)
                .toList();
    }

    private List<String> watchingNodes() {
        return nodes().stream()
                .filter(node -> node.isWatching() && node.isUp() && !node.agents().isEmpty())
                .map(KnownNode::agents)
                .toList();
    }

    /** Asks the cluster to run the worlds that no server runs, unless they sleep. */
    private void keep() {
        boolean isAway = false;
        while (!stops) {
            LockSupport.parkNanos(LOOK_NANOSECONDS);
            if (stops || cluster.selfMember().status() != MemberStatus.up()) {
                continue;
            }
            long began = System.nanoTime();
            others = otherNodes();
            watchers = watchingNodes();
            try {
                catalog.report(address().toString(), report());
                reports = catalog.reports();
                worlds = catalog.worlds();
                places = catalog.places();
                asleep = catalog.asleep(); // read last, so that a world that ends is not woken
                elsewhere = elsewhere(worlds);
                readNanos = began;
                hasRead = true;
                for (PostgresStore.World world : worlds) {
                    if (!asleep.contains(world.name()) && (!world.isOwned() || isSilent(world))) {
                        wake(world.name());
                    }
                }
                settings.sleepAfter().ifPresent(host::sleepUnused);
                isAway = false;
            } catch (IOException | RuntimeException away) {
                if (!isAway && !stops) {
                    fault(away.getMessage() + "; this node starts no worlds until it can");
                }
                isAway = true;
            }
        }
    }

    private PostgresCatalog.Report report() {
        return new PostgresCatalog.Report(
                new PostgresCatalog.Program(
                        Product.version(),
                        PROTOCOL,
                        settings.isWatching() ? WATCHING_PROTOCOL : OLDEST_PROTOCOL),
                new PostgresCatalog.Load(
                        host.web().orElse(""),
                        machine.cpu(),
                        machine.memory(),
                        host.agents().stats().open()));
    }

    /**
     * Returns the addresses of worlds for clients of this node. A world that this node closes has
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

    @Override
    public Map<String, String> worlds() {
        return elsewhere;
    }

    @Override
    public List<String> servers() {
        return others;
    }

    @Override
    public boolean isComplete() {
        return hasRead && !stops && !isAdding && readNanos - addedNanos >= 0;
    }

    /**
     * Reports that worlds are being added to the database. Until this node has read their names, it
     * tells clients that ask for unknown worlds to try again.
     */
    public void beginAdding() {
        isAdding = true;
    }

    /** Reports that the database has the worlds. */
    public void endAdding() {
        addedNanos = System.nanoTime();
        isAdding = false;
    }

    @Override
    public Optional<ClusterPort> cluster() {
        return Optional.of(this);
    }

    @Override
    public boolean isWatching() {
        return settings.isWatching();
    }

    @Override
    public Optional<String> forObserver(String world, String client) {
        List<String> watching = watchers;
        if (watching.isEmpty() || settings.isWatching()) {
            return Optional.empty();
        }
        int chosen = Math.floorMod((world + " " + client).hashCode(), watching.size());
        return Optional.of(watching.get(chosen));
    }

    @Override
    public Optional<String> watched(String world) {
        return host.watch(world, () -> plans.of(world), this::connect)
                ? Optional.empty()
                : Optional.of("ask the operator; this node has reported the reason");
    }

    /** Opens the stream of frames of a world of another node. */
    private FrameSource connect(String world) throws IOException, InterruptedException {
        wanted(world);
        if (elsewhere.getOrDefault(world, "").isEmpty()) {
            throw new IOException("no node runs the world " + world + " now");
        }
        try {
            String stream =
                    ClusterSharding.get(system)
                            .entityRefFor(WORLDS, world)
                            .ask(WorldCommand.Watch::new, ANSWER)
                            .toCompletableFuture()
                            .get()
                            .stream();
            if (stream.isEmpty()) {
                throw new IOException("the world " + world + " is being opened or closed");
            }
            return FrameStream.open(stream, system);
        } catch (ExecutionException silent) {
            throw new IOException(
                    "the node that runs the world "
                            + world
                            + " does not answer, or has an earlier version of REVE",
                    silent);
        }
    }

    @Override
    public void wanted(String world) {
        if (asleep.contains(world)) {
            wake(world);
        }
    }

    /** Returns whether the cluster has removed this node, or is removing it. */
    private boolean isBeingRemoved() {
        MemberStatus status = cluster.selfMember().status();
        return isRemoved
                || !stops && (status == MemberStatus.down() || status == MemberStatus.removed());
    }

    @Override
    public Optional<String> refuge(String world) {
        String there = elsewhere.getOrDefault(world, "");
        return there.isEmpty() ? others.stream().findFirst() : Optional.of(there);
    }

    @Override
    public Optional<String> next(String world) {
        if (isBeingRemoved()) {
            return refuge(world); // this node ends soon
        }
        List<KnownNode> up =
                nodes().stream()
                        .filter(KnownNode::isUp)
                        .sorted(Comparator.comparing(KnownNode::isWatching))
                        .toList();
        String wanted = places.nodes().getOrDefault(world, "");
        String self = address().toString();
        Optional<String> ordered =
                up.stream()
                        .filter(node -> node.address().equals(wanted))
                        .filter(node -> !node.address().equals(self))
                        .map(KnownNode::agents)
                        .findFirst();
        if (ordered.isPresent()) {
            return ordered;
        }
        if (!stops) {
            return Optional.of(agents()); // this node sends them on as soon as it knows the place
        }
        return up.stream()
                .filter(node -> !node.address().equals(self))
                .map(KnownNode::agents)
                .findFirst();
    }

    @Override
    public Map<String, Object> move(String world, String node) throws ActionRefused {
        return orders.move(world, node);
    }

    @Override
    public Map<String, Object> drain(String node, boolean isDrained) throws ActionRefused {
        return orders.drain(node, isDrained);
    }

    @Override
    public Map<String, Object> add(String text, boolean isAsleep) throws ActionRefused {
        Map<String, Object> added = orders.add(text, isAsleep);
        long stored = System.nanoTime();
        while (!stops // clients may ask for the world as soon as this node has read its name
                && readNanos - stored < 0
                && System.nanoTime() - stored < AWAY_NANOSECONDS) {
            LockSupport.parkNanos(LOOK_NANOSECONDS / 50);
        }
        return added;
    }

    /**
     * Returns the nodes that this node knows, and the worlds of the database, as read at most about
     * a second ago.
     */
    @Override
    public Map<String, Object> state() {
        List<PostgresStore.World> known = worlds;
        PostgresCatalog.Places ordered = places;
        Set<String> sleeping = asleep;
        List<Map<String, Object>> nodes = new ArrayList<>();
        Map<String, String> nodesByAgents = new HashMap<>();
        for (KnownNode each : nodes()) {
            nodesByAgents.put(each.agents(), each.address());
            Map<String, Object> node = new LinkedHashMap<>();
            node.put("node", each.address());
            node.put("status", each.status());
            node.put("agents", each.agents());
            node.put(
                    "worlds",
                    known.stream().filter(world -> world.agents().equals(each.agents())).count());
            node.put("drained", ordered.drained().contains(each.address()));
            if (each.isWatching()) {
                node.put("watching", true);
            }
            PostgresCatalog.Report report = reports.get(each.address());
            if (report != null) {
                PostgresCatalog.Load load = report.load();
                node.put("version", report.program().version());
                node.put("clients", load.clients());
                node.put("cpu", load.cpu());
                node.put("memory", load.memory());
                if (!load.web().isEmpty()) {
                    node.put("web", load.web());
                }
            }
            nodes.add(node);
        }
        Map<String, Object> state = new LinkedHashMap<>();
        state.put("cluster", settings.cluster());
        state.put("node", address().toString());
        state.put("nodes", nodes);
        state.put(
                "worlds",
                known.stream()
                        .map(
                                world ->
                                        fields(
                                                world,
                                                nodesByAgents.get(world.agents()),
                                                ordered.nodes().get(world.name()),
                                                sleeping.contains(world.name())))
                        .toList());
        return state;
    }

    /**
     * @param node the node that runs the world; null if no node does
     * @param ordered the node that an operator has chosen; null if the cluster chooses
     */
    private static Map<String, Object> fields(
            PostgresStore.World world,
            @Nullable String node,
            @Nullable String ordered,
            boolean isAsleep) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", world.name());
        if (node != null) {
            fields.put("node", node);
        }
        if (ordered != null) {
            fields.put("ordered", ordered);
        }
        fields.put("agents", world.agents());
        fields.put("frame", world.frame());
        fields.put("epoch", world.epoch());
        fields.put("running", world.isOwned());
        fields.put("asleep", isAsleep);
        return fields;
    }

    private void fault(String message) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", "cluster");
        fields.put("message", message);
        events.happened("fault", fields);
    }

    /**
     * Leaves the cluster. The worlds of this node are closed, and other nodes run them. Returns at
     * once; {@link #await} waits for the end.
     */
    public void stop() {
        stops = true;
        host.willClose();
        system.terminate();
    }

    /**
     * Waits until Pekko has ended, or has given up on the parts of it that do not end. Connections
     * to nodes that cannot be reached may otherwise keep it from ending for many minutes.
     */
    private void awaitEnd() {
        CompletableFuture<?> ended = system.getWhenTerminated().toCompletableFuture();
        CoordinatedShutdown shutdown = CoordinatedShutdown.get(system);
        while (!ended.isDone()) {
            if (shutdown.getShutdownReason().isPresent()) {
                // Returns the shutdown that was begun for this reason. Each of its phases has a
                // time limit.
                CompletableFuture<?> phases =
                        shutdown.runAll(shutdown.getShutdownReason().get()).toCompletableFuture();
                CompletableFuture.anyOf(ended, phases).join();
                return;
            }
            LockSupport.parkNanos(LOOK_NANOSECONDS / 20);
        }
    }

    /**
     * Waits until the node has left the cluster.
     *
     * @return why the cluster has removed the node; empty if {@link #stop} was called
     */
    public Optional<String> await() {
        awaitEnd();
        if (stops) {
            return Optional.empty();
        }
        isRemoved = true;
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
        awaitEnd();
        try {
            door.close();
            keeper.join();
            watcher.join();
            if (!isRemoved) {
                catalog.leave(address().toString());
            }
            catalog.close();
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        } catch (IOException disconnected) {
            // The exception is ignored, because the connection is not needed any more, and the
            // report of a node that has ended is soon removed by others.
        }
    }
}
