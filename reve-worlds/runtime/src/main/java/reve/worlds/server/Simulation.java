// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static java.util.stream.Collectors.toSet;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.derive.DerivedColumns;
import reve.core.derive.InertialMeasurements;
import reve.core.derive.ProvidedMeasurements;
import reve.core.file.EditReader;
import reve.core.file.LawReference;
import reve.core.file.Problem;
import reve.core.file.RuleChanges;
import reve.core.file.WorldDescription;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.frame.FrameListenerProvider;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.level.LevelKeeper;
import reve.core.plugin.Plugins;
import reve.core.rule.Rule;
import reve.core.rule.Rules;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.pe.Access;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.PropertyUse;
import reve.pe.Status;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.PhysicsAdapter;
import reve.pe.adapter.PropertyNames;
import reve.pe.adapter.SharedArena;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;
import reve.worlds.check.WorldCheck;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.SimulationImage;
import reve.worlds.journal.WorldHeader;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.function.Consumer;
import java.util.stream.Collectors;

/**
 * A world with its commands, laws, derived properties and snapshots. The thread that creates it
 * owns it until another thread runs its loop.
 */
public final class Simulation implements AutoCloseable {
    private static final Logger LOG = LoggerFactory.getLogger("laws");
    private static final int COMMAND_CAPACITY = 1 << 16;
    private static final int SNAPSHOT_SLOTS = 4;
    private static final int MAX_IMAGES = 64;
    private static final long MAX_IMAGE_BYTES = 1L << 30;

    /** The description is replaced only when its rules change. */
    private volatile WorldDescription description;

    private final LawPath lawPath;
    private final Closing closing = new Closing();
    private final World world;
    private final FrameBus bus = new FrameBus();
    private final CommandQueue commands = new CommandQueue(COMMAND_CAPACITY);
    private final SnapshotRing snapshots;
    private final FrameLoop loop;
    private final PhysicsEngine engine;
    private final PhysicsAdapter physics;
    private final InertialMeasurements inertia = new InertialMeasurements(this::gravity);
    private final Rules rules;
    private final LevelKeeper levels = new LevelKeeper();
    private final RunEvents events = new RunEvents();
    private final Set<SimulationImage> kept = ConcurrentHashMap.newKeySet();
    private long snapshotNanoseconds;

    /** Symbols of the rules of the world file. */
    private final Set<String> rulesOfFile;

    /** The changes of the rules since the world file. */
    private RuleChanges ruleChanges = RuleChanges.NONE;

    private final List<Consumer<List<RuleChanges.Change>>> ruleListeners = new ArrayList<>();

    /** Builds a world that uses shipped laws only. */
    public Simulation(WorldDescription description, Pacing pacing) {
        this(description, pacing, LawPath.ofShipped());
    }

    /**
     * Builds the world and loads its laws.
     *
     * @param lawPath search path of the laws
     * @throws PhysicsException if laws do not load or do not fit the world; the message has one
     *     line for each law, with its place in the world file
     */
    public Simulation(WorldDescription description, Pacing pacing, LawPath lawPath) {
        this(description, pacing, lawPath, Optional.empty());
    }

    /**
     * Builds the world of an image (a saved state). It continues with the same bits as the
     * simulation from which the image was taken.
     *
     * @param description the description from which that simulation was built
     * @param lawPath search path of laws that are loaded later; the image's laws are opened without
     *     a check
     * @throws IllegalArgumentException if the image belongs to a world with another prototype
     * @throws PhysicsException if a law of the image does not load
     */
    public Simulation(
            WorldDescription description, Pacing pacing, LawPath lawPath, SimulationImage image) {
        this(description, pacing, lawPath, Optional.of(image));
    }

