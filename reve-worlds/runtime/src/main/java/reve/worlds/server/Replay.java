// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.file.EditReader;
import reve.core.file.RuleChanges;
import reve.core.file.WorldDescription;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Subscription;
import reve.core.frame.Timing;
import reve.core.image.CorruptException;
import reve.core.image.Trees;
import reve.core.image.WorldDigest;
import reve.core.plugin.Plugins;
import reve.core.rule.Rule;
import reve.core.world.ItemId;
import reve.pe.PhysicsException;
import reve.pe.adapter.LawChange;
import reve.worlds.journal.FrameCodec;
import reve.worlds.journal.ImageCodec;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.SimulationImage;
import reve.worlds.journal.WorldHeader;

import tools.jackson.databind.JsonNode;

import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.function.Consumer;
import java.util.function.Function;

/**
 * Repeats the frames of a journal. It starts from the journal's image, applies the recorded inputs,
 * and compares the digest of each frame. For one thread, which owns the world.
 */
public final class Replay implements AutoCloseable {
    private final Optional<WorldDescription> wanted;
    private final Optional<Path> folder;
    private final Pacing pacing;
    private final LawPath laws;
    private final Map<String, byte[]> libraries = new HashMap<>();
    private final Function<String, byte @Nullable []> elsewhere;
    private final List<Subscription> subscriptions = new ArrayList<>();
    private List<String> missingPlugins = List.of();
    private final List<LawChange> lawChanges = new ArrayList<>();
    private final Consumer<LawChange> lawListener = lawChanges::add;
    private @Nullable Simulation simulation;
    private @Nullable ImageCodec images;
    private @Nullable FrameCodec codec;
    private @Nullable WorldDigest digest;
    private Map<String, Long> members = Map.of();
    private @Nullable WorldHeader worldHeader;
    private @Nullable JsonNode inputs;
    private @Nullable RuntimeException failure;
    private @Nullable Divergence divergence;
    private long frames;
    private RuleChanges ruleChanges = RuleChanges.NONE;
    private final List<String> ruleProblems = new ArrayList<>();

    /**
     * The first difference between a replay and the recorded run.
     *
     * @param item name of the only item that differs, empty if several do
     * @param property the property that differs, or {@link WorldDigest#ROWS}, or "laws"
     * @param message one line that describes the difference
     */
    public record Divergence(
            long frame, String kind, Optional<String> item, String property, String message) {
        /** Returns the fields for JSON, in order. */
        public Map<String, Object> fields() {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("frame", frame);
            fields.put("kind", kind);
            item.ifPresent(name -> fields.put("item", name));
            fields.put("property", property);
            fields.put("message", message);
            return fields;
        }
    }

    /** Creates a replay of a journal that uses shipped laws only. */
    public Replay(Optional<WorldDescription> description, Pacing pacing) {
        this(description, pacing, LawPath.ofShipped());
    }

    /**
     * Creates a replay.
     *
     * @param description the description of the world, which is needed to continue the world later;
     *     if empty, it is derived from the journal
     * @param laws decides which of the journal's law libraries may be opened
     */
    public Replay(Optional<WorldDescription> description, Pacing pacing, LawPath laws) {
        this(description, Optional.empty(), pacing, laws, sha256 -> null);
    }

    /**
     * Creates a replay.
     *
     * @param folder the folder of the world's meshes and textures; if empty, the folder that the
     *     journal names
     * @param elsewhere returns the bytes of law libraries that are damaged in the journal, by
     *     SHA-256
     */
    Replay(
            Optional<WorldDescription> description,
            Optional<Path> folder,
            Pacing pacing,
            LawPath laws,
            Function<String, byte @Nullable []> elsewhere) {
        this.wanted = description;
        this.folder = folder;
        this.pacing = pacing;
        this.laws = laws;
        this.elsewhere = elsewhere;
    }

