// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.file.WorldDescription;
import reve.core.frame.Timing;
import reve.core.image.CorruptException;
import reve.core.image.Trees;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;
import reve.pe.PhysicsException;
import reve.pe.adapter.LawLibrary;
import reve.worlds.journal.JournalRecord;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.Stream;

/**
 * The states of a recording or a store, frame by frame. Each frame is computed again and compared
 * with the journal. Therefore a state that differs from the recorded one is never returned. For one
 * thread.
 */
public final class History implements AutoCloseable {
    /** Keys of a recorded frame that contain changes of the world by something else than laws. */
    private static final List<String> INPUTS = List.of("changes", "laws", "rules", "late");

    private final StoredRun run;
    private final Replay replay;
    private long first = -1;
    private List<Happening> happenings = List.of();

    /** True if the world changed in the last record by something else than its laws. */
    private boolean isChanged;

    /**
     * An event that a journal contains.
     *
     * @param fields text, numbers and truth values by name, in the order of the event
     */
    public record Happening(String type, Map<String, Object> fields) {}

    /**
     * Creates the history of a run.
     *
     * @param run belongs to the history from now on
     */
    public History(StoredRun run) {
        this.run = run;
        this.replay = run.replay();
    }

    /**
     * Makes the next frame. The first frame is the frame of the journal's first image (a complete
     * state).
     *
     * @return false if the journal has ended
     * @throws CorruptException if the journal is damaged, or the computed frame differs from the
     *     recorded one
     * @throws PhysicsException if a law may not be opened, or does not load
     */
    public boolean next() {
        while (run.hasNext()) {
            JournalRecord record = run.next();
            take(record);
            first = first < 0 ? replay.frame() : first;
            switch (record) {
                case JournalRecord.Library _ -> {}
                case JournalRecord.Image _ -> {
                    replay.publish();
                    happenings = List.of();
                    isChanged = true;
                    return true;
                }
                case JournalRecord.Frame frame -> {
                    JsonNode tree = Trees.read(frame.json());
                    happenings = happenings(tree);
                    isChanged =
                            INPUTS.stream().anyMatch(key -> !Trees.listIfAny(tree, key).isEmpty());
                    return true;
                }
            }
        }
        return false;
    }

    private void take(JournalRecord record) {
        try {
            replay.take(record);
        } catch (CorruptException meaningless) {
            throw new CorruptException(place() + meaningless.getMessage(), meaningless);
        } catch (PhysicsException refused) {
            throw new PhysicsException(refused.status(), place() + refused.getMessage());
        }
        replay.divergence()
                .ifPresent(
                        found -> {
                            throw new CorruptException(
                                    run.name()
                                            + ": the repeated run differs from the recorded one: "
                                            + found.message()
                                            + "; replay it with the version of REVE that recorded"
                                            + " it");
                        });
    }

    private String place() {
        return run.name() + (replay.frame() < 0 ? "" : ", after frame " + replay.frame()) + ": ";
    }

    private static List<Happening> happenings(JsonNode frame) {
        List<Happening> all = new ArrayList<>();
        for (JsonNode event : Trees.listIfAny(frame, "events")) {
            Map<String, Object> fields = new LinkedHashMap<>();
            Trees.field(event, "fields")
                    .properties()
                    .forEach(field -> fields.put(field.getKey(), plain(field.getValue())));
            all.add(new Happening(Trees.text(event, "type"), fields));
        }
        return all;
    }

    private static Object plain(JsonNode value) {
        if (value.isBoolean()) {
            return value.asBoolean();
        }
        return value.isNumber() ? value.numberValue() : value.asString();
    }

    /** Returns the state at the end of the current frame; the caller closes it. */
    public WorldSnapshot snapshot() {
        return replay.simulation().snapshots().acquireLatest().orElseThrow();
    }

    /** Returns the recorded events of the current frame, in order. */
    public List<Happening> happenings() {
        return happenings;
    }

    /**
     * Returns whether the world changed in the current frame by something else than its laws, for
     * example by an act of an agent, a rewind, or a law that was loaded. True for the first frame.
     */
    public boolean isChanged() {
        return isChanged;
    }

    /**
     * Returns a description of the world at the end of the current frame, for a world file.
     *
     * @param worldFile the world file of the run, if {@link StoredRun#open} did not get it
     */
    public WorldDescription description(Optional<WorldDescription> worldFile) {
        Simulation simulation = replay.simulation();
        WorldDescription file = worldFile.orElseGet(simulation::description);
        return simulation.descriptionNow(file.withRules(replay.rules(file)));
    }

    /** Returns whether the rules of the world were changed while it ran. */
    public boolean hasChangedRules() {
        return !replay.changedRules().isEmpty();
    }

    /**
     * Returns one message for each change of a rule that {@link #description} does not contain,
     * because the rule does not fit the world file.
     */
    public List<String> ruleProblems() {
        return replay.ruleProblems();
    }

    /**
     * Refuses a world file that cannot be the world file of the run. Valid after the first {@link
     * #next()}.
     *
     * @throws CorruptException naming the first difference
     */
    public void requireSame(WorldDescription worldFile) {
        Replay.requireSame(replay.header(), worldFile);
    }

    /** Returns one message for each part of the state that {@link #description} cannot contain. */
    public List<String> notDescribed() {
        return replay.simulation().notDescribed();
    }

    /** Returns the folder of the world's meshes and textures. Valid after the first next(). */
    public Path folder() {
        return replay.header().folder();
    }

    /** Returns the loaded libraries of native code and Python that do not ship. */
    public List<LawLibrary> ownLaws() {
        return loaded().filter(library -> !library.isText() && !hasShippedName(library)).toList();
    }

    /** Returns the loaded libraries with the name of a law that ships, but with other bytes. */
    public List<LawLibrary> otherVersions() {
        return loaded().filter(library -> hasShippedName(library) && !run.laws().ships(library))
                .toList();
    }

    private Stream<LawLibrary> loaded() {
        return replay.simulation().physics().laws().libraries().stream();
    }

    private boolean hasShippedName(LawLibrary library) {
        return run.laws().shippedNames().contains(library.name());
    }

    /** Returns the hash of the state at the end of the current frame. */
    public long stateHash() {
        return replay.simulation().physics().stateHash();
    }

    /** Returns the name of the world. Valid after the first {@link #next()}. */
    public String world() {
        return replay.simulation().description().name();
    }

    /** Returns the properties of the world's items. Valid after the first {@link #next()}. */
    public WorldPrototype prototype() {
        return replay.simulation().description().prototype();
    }

    /** Returns the frame rate of the world. Valid after the first {@link #next()}. */
    public Timing timing() {
        return replay.simulation().description().timing();
    }

    /** Returns the number of the current frame; -1 before the first {@link #next()}. */
    public long frame() {
        return replay.frame();
    }

    /**
     * Returns the fraction of the frames that was made so far, from 0 to 1, for progress messages.
     */
    public double part() {
        long last = run.lastFrame();
        return last <= first ? 1 : Math.min(1, (double) (frame() - first) / (last - first));
    }

    /** Returns whether a recording ends within a record. Valid after its last frame. */
    public boolean wasCut() {
        return run.wasCut();
    }

    @Override
    public void close() throws IOException {
        run.close();
    }
}