    private Simulation(
            WorldDescription description,
            Pacing pacing,
            LawPath lawPath,
            Optional<SimulationImage> image) {
        this.description = description;
        this.rulesOfFile = description.rules().stream().map(Rule::symbol).collect(toSet());
        this.lawPath = lawPath;
        closing.add(() -> Set.copyOf(kept).forEach(SimulationImage::close));
        try {
            SharedArena arena = closing.add(new SharedArena());
            world =
                    image.isEmpty()
                            ? description.build(arena)
                            : new World(description.name(), description.prototype(), arena);
            engine =
                    closing.add(
                            lawPath.place()
                                    .engine(
                                            config(description.threads(), lawPath.validated()),
                                            PropertyNames.prototype(
                                                    world.prototype(),
                                                    VesperEngine.standardPrototype(
                                                            world.prototype().name())),
                                            lawPath::isolation,
                                            arena));
            physics = closing.add(new PhysicsAdapter(world, engine, arena));
            physics.laws().guardNames(lawPath::requireOwnName);
            snapshots = new SnapshotRing(world, SNAPSHOT_SLOTS);
            rules = new Rules(world, description.rules(), description.ruleSteps());
            loop = new FrameLoop(world, bus, description.timing(), pacing);
            physics.measureFrames(loop::busyNanoseconds);
            image.ifPresentOrElse(this::goOnFrom, this::begin);
        } catch (RuntimeException refused) {
            closing.closeAfter(refused);
            throw refused;
        }
        var flight = new FlightEvents(description.name(), loop, physics);
        bus.subscribe(FramePhase.INTAKE, "flight recorder", _ -> flight.onFrame());
        commands.subscribeTo(bus);
        levels.subscribeTo(bus);
        physics.beforeRepetition(() -> inertia.begin(world));
        bus.subscribe(
                FramePhase.PHYSICS,
                "physics",
                frame -> {
                    inertia.begin(world);
                    physics.onFrame(frame);
                });
        DerivedColumns.subscribeTo(bus);
        bus.subscribe(
                FramePhase.DERIVE,
                "inertial measurements",
                frame -> inertia.derive(world, frame.frame(), frame.dtSeconds() * frame.steps()));
        rules.subscribeTo(bus, loop::isStopped);
        onPublish("snapshots", this::publish);
        onPublish("run events", events);
    }

    /** Returns the kinds of gravity that the loaded laws exert, by the constants that they read. */
    private InertialMeasurements.Gravity gravity() {
        Set<String> used = physics.usedProperties();
        return new InertialMeasurements.Gravity(
                used.contains("gravity"), used.contains("gravitationalConstant"));
    }

    private static VesperConfig config(int threads, boolean validated) {
        return new VesperConfig(
                threads, validated, List.of(LawPath.ofShipped().shipped()), Simulation::log);
    }

    /** Logs a message of the engine or a law. The log drops lines instead of delaying the world. */
    private static void log(System.Logger.Level level, String message) {
        switch (level) {
            case ERROR -> LOG.error(message);
            case WARNING -> LOG.warn(message);
            case INFO -> LOG.info(message);
            default -> LOG.debug(message);
        }
    }

    /** Sets the engine's step count to the world's age, so that laws see the right time. */
    private void begin() {
        loadAll(description.laws());
        engine.setStepCount(
                description.age() * description.timing().stepsPerFrame(),
                description.timing().dtSeconds());
    }

    /** Loads all laws. Continues after a refusal, so that one exception reports all mistakes. */
    private void loadAll(List<LawReference> laws) {
        List<PhysicsException> refusals = new ArrayList<>();
        for (LawReference law : laws) {
            if (lawPath.isExcluded(law.name())) {
                continue;
            }
            try {
                load(law);
            } catch (PhysicsException refused) {
                refusals.add(refused);
            }
        }
        if (!refusals.isEmpty()) {
            throw new PhysicsException(
                    refusals.getFirst().status(),
                    refusals.stream()
                            .map(PhysicsException::getMessage)
                            .collect(Collectors.joining("\n")));
        }
    }

    private void load(LawReference law) {
        Status status = Status.INVALID_ARGUMENT;
        List<String> problems;
        try {
            int id =
                    law.text().isPresent()
                            ? loadText(law, law.text().get())
                            : loadFound(law, lawPath.find(law.name()));
            problems = List.copyOf(LawParameters.wrongUnits(law, engine.laws(id)).values());
            budget(law);
        } catch (PhysicsException refused) {
            status = refused.status();
            problems = LawParameters.refused(law, refused, engine, lawPath);
        }
        if (!problems.isEmpty()) {
            throw new PhysicsException(status, String.join("\n", problems));
        }
    }

    /** Loads a law from a file, and returns the id of its library. */
    private int loadFound(LawReference law, LawPath.Found found) {
        lawPath.hidden(law.name(), found).ifPresent(LOG::warn);
        try (PreparedLibrary prepared = lawPath.prepare(engine, law.name(), found)) {
            int id = physics.laws().load(0, prepared, law.parameters(), found.file());
            if (found.origin() == LawPath.Origin.FOLDER
                    || found.origin() == LawPath.Origin.UNTRUSTED) {
                physics.laws().leaveToFolder(id);
            }
            return id;
        }
    }