    /**
     * Applies the next record of a journal.
     *
     * @return false after a difference was found
     * @throws CorruptException if the record cannot be interpreted, or the journal does not begin
     *     with an image
     * @throws PhysicsException if a law library may not be opened, or does not load
     */
    public boolean take(JournalRecord record) {
        return take(record, Long.MAX_VALUE);
    }

    /**
     * Applies the next record, but makes no frame after {@code until}.
     *
     * @return false if a difference was found, or the frame {@code until} was made
     */
    public boolean take(JournalRecord record, long until) {
        switch (record) {
            case JournalRecord.Library library -> keep(library);
            case JournalRecord.Image image -> begin(image);
            case JournalRecord.Frame frame -> {
                if (isGoing(until)) {
                    make(frame);
                }
            }
        }
        return isGoing(until);
    }

    private boolean isGoing(long until) {
        return divergence == null && (simulation == null || simulation.loop().frame() < until);
    }

    /** Returns the last frame that was made or restored; -1 before the first image. */
    public long frame() {
        return simulation == null ? -1 : simulation.loop().frame();
    }

    /** Returns the number of frames that were made. */
    public long frames() {
        return frames;
    }

    /** Returns the first difference; empty while there is none. */
    public Optional<Divergence> divergence() {
        return Optional.ofNullable(divergence);
    }

    /** Returns the ids of the bodies of the agents in the world, by agent. */
    public Map<String, Long> members() {
        return members;
    }

    /**
     * Publishes the restored state if the last record was an image. Does nothing if it was a frame.
     *
     * @throws CorruptException if the journal contained no image
     */
    void publish() {
        simulation().loop().run(0);
    }

    /**
     * Returns the simulation at the current frame. The simulation still belongs to the replay.
     *
     * @throws CorruptException if the journal contained no image
     */
    Simulation simulation() {
        if (simulation == null) {
            throw new CorruptException("the journal holds no image to begin with");
        }
        return simulation;
    }

    /**
     * Returns the symbols of the rules that were set or removed while the world ran, up to the
     * current frame, in alphabetical order.
     */
    public List<String> changedRules() {
        return ruleChanges.symbols().stream().sorted().toList();
    }

    /**
     * Returns the rules at the current frame: those of a world file after the changes that were
     * made while the world ran. A replay itself evaluates no changed rules.
     */
    List<Rule> rules(WorldDescription worldFile) {
        return new EditReader(worldFile.prototype())
                .rules(worldFile.rules(), ruleChanges, ruleProblems::add);
    }

    /**
     * Returns one message for each change of a rule that {@link #rules} or {@link #release} could
     * not make.
     */
    List<String> ruleProblems() {
        return ruleProblems;
    }

    /** Returns whether a change of the rule of this symbol may concern a rule of the world file. */
    private boolean isInFile(String symbol) {
        return wanted.isEmpty()
                || wanted.get().rules().stream().anyMatch(rule -> rule.symbol().equals(symbol));
    }

    /**
     * Ends the replay and returns its simulation at the current frame, with the rules of this
     * frame; the caller closes it.
     *
     * @throws CorruptException if the journal contained no image
     */
    public Simulation release() {
        Simulation released = simulation();
        if (wanted.isPresent()) {
            released.repeatRules(ruleChanges, ruleProblems::add);
        }
        subscriptions.forEach(Subscription::close);
        released.physics().laws().removeListener(lawListener);
        released.repeatLevels(false);
        simulation = null;
        return released;
    }

    @Override
    public void close() {
        if (simulation != null) {
            simulation.close();
            simulation = null;
        }
    }

    /**
     * Stores a library under the actual hash of its bytes. A damaged library is therefore not found
     * under the hash that the journal names.
     */
    private void keep(JournalRecord.Library library) {
        libraries.put(LawFiles.sha256(library.bytes()), library.bytes());
    }

