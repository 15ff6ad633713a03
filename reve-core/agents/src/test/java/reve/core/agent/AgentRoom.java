// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.net.Connections;
import reve.core.agent.port.Cameras;
import reve.core.agent.port.SessionNote;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.derive.DerivedColumns;
import reve.core.file.AgentPolicy;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.unit.Unit;
import reve.core.world.Action;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.TestAction;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.io.IOException;
import java.time.Duration;
import java.util.List;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.function.BooleanSupplier;

/**
 * The world of the protocol's example session, stepped by hand, with a real server on an ephemeral
 * port.
 */
public final class AgentRoom implements AutoCloseable {

    /** Limits of the protocol, but clients of tests on a busy machine have minutes. */
    public static final AgentServerConfig CONFIG = patient();

    private static final Parameter IMPULSE =
            Parameter.number("impulse", 3, Unit.parse("N*s"), "How hard.");

    public final World world =
            new World("pond", WorldPrototype.standard("si-f64"), new OffHeapArena());
    public final FrameBus bus = new FrameBus();
    final CommandQueue commands;
    public final FrameLoop loop;
    public final WorldPort port;
    public final AgentServer server;

    /** Problems with the server's files. Any thread may use this queue. */
    public final Queue<String> problems = new ConcurrentLinkedQueue<>();

    /** The notes about the sessions of the world. Any thread may use this queue. */
    public final Queue<SessionNote> notes = new ConcurrentLinkedQueue<>();

    /** Any thread may read and set this field. */
    volatile Cameras cameras = Cameras.none();

    public AgentRoom() throws IOException {
        this(CONFIG);
    }

    public AgentRoom(AgentServerConfig config) throws IOException {
        this(config, making(), 4096);
    }

    public AgentRoom(AgentServerConfig config, AgentPolicy policy, int commandCapacity)
            throws IOException {
        this(config, policy, commandCapacity, List.of(duck()));
    }

    public AgentRoom(
            AgentServerConfig config,
            AgentPolicy policy,
            int commandCapacity,
            List<ItemDefinition> items)
            throws IOException {
        items.forEach(world::add);
        commands = new CommandQueue(commandCapacity);
        commands.subscribeTo(bus);
        DerivedColumns.subscribeTo(bus);
        var snapshots = new SnapshotRing(world, 3);
        bus.subscribe(
                FramePhase.PUBLISH,
                "snapshots",
                event -> snapshots.publish(event.frame(), event.timeSeconds()));
        loop = new FrameLoop(world, bus, new Timing(60, 1), Pacing.FAST);
        port =
                new WorldPort(
                        world.name(),
                        60,
                        policy,
                        bus,
                        commands,
                        snapshots,
                        loop,
                        new RoomControl(world, loop),
                        (body, camera, answer) -> cameras.take(body, camera, answer),
                        notes::add);
        server =
                AgentServer.start(
                        config,
                        List.of(port),
                        (source, message) -> problems.add(source + ": " + message));
    }

    static AgentPolicy lending(String... bodies) {
        return new AgentPolicy(List.of(bodies), Optional.empty());
    }

    public static AgentPolicy making() {
        ItemDefinition body =
                ItemDefinition.named("body").shape(Shape.box(0.5, 1, 0.5)).at(0, 0.5, 0).build();
        return new AgentPolicy(List.of(), Optional.of(body));
    }

    public static ItemDefinition duck() {
        return ItemDefinition.named("duck")
                .shape(Shape.sphere(0.25))
                .at(1, 0, -2.5)
                .symbol("class", "toy")
                .physics("mass", 2)
                .physics("velocity", 0, 0, 0)
                .action(
                        new DeclaredAction(
                                "push",
                                "Gives it a kick.",
                                List.of(IMPULSE),
                                List.of(new Effect.Impulse(new Operand.Argument(IMPULSE)))))
                .action(
                        new DeclaredAction(
                                "wind-up",
                                "Winds its spring.",
                                List.of(),
                                List.of(new Effect.SetSymbol("wound", new Operand.Symbol(true)))))
                .build();
    }

    private static AgentServerConfig patient() {
        AgentServerConfig usual = AgentServerConfig.onPort(0);
        AgentTimeouts t = usual.timeouts();
        Duration minutes = Duration.ofMinutes(5);
        return new AgentServerConfig(
                usual.address(),
                usual.limits(),
                new AgentTimeouts(
                        minutes,
                        minutes,
                        minutes,
                        t.flood(),
                        minutes,
                        t.grace(),
                        minutes,
                        t.waiting(),
                        t.linger()),
                usual.audit(),
                usual.security());
    }

    /** Limits of milliseconds, for tests that wait until a limit is reached. */
    public static AgentServerConfig config(
            Duration hello, Duration line, Duration idle, Duration write) {
        var limits =
                new AgentLimits(1024, 8192, 4096, 10_000_000, 4, 64, 64 * 1024, 8, 16, 8, 100_000);
        var timeouts =
                new AgentTimeouts(
                        hello,
                        line,
                        idle,
                        Duration.ofSeconds(10),
                        write,
                        Duration.ofMinutes(5),
                        Duration.ofSeconds(10),
                        CONFIG.timeouts().waiting(),
                        Duration.ofMillis(500));
        return new AgentServerConfig(
                CONFIG.address(), limits, timeouts, Optional.empty(), AgentSecurity.NONE);
    }

    /** The room's usual limits, for tests that resume a session again and again. */
    public static AgentServerConfig resumedOften() {
        AgentLimits l = CONFIG.limits();
        var limits =
                new AgentLimits(
                        l.maxConnections(),
                        l.helloBytes(),
                        l.lineBytes(),
                        l.messagesPerSecond(),
                        l.actsInFlight(),
                        l.outboxMessages(),
                        l.outboxBytes(),
                        l.maxErrors(),
                        l.kept(),
                        Integer.MAX_VALUE,
                        l.hellos());
        return new AgentServerConfig(
                CONFIG.address(), limits, CONFIG.timeouts(), Optional.empty(), CONFIG.security());
    }

    /** Makes one frame. */
    public void step() {
        loop.step();
    }

    /** Makes frames until a condition is true. Fails if it is not true after ten minutes. */
    public void stepUntil(String what, BooleanSupplier isSo) {
        stepUntil(what, Duration.ofMinutes(10), isSo);
    }

    /**
     * @param patience time after which the method fails
     */
    public void stepUntil(String what, Duration patience, BooleanSupplier isSo) {
        long deadline = System.nanoTime() + patience.toNanos();
        while (!isSo.getAsBoolean()) {
            if (System.nanoTime() > deadline) {
                throw new AssertionError("not so after " + loop.frame() + " frames: " + what);
            }
            step();
        }
    }

    public Item item(String name) {
        return world.find(name).orElseThrow(() -> new AssertionError("no item " + name));
    }

    public boolean has(String name) {
        return world.find(name).isPresent();
    }

    public TestClient connect() throws IOException {
        return new TestClient(server.address());
    }

    /** Returns a client whose agent has joined. This takes one frame. */
    public TestClient join(String name) throws IOException {
        TestClient client =
                connect().say("{'t':'hello','protocol':1,'name':'" + name + "'}").sync();
        step();
        client.expect("welcome");
        client.expect("event");
        return client;
    }

    /** The server's connections, for tests of its sockets. */
    public Connections connections() {
        return server.connections();
    }

    @Override
    public void close() {
        server.close();
    }

    /** An action whose designer made a mistake. */
    static Action broken() {
        return new TestAction(
                "explode",
                "Has an error.",
                call -> {
                    throw new IllegalStateException("an error in an action");
                });
    }
}