    /** Loads a law that the world file contains, and returns the id of its library. */
    private int loadText(LawReference law, String text) {
        byte[] bytes = text.getBytes(StandardCharsets.UTF_8);
        try (PreparedLibrary prepared = engine.prepareText(law.name() + ".law", bytes)) {
            return physics.laws().load(0, prepared, law.parameters(), Path.of(law.name() + ".law"));
        }
    }

    /**
     * Unloads the libraries of a restored state that the search path of laws excludes. Called
     * between frames.
     */
    void unloadExcluded() {
        physics.laws()
                .byId()
                .forEach(
                        (id, library) -> {
                            if (lawPath.isExcluded(library.name())) {
                                physics.laws().unload(loop.frame(), id);
                            }
                        });
    }

    /** Sets the budget of the library that was loaded last. */
    private void budget(LawReference law) {
        if (law.budget().isPresent()) {
            try {
                physics.laws().setBudget(physics.laws().latestName(), law.budget());
            } catch (PhysicsException refused) {
                throw new PhysicsException(refused.status(), "its budget: " + refused.getMessage());
            }
        }
    }

    /** Returns the folder of the laws that ship. For any thread. */
    Path shippedLaws() {
        return lawPath.shipped();
    }

    /**
     * Opens the library of a law by its name. For any thread.
     *
     * @throws PhysicsException if there is none, or it may not be opened
     */
    PreparedLibrary prepare(String law) {
        return lawPath.prepare(engine, law, lawPath.find(law));
    }

    /** Returns why {@link #prepare} refused a law, without the folders of the server. */
    String reasonForClients(String law, PhysicsException refused) {
        return lawPath.reasonForClients(law, refused);
    }

    /** Returns the names of the libraries that {@link #prepare} finds, in alphabetical order. */
    List<String> lawNames() {
        return lawPath.names();
    }

    /** Returns the file of a law's library; throws as {@link #prepare}. */
    Path fileOf(String law) {
        return lawPath.find(law).file();
    }

    private void publish(FrameEvent frame) {
        long start = System.nanoTime();
        snapshots.publish(frame.frame(), frame.timeSeconds());
        snapshotNanoseconds += System.nanoTime() - start;
    }

    /**
     * Returns warnings about the described world with its loaded laws, for example about values
     * without effect, bodies that fall for ever, and steps that are too long. Called between
     * frames.
     *
     * @param complete whether all laws of the world are loaded
     */
    public List<Problem> warnings(boolean complete) {
        Set<Integer> texts = new HashSet<>();
        physics.laws()
                .byId()
                .forEach(
                        (id, library) -> {
                            if (library.isText()) {
                                texts.add(id);
                            }
                        });
        return WorldCheck.warnings(
                description, engine.laws(), texts, lawPath.shippedNames(), complete);
    }

    /** Returns the description from which the world was built. */
    public WorldDescription description() {
        return description;
    }

    /** Returns the world. For the world's thread only. */
    public World world() {
        return world;
    }

    /**
     * Returns a description of the current world, with the laws that are loaded now. For the
     * world's thread.
     */
    public WorldDescription descriptionNow() {
        return descriptionNow(description);
    }

    /**
     * Returns a description of the current world like {@link #descriptionNow()}.
     *
     * @param file has the parts that a world itself does not have: camera, agents and rules
     */
    WorldDescription descriptionNow(WorldDescription file) {
        return file.of(
                world,
                physics.laws().libraries().stream()
                        .map(
                                library ->
                                        new LawReference(
                                                nameOf(library),
                                                textOf(library),
                                                library.parameters(),
                                                library.budget(),
                                                library.name(),
                                                Map.of()))
                        .toList());
    }

    /** Returns the text of a law that was loaded as text, so that a saved world contains it. */
    private Optional<String> textOf(LawLibrary library) {
        return library.isText() && !lawPath.ships(library)
                ? Optional.of(new String(library.bytes(), StandardCharsets.UTF_8))
                : Optional.empty();
    }

    /**
     * Returns the name by which a world file refers to the library. The name of a shipped text
     * includes ".law", because the bare name means the compiled library.
     */
    private String nameOf(LawLibrary library) {
        return library.isText() && lawPath.ships(library)
                ? library.name() + ".law"
                : library.name();
    }