    private byte @Nullable [] library(String sha256) {
        byte[] bytes = libraries.get(sha256);
        return bytes == null ? elsewhere.apply(sha256) : bytes;
    }

    private void begin(JournalRecord.Image record) {
        ImageCodec.Stored stored = ImageCodec.open(record.bytes());
        WorldHeader header = folder.map(stored.header()::in).orElse(stored.header());
        wanted.ifPresent(description -> requireSame(header, description));
        missingPlugins = header.missing(Plugins.current().infos());
        if (images == null) {
            images = new ImageCodec(header);
        }
        try (SimulationImage image = images.read(stored, this::library)) {
            image.physics().libraries().forEach(laws::requireKnown);
            if (simulation == null) {
                begin(header, image);
            } else {
                simulation.goOnFrom(image);
            }
        }
        members = stored.members();
        ruleChanges = stored.rules();
    }

    /**
     * Returns one message for each plugin of the recorded run that is missing or has changed. The
     * replay does not call plugins, but items may name their actions and sensors.
     */
    public List<String> missingPlugins() {
        return missingPlugins;
    }

    /**
     * Returns the data of the world that never change.
     *
     * @throws CorruptException if the journal contained no image
     */
    WorldHeader header() {
        simulation();
        return Objects.requireNonNull(worldHeader);
    }

    private void begin(WorldHeader header, SimulationImage image) {
        worldHeader = header;
        WorldDescription description = wanted.orElseGet(() -> description(header));
        Simulation made = new Simulation(description, pacing, laws, image);
        made.repeatLevels(true);
        simulation = made;
        digest = new WorldDigest(made.world());
        codec = new FrameCodec(header, digest.size());
        made.physics().laws().addListener(lawListener);
        subscriptions.add(made.bus().subscribe(FramePhase.ACT, "replay", this::comeIn));
        subscriptions.add(made.bus().subscribe(FramePhase.PUBLISH, "replay", this::comeLate));
    }

    /** Returns a description of a world from an image alone, without its world file. */
    private static WorldDescription description(WorldHeader header) {
        return WorldDescription.bare(header.name(), header.prototype(), header.timing());
    }

    /**
     * Refuses a world file that cannot be the file of the recorded world.
     *
     * @throws CorruptException naming the first difference
     */
    static void requireSame(WorldHeader header, WorldDescription description) {
        requireSame("is called", header.name(), description.name());
        requireSame("makes", text(header.timing()), text(description.timing()));
        requireSame("has the prototype", header.prototype().name(), description.prototype().name());
        requireSame(
                "has the properties",
                header.prototype().properties(),
                description.prototype().properties());
    }

    private static String text(Timing timing) {
        return timing.framesPerSecond()
                + " frames a second of "
                + timing.stepsPerFrame()
                + " steps each";
    }

    private static void requireSame(String what, Object stored, Object wanted) {
        if (!stored.equals(wanted)) {
            throw new CorruptException(
                    "the stored world "
                            + what
                            + " "
                            + stored
                            + ", the world file's "
                            + wanted
                            + ": use the file that it was stored with");
        }
    }

    private void make(JournalRecord.Frame record) {
        try {
            make(Trees.read(record.json()));
        } catch (CorruptException e) {
            throw new CorruptException(
                    "the record of frame " + record.frame() + ": " + e.getMessage(), e);
        }
    }

    private void make(JsonNode frame) {
        Simulation made = simulation;
        if (made == null || codec == null || digest == null) {
            throw new CorruptException("the journal does not begin with an image");
        }
        long number = Trees.integer(frame, "frame");
        if (number != made.loop().frame() + 1) {
            throw new CorruptException(
                    "frame "
                            + number
                            + " follows frame "
                            + made.loop().frame()
                            + ": records are missing");
        }
        inputs = frame;
        made.loop().step();
        inputs = null;
        frames++;
        if (failure != null) {
            throw failure;
        }
        followMembers(frame);
        ruleChanges = ruleChanges.with(FrameCodec.rules(frame), this::isInFile);
        compareLaws(frame);
        compare(frame, "digest");
    }

