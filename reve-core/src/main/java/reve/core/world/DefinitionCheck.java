package reve.core.world;

import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * Checks definitions against a world before anything is added, so that a refusal changes nothing.
 */
final class DefinitionCheck {

    private final World world;
    private final List<ItemDefinition> definitions;
    private final Map<String, ItemDefinition> batch = new HashMap<>();

    DefinitionCheck(World world, List<ItemDefinition> definitions) {
        this.world = world;
        this.definitions = definitions;
    }

    /** @throws IllegalArgumentException naming the first item that cannot be added, and why */
    void run() {
        for (ItemDefinition definition : definitions) {
            checkName(definition);
            checkKind(definition);
            checkNumbers(definition);
        }
        definitions.forEach(this::checkReferences);
    }

    static void requireTarget(String where, PropertyDescriptor property, String target, String kind,
            boolean hasPhysics) {
        String expected = property.refersTo().orElseThrow();
        if (!kind.equals(expected)) {
            throw new IllegalArgumentException(where + " refers to " + target + " of kind " + kind
                    + ", expected kind " + expected);
        }
        if (!hasPhysics) {
            throw new IllegalArgumentException(where + " refers to " + target
                    + ", which is scenery: give it a physics property (mass 0 makes it immovable)");
        }
    }

    private void checkName(ItemDefinition definition) {
        String name = definition.name();
        if (name.equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException(
                    "item name world is reserved for the world's constants; choose another");
        }
        if (world.findItem(name) != null || batch.putIfAbsent(name, definition) != null) {
            throw new IllegalArgumentException("item name " + name + " is already taken");
        }
    }

    private void checkKind(ItemDefinition definition) {
        world.table(definition.kind());
        if (definition.kind().equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException("item " + definition.name()
                    + " cannot be of kind world, which has exactly one item");
        }
        if (definition.isPlaced() && !definition.kind().equals(WorldPrototype.BODY)) {
            throw new IllegalArgumentException("item " + definition.name() + " of kind "
                    + definition.kind() + " has no place, shape or colour: only kind body has");
        }
        ScalarType real = world.prototype().realType();
        for (double metres : definition.location()) {
            if (real == ScalarType.F32 && !Float.isFinite((float) metres)) {
                throw new IllegalArgumentException("item " + definition.name() + ": position is "
                        + metres + ", which does not fit type " + real);
            }
        }
    }

    private void checkNumbers(ItemDefinition definition) {
        Table table = world.table(definition.kind());
        for (String property : definition.physicsProperties()) {
            Column column = physicsColumn(table, definition, property);
            Values.requireFits(definition.name(), column.descriptor(),
                    definition.physics(property).orElseThrow());
        }
    }

    private void checkReferences(ItemDefinition definition) {
        Table table = world.table(definition.kind());
        Set<String> given = new HashSet<>();
        definition.references().forEach((property, targets) -> {
            PropertyDescriptor descriptor =
                    physicsColumn(table, definition, property).descriptor();
            String where = "item " + definition.name() + ": " + property;
            if (descriptor.type() != ScalarType.REF) {
                throw new IllegalArgumentException(where + " is a number, not a reference");
            }
            if (targets.size() != descriptor.components()) {
                throw new IllegalArgumentException(where + " refers to " + targets.size()
                        + " items, expected " + descriptor.components());
            }
            targets.forEach(target -> checkTarget(where, descriptor, target));
            given.add(property);
        });
        for (Column column : table.references()) {
            if (definition.hasPhysics() && !given.contains(column.name())) {
                throw new IllegalArgumentException("item " + definition.name() + " of kind "
                        + definition.kind() + " needs " + column.name());
            }
        }
    }

    private void checkTarget(String where, PropertyDescriptor descriptor, String target) {
        ItemDefinition fellow = batch.get(target);
        Item present = world.findItem(target);
        if (fellow != null) {
            requireTarget(where, descriptor, target, fellow.kind(), fellow.hasPhysics());
        } else if (present != null) {
            requireTarget(where, descriptor, target, present.kind(),
                    !present.physics().isEmpty());
        } else {
            throw new IllegalArgumentException(where + " refers to " + target
                    + ", which does not exist");
        }
    }

    private static Column physicsColumn(Table table, ItemDefinition definition, String property) {
        try {
            return table.physicsColumn(property);
        } catch (IllegalArgumentException e) {
            throw new IllegalArgumentException("item " + definition.name() + ": "
                    + e.getMessage(), e);
        }
    }
}