    /**
     * Returns one message for each part of the world that {@link #descriptionNow} cannot describe.
     * For the world's thread only.
     */
    public List<String> notDescribed() {
        List<String> left = new ArrayList<>();
        for (PhysicsLaw law : physics.laws().loaded()) {
            List<String> own =
                    law.uses().stream()
                            .filter(use -> use.access().contains(Access.SCRATCH))
                            .map(PropertyUse::name)
                            .toList();
            if (!own.isEmpty()) {
                left.add(
                        "what "
                                + law.name()
                                + " remembers of earlier steps ("
                                + String.join(", ", own)
                                + ")");
            }
        }
        for (LawLibrary library : physics.laws().libraries()) {
            if (library.interval() > 1) {
                left.add(
                        "that the laws of "
                                + library.name()
                                + " are evaluated once in "
                                + library.interval()
                                + " steps");
            }
        }
        return left;
    }

    /**
     * Replaces the rules. The symbols that they derive change in the next frame. Journals contain
     * the changes. For the world's thread, outside DERIVE.
     */
    public void setRules(List<Rule> newRules) {
        List<RuleChanges.Change> made = RuleChanges.between(description.rules(), newRules);
        rules.set(newRules);
        description = description.withRules(newRules);
        ruleChanges = ruleChanges.with(made, rulesOfFile::contains);
        ruleListeners.forEach(listener -> listener.accept(made));
    }

    /**
     * Gives a restored world the rules of its world file after the changes of the run that made its
     * state. Removes the symbols of all other rules from its items. For the world's thread, between
     * frames.
     *
     * @param problems receives one message for each change that cannot be made
     */
    void repeatRules(RuleChanges changes, Consumer<String> problems) {
        List<Rule> now =
                new EditReader(world.prototype()).rules(description.rules(), changes, problems);
        Set<String> kept = now.stream().map(Rule::symbol).collect(toSet());
        kept.removeAll(changes.symbols());
        world.items().forEach(item -> item.semantic().dropDerived(name -> !kept.contains(name)));
        rules.set(now);
        description = description.withRules(now);
        ruleChanges = changes;
    }

    /** Returns the bus on which components subscribe to phases of the frame. */
    public FrameBus bus() {
        return bus;
    }

    /** Returns the loop that makes the frames. */
    public FrameLoop loop() {
        return loop;
    }

    /** Returns the queue for commands from other threads. */
    public CommandQueue commands() {
        return commands;
    }

    /** Returns the snapshots, which other threads read. */
    public SnapshotRing snapshots() {
        return snapshots;
    }

    /**
     * Returns the time spent on copying the world into snapshots [ns]. For the world's thread only.
     */
    public long snapshotNanoseconds() {
        return snapshotNanoseconds;
    }

    /** Returns the engine under the adapter. For the world's thread only. */
    public PhysicsEngine engine() {
        return engine;
    }

    /** Returns the adapter that applies laws in PHYSICS. For the world's thread only. */
    public PhysicsAdapter physics() {
        return physics;
    }

    /** Returns the events so far. For the world's thread only. */
    public RunEvents events() {
        return events;
    }

    /**
     * Takes an image of the current state, for {@link #rewind} and {@link #fork}. The image stays
     * valid until it or the simulation is closed. Taking it costs one bulk copy of the columns. For
     * the world's thread, between frames.
     *
     * @throws IllegalStateException if the maximum number or size of images is reached, or the
     *     engine cannot be asked for its state
     */
    public SimulationImage keep() {
        if (!hasRoomForImage()) {
            throw new IllegalStateException(
                    kept.size()
                            + " images of "
                            + keptBytes()
                            + " bytes in all "
                            + "are kept, at most "
                            + MAX_IMAGES
                            + " and "
                            + MAX_IMAGE_BYTES
                            + " bytes may be: close one first");
        }
        SimulationImage image = new SimulationImage(world, kept::remove);
        try {
            image.copyFrom(world, physics, loop.frame());
        } catch (RuntimeException failed) {
            image.close();
            throw failed;
        }
        kept.add(image);
        return image;
    }

    /** Returns whether {@link #keep} may take one more image. */
    public boolean hasRoomForImage() {
        return kept.size() < MAX_IMAGES && keptBytes() < MAX_IMAGE_BYTES;
    }

    private long keptBytes() {
        return kept.stream().mapToLong(SimulationImage::bytes).sum();
    }

    /**
     * Restores time, items and laws from an image. The same inputs then produce the same frames,
     * with equal bits. Frame numbers continue, and the next frame shows the restored world. Data
     * that clients have received is not withdrawn. Nothing has changed if the restore fails. For
     * the world's thread, between frames.
     *
     * @return the number of the next frame
     * @throws IllegalStateException if a frame is in progress, or no process can be started for the
     *     engine
     * @throws PhysicsException if the engine refuses a library or the state of the image
     */
    public long rewind(SimulationImage image) {
        long frame = loop.frame() + 1;
        restore(image, frame);
        return frame;
    }

