// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.frame.Timing;
import reve.core.rule.Rule;
import reve.core.rule.Rules;
import reve.core.world.ColumnArena;
import reve.core.world.Force;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collections;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The checked content of a world file in SI units. Immutable. Any number of worlds can be built
 * from it.
 *
 * @param doc description of the world for human readers; may be empty
 * @param age number of frames of the world before it was saved, see {@link World#age}; 0 for a new
 *     world
 * @param laws references to the required laws, in loading order
 * @param constants values of the properties of the item {@code world}, by name [the property's
 *     unit]
 * @param camera viewpoint of pictures; if empty, pictures show all bodies
 * @param rules rules that compute symbols, in the order of evaluation
 * @param ruleSteps maximum number of evaluation steps of all rules in one frame
 * @param items items in the order of the file; they may refer to each other
 * @param forces forces of actions that still act on items, in the order in which they are added up
 * @param warnings warnings about the file
 * @param places positions of items and constants in the file, for warnings
 * @param threads maximum number of threads that laws share; results do not depend on it
 * @param cameras cameras that commands select by their names, in the order of the file
 */
public record WorldDescription(
        String name,
        String doc,
        WorldPrototype prototype,
        Timing timing,
        long age,
        List<LawReference> laws,
        Map<String, List<Double>> constants,
        Optional<CameraDescription> camera,
        AgentPolicy agents,
        List<Rule> rules,
        long ruleSteps,
        List<ItemDefinition> items,
        List<LastingForce> forces,
        List<Problem> warnings,
        Places places,
        int threads,
        List<NamedCamera> cameras) {
    /** Copies lists and maps, in their order. */
    public WorldDescription {
        laws = List.copyOf(laws);
        constants = Collections.unmodifiableMap(new LinkedHashMap<>(constants));
        rules = List.copyOf(rules);
        items = List.copyOf(items);
        forces = List.copyOf(forces);
        warnings = List.copyOf(warnings);
        cameras = List.copyOf(cameras);
    }

    /** Creates a description that was not read from a file. */
    public WorldDescription(
            String name,
            String doc,
            WorldPrototype prototype,
            Timing timing,
            long age,
            List<LawReference> laws,
            Map<String, List<Double>> constants,
            Optional<CameraDescription> camera,
            AgentPolicy agents,
            List<Rule> rules,
            long ruleSteps,
            List<ItemDefinition> items,
            List<LastingForce> forces,
            List<Problem> warnings) {
        this(
                name,
                doc,
                prototype,
                timing,
                age,
                laws,
                constants,
                camera,
                agents,
                rules,
                ruleSteps,
                items,
                forces,
                warnings,
                Places.none(),
                1,
                List.of());
    }

    /** Returns a description without items, laws and agents. */
    public static WorldDescription bare(String name, WorldPrototype prototype, Timing timing) {
        return new WorldDescription(
                name,
                "",
                prototype,
                timing,
                0,
                List.of(),
                Map.of(),
                Optional.empty(),
                AgentPolicy.none(),
                List.of(),
                Rules.DEFAULT_STEPS,
                List.of(),
                List.of(),
                List.of());
    }

    /** Returns this description with other laws. */
    public WorldDescription withLaws(List<LawReference> others) {
        return new WorldDescription(
                name, doc, prototype, timing, age, others, constants, camera, agents, rules,
                ruleSteps, items, forces, warnings, places, threads, cameras);
    }

    /** Returns this description with another maximum number of threads. */
    public WorldDescription withThreads(int others) {
        return new WorldDescription(
                name, doc, prototype, timing, age, laws, constants, camera, agents, rules,
                ruleSteps, items, forces, warnings, places, others, cameras);
    }

    /** Returns this description with other rules. */
    public WorldDescription withRules(List<Rule> others) {
        return new WorldDescription(
                name, doc, prototype, timing, age, laws, constants, camera, agents, others,
                ruleSteps, items, forces, warnings, places, threads, cameras);
    }

    /**
     * Builds a world with all items. The calling thread owns the world.
     *
     * @param arena allocator of column memory; it must outlive the world
     */
    public World build(ColumnArena arena) {
        World world = new World(name, prototype, arena);
        world.setAge(age);
        Item constantsItem = world.find(WorldPrototype.WORLD).orElseThrow();
        constants.forEach(
                (property, values) ->
                        constantsItem
                                .physics()
                                .set(
                                        property,
                                        values.stream()
                                                .mapToDouble(Double::doubleValue)
                                                .toArray()));
        world.addAll(items);
        forces.forEach(
                force ->
                        world.forces()
                                .add(
                                        new Force(
                                                world.find(force.item()).orElseThrow().id(),
                                                force.newtons(),
                                                force.frames())));
        return world;
    }

    /**
     * Returns a description of the current state of a world. The order of the items preserves the
     * rows that laws see. For the world's thread only.
     *
     * @param world a world that was built from this description
     * @param nowLoaded references to the laws that are loaded now
     */
    public WorldDescription of(World world, List<LawReference> nowLoaded) {
        Map<String, List<Double>> now = new LinkedHashMap<>();
        ItemDefinition constantsItem = world.find(WorldPrototype.WORLD).orElseThrow().definition();
        for (String property : constantsItem.physicsProperties()) {
            now.put(
                    property,
                    Arrays.stream(constantsItem.physics(property).orElseThrow()).boxed().toList());
        }
        List<String> bodies =
                agents.bodies().stream().filter(body -> world.find(body).isPresent()).toList();
        return new WorldDescription(
                name,
                doc,
                prototype,
                timing,
                world.age(),
                nowLoaded,
                now,
                camera,
                agents.withBodies(bodies),
                rules,
                ruleSteps,
                inOrderOfRows(world).stream().map(Item::definition).toList(),
                forcesIn(world),
                List.of(),
                Places.none(),
                threads,
                cameras);
    }

    /**
     * Returns the forces that still act. Omits forces on items that were removed or lost their
     * physics aspect, because these forces end with the next frame.
     */
    private static List<LastingForce> forcesIn(World world) {
        List<LastingForce> forces = new ArrayList<>();
        for (Force force : world.forces().active()) {
            world.find(force.item())
                    .filter(item -> !item.physics().isEmpty())
                    .ifPresent(
                            item ->
                                    forces.add(
                                            new LastingForce(
                                                    item.name(), force.newtons(), force.frames())));
        }
        return forces;
    }

    /**
     * Returns all items except {@code world}. The order preserves rows: if the items are added to
     * an empty world of the same prototype, each item with a physics aspect gets its current row.
     * Items are ordered by id as far as the rows permit.
     */
    private static List<Item> inOrderOfRows(World world) {
        Map<String, Integer> rows = new HashMap<>();
        List<Item> ordered = new ArrayList<>();
        for (Item item : world.items()) {
            if (item.physics().isEmpty()) {
                ordered.add(item);
            } else if (!item.kind().equals(WorldPrototype.WORLD)) {
                int row = rows.merge(item.kind(), 1, Integer::sum) - 1;
                ordered.add(world.item(world.table(item.kind()).idAt(row)));
            }
        }
        return ordered;
    }
}
