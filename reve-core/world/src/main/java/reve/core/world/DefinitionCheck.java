// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Set;

/**
 * Check of item definitions against a world. It runs before any of the items is added, so that a
 * refusal changes nothing.
 */
final class DefinitionCheck {

    private final WorldData world;
    private final Items items;
    private final List<ItemDefinition> definitions;
    private final Map<String, ItemDefinition> batch = new HashMap<>();
    private Map<String, Object> checkedSymbols = Map.of();

    /** Names of items whose chain of parents is known to have no cycle. */
    private final Set<String> rooted = new HashSet<>();

    DefinitionCheck(WorldData world, Items items, List<ItemDefinition> definitions) {
        this.world = world;
        this.items = items;
        this.definitions = definitions;
    }

    /**
     * Runs all checks.
     *
     * @throws IllegalArgumentException naming the first item that cannot be added, and the reason
     */
    void run() {
        for (ItemDefinition definition : definitions) {
            checkName(definition);
            checkKind(definition);
            checkNumbers(definition);
            checkSymbols(definition);
            checkInstruments(definition);
        }
        definitions.forEach(this::checkReferences);
        definitions.forEach(this::checkParent);
    }

    /** Checks the symbols of a definition. Symbols that several items share are checked once. */
    private void checkSymbols(ItemDefinition definition) {
        if (definition.symbols() != checkedSymbols) {
            definition
                    .symbols()
                    .forEach(
                            (symbol, value) ->
                                    Values.requireSymbol(
                                            world.prototype, definition.name(), symbol, value));
            checkedSymbols = definition.symbols();
        }
    }

    /** Checks that the world has the properties into which it writes measurements. */
    private void checkInstruments(ItemDefinition definition) {
        for (Sensor sensor : definition.sensors()) {
            if (sensor.instrument().isEmpty()) {
                continue;
            }
            for (String property : WorldPrototype.measuredBy(sensor.instrument().get())) {
                if (world.prototype.find(WorldPrototype.BODY, property).isEmpty()) {
                    throw new IllegalArgumentException(
                            "item "
                                    + definition.name()
                                    + ": sensor "
                                    + sensor.name()
                                    + " needs the property "
                                    + property
                                    + ", which this world does not have; give such a sensor to an"
                                    + " item, a prefab or the body of agents in the world file");
                }
            }
        }
    }

    static void requireFree(String name, boolean taken) {
        if (name.equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException(
                    "item name world is reserved for the world's constants; choose another");
        }
        if (taken) {
            throw new IllegalArgumentException("item name " + name + " is already taken");
        }
    }

    private void checkName(ItemDefinition definition) {
        String name = definition.name();
        requireFree(name, items.find(name) != null || batch.putIfAbsent(name, definition) != null);
    }

    private void checkKind(ItemDefinition definition) {
        world.table(definition.kind());
        if (definition.kind().equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException(
                    "item "
                            + definition.name()
                            + " cannot be of kind world, which has exactly one item");
        }
        if (definition.isPlaced() && !definition.kind().equals(WorldPrototype.BODY)) {
            throw new IllegalArgumentException(
                    "item "
                            + definition.name()
                            + " of kind "
                            + definition.kind()
                            + " has no place, shape or colour: only kind body has");
        }
        definition.look().require("item " + definition.name(), definition.kind());
        ScalarType real = world.prototype.realType();
        for (double metres : definition.sharedLocation()) {
            if (real == ScalarType.F32 && !Float.isFinite((float) metres)) {
                throw new IllegalArgumentException(
                        "item "
                                + definition.name()
                                + ": position is "
                                + metres
                                + ", which does not fit type "
                                + real);
            }
        }
    }

    private void checkNumbers(ItemDefinition definition) {
        Table table = world.table(definition.kind());
        List<String> properties = definition.physicsProperties();
        for (int i = 0; i < properties.size(); i++) {
            Column column = physicsColumn(table, definition, properties.get(i));
            Values.requireFits(
                    definition.name(), column.descriptor(), definition.physicsValues().get(i));
        }
    }

    private void checkReferences(ItemDefinition definition) {
        Table table = world.table(definition.kind());
        if (table.references().isEmpty() && !definition.hasReferences()) {
            return;
        }
        Set<String> given = new HashSet<>();
        definition
                .references()
                .forEach(
                        (property, targets) -> {
                            PropertyDescriptor descriptor =
                                    physicsColumn(table, definition, property).descriptor();
                            String where = "item " + definition.name() + ": " + property;
                            if (descriptor.type() != ScalarType.REF) {
                                throw new IllegalArgumentException(
                                        where + " is a number, not a reference");
                            }
                            if (targets.size() != descriptor.components()) {
                                throw new IllegalArgumentException(
                                        where
                                                + " refers to "
                                                + targets.size()
                                                + " items, expected "
                                                + descriptor.components());
                            }
                            targets.forEach(target -> checkTarget(where, descriptor, target));
                            given.add(property);
                        });
        for (Column column : table.references()) {
            if (definition.hasPhysics() && !given.contains(column.name())) {
                throw new IllegalArgumentException(
                        "item "
                                + definition.name()
                                + " of kind "
                                + definition.kind()
                                + " needs "
                                + column.name());
            }
        }
    }

    private void checkParent(ItemDefinition definition) {
        if (definition.parent().isEmpty()) {
            return;
        }
        String parent = definition.parent().get();
        String where = "item " + definition.name() + " cannot be attached to " + parent + ": ";
        ItemDefinition fellow = batch.get(parent);
        Item present = items.find(parent);
        if (fellow == null && present == null) {
            throw new IllegalArgumentException(where + "it does not exist");
        }
        Hierarchy.requireBody(where, definition.name(), definition.kind());
        Hierarchy.requireBody(
                where,
                parent,
                fellow != null ? fellow.kind() : Objects.requireNonNull(present).kind());
        definition
                .physics(WorldPrototype.MASS)
                .ifPresent(mass -> Hierarchy.requireNoMass(where, mass[0]));
        checkNoCircle(definition);
    }

    /**
     * Refuses a cycle of parents. Only new items can form a cycle, because items that are already
     * in the world cannot be attached to new items.
     */
    private void checkNoCircle(ItemDefinition definition) {
        Set<String> path = new LinkedHashSet<>();
        ItemDefinition next = definition;
        while (next != null && !rooted.contains(next.name())) {
            if (!path.add(next.name())) {
                throw new IllegalArgumentException(
                        "item "
                                + next.name()
                                + " cannot be attached to itself, as by "
                                + String.join(" to ", path));
            }
            next = next.parent().map(batch::get).orElse(null);
        }
        rooted.addAll(path);
    }

    private void checkTarget(String where, PropertyDescriptor descriptor, String target) {
        ItemDefinition fellow = batch.get(target);
        Item present = items.find(target);
        if (fellow != null) {
            References.requireTarget(where, descriptor, target, fellow.kind(), fellow.hasPhysics());
        } else if (present != null) {
            References.requireTarget(
                    where, descriptor, target, present.kind(), !present.physics().isEmpty());
        } else {
            throw new IllegalArgumentException(
                    where + " refers to " + target + ", which does not exist");
        }
    }

    private static Column physicsColumn(Table table, ItemDefinition definition, String property) {
        try {
            return table.physicsColumn(property);
        } catch (IllegalArgumentException e) {
            throw new IllegalArgumentException(
                    "item " + definition.name() + ": " + e.getMessage(), e);
        }
    }
}