    /**
     * Compares the world with the digest {@code name} of a recorded frame, and stores the first
     * difference.
     */
    private void compare(JsonNode frame, String name) {
        if (codec != null && digest != null) {
            long[] recorded = codec.readDigest(frame, name);
            if (divergence == null) {
                digest.firstDifference(recorded)
                        .ifPresent(
                                found ->
                                        divergence =
                                                divergence(Trees.integer(frame, "frame"), found));
            }
        }
    }

    /**
     * Applies the inputs of the frame. This method runs as the last listener of ACT, because the
     * journal recorded the inputs at this point.
     */
    private void comeIn(FrameEvent event) {
        apply(
                event,
                () -> {
                    apply("changes");
                    if (input().has("before")) {
                        compare(input(), "before");
                    }
                    for (LawChange change : FrameCodec.laws(input(), this::library)) {
                        change.brought().ifPresent(laws::requireKnown);
                        made().physics().laws().apply(event.frame(), change);
                    }
                    lawChanges.clear();
                });
    }

    private void comeLate(FrameEvent event) {
        apply(event, () -> apply("late"));
    }

    private void apply(FrameEvent event, Runnable step) {
        if (inputs != null) {
            try {
                step.run();
            } catch (CorruptException | PhysicsException e) {
                failure = e;
            } catch (RuntimeException e) {
                failure = new CorruptException("it does not fit this world: " + e.getMessage(), e);
            }
        }
    }

    private void apply(String list) {
        if (codec != null) {
            for (JsonNode change : Trees.listIfAny(input(), list)) {
                codec.changes().apply(made().world(), change);
            }
        }
    }

    private JsonNode input() {
        return Objects.requireNonNull(inputs);
    }

    private Simulation made() {
        return Objects.requireNonNull(simulation);
    }

    /**
     * Records the failure of a law in the replay as a difference. A law that also failed in the
     * recorded run causes no difference, because its recorded removal was already applied.
     */
    private void compareLaws(JsonNode frame) {
        for (LawChange change : lawChanges) {
            String what =
                    switch (change) {
                        case LawChange.Failed failed ->
                                "law library "
                                        + failed.reason().library()
                                        + " failed, which it did not in the recording: "
                                        + failed.reason().message();
                        case LawChange.Unmoved _ ->
                                "the physics engine failed, which it did not in the recording";
                        default -> "";
                    };
            if (!what.isEmpty()) {
                long number = Trees.integer(frame, "frame");
                String message = "frame " + number + ": " + what;
                divergence = new Divergence(number, "law", Optional.empty(), "laws", message);
            }
        }
    }

    private void followMembers(JsonNode frame) {
        for (JsonNode event : Trees.listIfAny(frame, "events")) {
            String type = Trees.text(event, "type");
            JsonNode fields = Trees.field(event, "fields");
            if (type.equals("joined") || type.equals("left")) {
                Map<String, Long> changed = new LinkedHashMap<>(members);
                String agent = Trees.text(fields, "agent");
                changed.remove(agent);
                if (type.equals("joined")) {
                    made().world()
                            .find(Trees.text(fields, "body"))
                            .ifPresent(body -> changed.put(agent, body.id().value()));
                }
                members = changed;
            }
        }
    }

    private Divergence divergence(long frame, WorldDigest.Difference found) {
        Optional<String> item = found.item().map(this::name);
        String what =
                found.property().equals(WorldDigest.ROWS)
                        ? "the items of kind " + found.kind() + " differ"
                        : item.orElse("several items of kind " + found.kind())
                                + ": "
                                + found.property()
                                + " differs";
        return new Divergence(
                frame, found.kind(), item, found.property(), "frame " + frame + ": " + what);
    }

    private String name(ItemId id) {
        return made().world().item(id).name();
    }
}