    /**
     * Restores an image, and continues with the frame after the image's frame. The image must not
     * be older than the current frame. For the world's thread only.
     */
    void goOnFrom(SimulationImage image) {
        restore(image, image.frame());
    }

    /**
     * Returns an image of the world as its file describes it, before the first frame. For any
     * thread; the caller closes it.
     */
    SimulationImage beginning() {
        try (Simulation begun = new Simulation(description, Pacing.FAST, lawPath)) {
            begun.loop().run(0);
            SimulationImage image = new SimulationImage(begun.world());
            image.copyFrom(begun.world(), begun.physics(), 0);
            return image;
        }
    }

    /**
     * Returns a second world that starts from the image and shares nothing with this one. It is
     * used to predict the future of the world. For any thread. The caller runs its loop, reads its
     * snapshots and closes it.
     */
    public Simulation fork(SimulationImage image) {
        return new Simulation(description, Pacing.FAST, lawPath, image);
    }

    /**
     * Returns a second world like {@link #fork}, but without the rules, because laws do not use
     * them. It does not evaluate conditions of levels, because its caller repeats the changes of
     * this world.
     */
    Simulation shadow(SimulationImage image) {
        var shadow = new Simulation(description.withRules(List.of()), Pacing.FAST, lawPath, image);
        shadow.repeatLevels(true);
        return shadow;
    }

    /**
     * Stops or continues the evaluation of the conditions of levels. It is stopped while the
     * simulation repeats the changes of another run. Called between frames.
     */
    void repeatLevels(boolean repeats) {
        levels.pause(repeats);
    }

    /**
     * Starts a journal. Its first record is an image of the next published frame. For the world's
     * thread, between frames, after all other listeners have subscribed to ACT. The caller closes
     * the journal before the simulation.
     *
     * @param folder the folder of the world file
     * @param members ids of the bodies of agents in the world, by agent
     */
    public Journal journal(
            Path folder,
            Map<String, Long> members,
            Journal.Plan plan,
            JournalSink sink,
            Consumer<String> problems) {
        WorldHeader header = header(folder);
        lawPath.remember(physics.laws().libraries());
        physics.laws()
                .addListener(
                        change ->
                                change.brought()
                                        .ifPresent(
                                                library ->
                                                        // Another thread reads the file of the
                                                        // library, so that the world is not
                                                        // delayed.
                                                        Thread.ofVirtual()
                                                                .start(
                                                                        () ->
                                                                                lawPath.remember(
                                                                                        List.of(
                                                                                                library)))));
        Journal journal =
                new Journal(
                        header,
                        world,
                        physics,
                        bus,
                        members,
                        () -> ruleChanges,
                        plan,
                        sink,
                        problems);
        ruleListeners.add(journal::rulesChanged);
        return journal;
    }

    /**
     * Returns the header of the world's frames.
     *
     * @param folder the folder of the world file
     */
    WorldHeader header(Path folder) {
        return new WorldHeader(
                description.name(),
                description.prototype(),
                description.timing(),
                folder,
                Plugins.current().infos());
    }

    private void restore(SimulationImage image, long frame) {
        loop.requireContinuable(frame);
        physics.restore(frame, image.physics(), () -> world.restore(image.world()));
        rules.forget();
        inertia.forget();
        loop.continueAfter(frame);
    }

    /**
     * Subscribes a listener that is called in PUBLISH of each frame, when the frame's snapshot is
     * available.
     */
    public void onPublish(String name, FrameListener listener) {
        bus.subscribe(FramePhase.PUBLISH, name, listener);
    }

    /**
     * Adds the frame listeners of the plugins of the calling thread. Not called for a replay,
     * because a recording contains the changes that listeners made. For the world's thread, between
     * frames, before a {@link #journal}, once.
     */
    public void usePluginListeners() {
        for (FrameListenerProvider provider : Plugins.current().listeners()) {
            PluginListener.subscribe(world, loop.frame(), bus, provider);
        }
    }

    /**
     * Makes the sensors that are written in Java measure in each frame, for agents. For the world's
     * thread, between frames, once.
     */
    void measureProvidedSensors() {
        ProvidedMeasurements.subscribeTo(bus);
    }

    /** Frees the engine and the columns, after the loop has ended. Idempotent. */
    @Override
    public void close() {
        closing.close();
    }
}
