package reve.worlds.server;

import java.util.List;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;
import reve.core.derive.BoundingBoxes;
import reve.core.file.LawReference;
import reve.core.file.WorldDescription;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.adapter.PhysicsAdapter;
import reve.pe.adapter.PropertyNames;
import reve.pe.adapter.SharedArena;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;
import reve.worlds.Product;

/**
 * A world with everything that moves it: commands, laws, derived properties, snapshots. The thread
 * that makes it owns it until another one runs its loop.
 */
public final class Simulation implements AutoCloseable {
    private static final Logger LOG = LoggerFactory.getLogger("laws");
    private static final int COMMAND_CAPACITY = 1 << 16;
    private static final int SNAPSHOT_SLOTS = 4;

    private final WorldDescription description;
    private final Closing closing = new Closing();
    private final World world;
    private final FrameBus bus = new FrameBus();
    private final CommandQueue commands = new CommandQueue(COMMAND_CAPACITY);
    private final SnapshotRing snapshots;
    private final FrameLoop loop;
    private final PhysicsEngine engine;
    private final PhysicsAdapter physics;
    private final RunEvents events = new RunEvents();
    private long snapshotNanoseconds;

    /**
     * Builds the world and loads its laws.
     *
     * @throws PhysicsException naming the place in the world file, if a law does not load or fit
     */
    public Simulation(WorldDescription description, Pacing pacing) {
        this.description = description;
        try {
            SharedArena arena = closing.add(new SharedArena());
            world = description.build(arena);
            engine = closing.add(new VesperEngine(config(), PropertyNames.prototype(
                    world.prototype(), VesperEngine.standardPrototype(world.prototype().name()))));
            physics = closing.add(new PhysicsAdapter(world, engine, arena));
            snapshots = new SnapshotRing(world, SNAPSHOT_SLOTS);
            loop = new FrameLoop(world, bus, description.timing(), pacing);
            description.laws().forEach(this::load);
        } catch (RuntimeException refused) {
            closing.closeAfter(refused);
            throw refused;
        }
        commands.subscribeTo(bus);
        bus.subscribe(FramePhase.PHYSICS, "physics", physics);
        BoundingBoxes.subscribeTo(bus);
        onPublish("snapshots", this::publish);
        onPublish("run events", events);
    }

    private static VesperConfig config() {
        return new VesperConfig(1, false, List.of(Product.nativeFolder().resolve("laws")),
                Simulation::log);
    }

    /** What engine and laws have to say; the log drops lines rather than keep the world waiting. */
    private static void log(System.Logger.Level level, String message) {
        switch (level) {
            case ERROR -> LOG.error(message);
            case WARNING -> LOG.warn(message);
            case INFO -> LOG.info(message);
            default -> LOG.debug(message);
        }
    }

    private void load(LawReference law) {
        try (PreparedLibrary prepared = engine.prepare(law.name())) {
            physics.laws().load(0, prepared, law.parameters());
        } catch (PhysicsException refused) {
            throw new PhysicsException(refused.status(), law.place() + ": " + refused.getMessage());
        }
    }

    private void publish(FrameEvent frame) {
        long start = System.nanoTime();
        snapshots.publish(frame.frame(), frame.timeSeconds());
        snapshotNanoseconds += System.nanoTime() - start;
    }

    /** What the world was built from. */
    public WorldDescription description() {
        return description;
    }

    public World world() {
        return world;
    }

    public FrameBus bus() {
        return bus;
    }

    public FrameLoop loop() {
        return loop;
    }

    /** The way into the world from other threads. */
    public CommandQueue commands() {
        return commands;
    }

    /** What other threads read. */
    public SnapshotRing snapshots() {
        return snapshots;
    }

    /** Time spent on copying the world into snapshots [ns]. World's thread. */
    public long snapshotNanoseconds() {
        return snapshotNanoseconds;
    }

    public PhysicsEngine engine() {
        return engine;
    }

    public PhysicsAdapter physics() {
        return physics;
    }

    /** What happened so far. World's thread. */
    public RunEvents events() {
        return events;
    }

    /** Calls a listener in PUBLISH of each frame, when its snapshot can be acquired. */
    public void onPublish(String name, FrameListener listener) {
        bus.subscribe(FramePhase.PUBLISH, name, listener);
    }

    /** Frees the engine and the columns; the loop has ended. May be called twice. */
    @Override
    public void close() {
        closing.close();
    }
}
