// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Text;
import reve.core.file.EditReader;
import reve.core.file.Problem;
import reve.core.file.RayLimit;
import reve.core.file.WorldEdit;
import reve.core.file.WorldFileException;
import reve.core.world.ActionRefused;
import reve.core.world.Item;
import reve.core.world.Sensor;
import reve.core.world.World;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.Collectors;

/**
 * Prepares the changes of items and rules that operators request. Either all changes of one message
 * are made, or none.
 */
final class WorldEdits {
    private static final int SHOWN = 3;

    private final WorldPort port;
    private final Embodiment embodiment;
    private final ItemPace pace;
    private final EditReader reader;

    WorldEdits(WorldPort port, Embodiment embodiment, ItemPace pace) {
        this.port = port;
        this.pace = pace;
        this.embodiment = embodiment;
        this.reader = new EditReader(port.snapshots().prototype());
    }

    /**
     * A function that reads one edit. It needs the earlier edits of the message, because they may
     * add kinds of items.
     */
    private interface Reading {
        WorldEdit read(World world, List<WorldEdit> before) throws ActionRefused;
    }

    /**
     * Prepares a change. Reads new items now. Other edits are read when the change is made. Waits
     * if control clients change many items. For any thread.
     *
     * @throws ActionRefused if the items are not valid, or the heap is nearly full
     */
    WorldControl.Change prepare(ClientMessage.WorldChange message) throws ActionRefused {
        if (!(message instanceof ClientMessage.Remove)) {
            HeapRoom.OF_PROCESS.require();
        }
        List<Reading> readings = new ArrayList<>();
        var room = new EditReader.Room();
        Map<String, Optional<String>> rules = new LinkedHashMap<>();
        int items = 0;
        List<ClientMessage.WorldChange> all =
                message instanceof ClientMessage.Batch batch ? batch.changes() : List.of(message);
        for (ClientMessage.WorldChange each : all) {
            switch (each) {
                case ClientMessage.Add add -> {
                    WorldEdit.Add added = add(add, room);
                    items += added.items().size();
                    readings.add((world, before) -> added);
                }
                case ClientMessage.Change change -> {
                    items++;
                    readings.add((world, before) -> change(world, before, change, room));
                }
                case ClientMessage.Remove remove -> {
                    items++;
                    WorldEdit removal = new WorldEdit.Remove(remove.item(), remove.cascade());
                    readings.add((world, before) -> removal);
                }
                case ClientMessage.SetRule rule -> rules.put(rule.name(), rule.rule());
                case ClientMessage.Batch nested ->
                        throw new IllegalArgumentException("a batch in a batch: " + nested);
            }
        }
        pace.take(items);
        Optional<WorldControl.Change> rulesChange =
                rules.isEmpty() ? Optional.empty() : Optional.of(port.control().changeRules(rules));
        return (world, frame) -> make(world, frame, readings, rulesChange);
    }

    /**
     * Prepares the changes that a fork makes in its copy of the world. The copy has the same rules
     * as the world.
     */
    WorldControl.Change prepare(ClientMessage.Fork fork) throws ActionRefused {
        if (fork.changes().isEmpty()) {
            return (world, frame) -> {};
        }
        if (fork.changes().get().changes().stream()
                .anyMatch(ClientMessage.SetRule.class::isInstance)) {
            throw new ActionRefused("fork-refused", "the copy has the rules of the world itself");
        }
        return prepare(fork.changes().get());
    }

    private void make(
            World world, long frame, List<Reading> readings, Optional<WorldControl.Change> rules)
            throws ActionRefused {
        List<WorldEdit> edits = new ArrayList<>();
        for (Reading reading : readings) {
            edits.add(reading.read(world, edits));
        }
        if (edits.isEmpty()) {
            rules.orElseThrow().make(world, frame);
            return;
        }
        requireRays(world, edits);
        WorldEdit.make(
                world,
                frame,
                edits,
                embodiment.bodies().values(),
                () -> {
                    if (rules.isPresent()) {
                        rules.get().make(world, frame);
                    }
                });
    }

    /** Refuses edits after which the bodies that the world offers to agents have too many rays. */
    private void requireRays(World world, List<WorldEdit> edits) throws ActionRefused {
        if (edits.stream().noneMatch(edit -> edit instanceof WorldEdit.Add || isRenaming(edit))) {
            return;
        }
        Map<String, List<Sensor>> sensors = new HashMap<>();
        Map<String, List<Sensor>> offered = new HashMap<>();
        for (WorldEdit edit : edits) {
            switch (edit) {
                case WorldEdit.Add add ->
                        add.items().forEach(item -> sensors.put(item.name(), item.sensors()));
                case WorldEdit.Remove remove -> sensors.put(remove.item(), List.of());
                case WorldEdit.Change change -> {
                    if (isRenaming(change)) {
                        sensors.put(change.values().name(), sensors(world, sensors, change.item()));
                        sensors.put(change.item(), List.of());
                    }
                }
            }
        }
        for (String name : port.agents().bodies()) {
            offered.put(name, sensors(world, sensors, name));
        }
        Optional<String> excess = RayLimit.excess(port.agents(), offered);
        if (excess.isPresent()) {
            throw new ActionRefused(WorldEdit.REFUSED, excess.get());
        }
    }

    private static boolean isRenaming(WorldEdit edit) {
        return edit instanceof WorldEdit.Change change && change.set().contains("name");
    }

    private static List<Sensor> sensors(
            World world, Map<String, List<Sensor>> changed, String name) {
        return changed.containsKey(name)
                ? changed.get(name)
                : world.find(name).map(Item::sensors).orElse(List.of());
    }

    private WorldEdit.Add add(ClientMessage.Add add, EditReader.Room room) throws ActionRefused {
        try {
            return reader.add(add.items(), room);
        } catch (WorldFileException invalid) {
            throw refusal(invalid);
        }
    }

    private WorldEdit change(
            World world, List<WorldEdit> before, ClientMessage.Change change, EditReader.Room room)
            throws ActionRefused {
        Optional<String> kind =
                world.find(change.item())
                        .map(Item::kind)
                        .or(() -> Optional.ofNullable(WorldEdit.kinds(before).get(change.item())));
        if (kind.isEmpty()) {
            throw new ActionRefused(
                    "no-such-item", "the world has no item " + Text.quote(change.item()));
        }
        try {
            return reader.change(change.item(), kind.get(), change.to(), room);
        } catch (WorldFileException invalid) {
            throw refusal(invalid);
        }
    }

    /** Returns a refusal whose message contains the first problems of an invalid text. */
    static ActionRefused refusal(WorldFileException invalid) {
        List<Problem> problems = invalid.problems();
        return new ActionRefused(
                WorldEdit.REFUSED,
                problems.stream()
                                .limit(SHOWN)
                                .map(
                                        problem ->
                                                (problem.pointer().isEmpty()
                                                                ? ""
                                                                : problem.pointer() + ": ")
                                                        + problem.message())
                                .collect(Collectors.joining("; "))
                        + (problems.size() > SHOWN
                                ? "; and " + (problems.size() - SHOWN) + " more problems"
                                : ""));
    }
}
