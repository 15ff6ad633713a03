// SPDX-License-Identifier: Apache-2.0
package reve.core.store;

import reve.core.file.ItemWriter;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.mesh.Assets;
import reve.core.world.Action;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Likeness;
import reve.core.world.Material;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.util.HashMap;
import java.util.List;
import java.util.Map;

/** Items and parts of them as the text that a world file has for them. One thread. */
final class ItemTexts {

    /** Alike items share a text; a world has few kinds of them, however many there are of each. */
    private static final int MAX_KEPT = 10_000;

    private final WorldPrototype prototype;
    private final Assets assets;
    private final ItemWriter writer;
    private final Map<Likeness, String> texts = new HashMap<>();

    ItemTexts(WorldPrototype prototype, Assets assets) {
        this.prototype = prototype;
        this.assets = assets;
        this.writer = new ItemWriter(prototype);
    }

    /**
     * All but id, name, symbols and attachment; the same text for items that are alike in the rest.
     */
    String write(ItemSymbols item) {
        Likeness likeness = item.likeness();
        String known = texts.get(likeness);
        if (known == null) {
            known =
                    item.kind().equals(WorldPrototype.WORLD)
                            ? writer.write(withoutKind(item))
                            : writer.write(likeness);
            if (texts.size() < MAX_KEPT) {
                texts.put(likeness, known);
            }
        }
        return known;
    }

    String write(Shape shape) {
        return writer.write(ItemDefinition.named("item").shape(shape).build());
    }

    String write(Material material) {
        return writer.write(ItemDefinition.named("item").material(material).build());
    }

    String write(Action action) {
        return writer.write(ItemDefinition.named("item").action(action).build());
    }

    /** What is symbolic about an item of that id and name but symbols and attachment. */
    ItemSymbols read(ItemId id, String name, ItemDefinition likeness) {
        ItemDefinition named =
                name.equals(WorldPrototype.WORLD) ? constants(likeness) : likeness.renamed(name);
        return new ItemSymbols(id, named);
    }

    /** All of an item; symbols apart, as their names need not be those of a world file. */
    Map<String, Object> tree(ItemDefinition item) {
        return Map.of("item", writer.write(item.withSymbols(Map.of())), "symbols", item.symbols());
    }

    ItemDefinition read(JsonNode tree) {
        return read(Trees.text(tree, "item"))
                .withSymbols(Trees.values(Trees.field(tree, "symbols")));
    }

    ItemDefinition read(String text) {
        try {
            return WorldFile.parseItem("stored item", text, prototype, assets);
        } catch (WorldFileException e) {
            throw new CorruptException("an item cannot be read: " + e.getMessage(), e);
        }
    }

    /** The item that holds a world's constants has no kind in a world file. */
    private static ItemDefinition withoutKind(ItemSymbols constants) {
        var definition = ItemDefinition.named("item");
        constants.actions().forEach(definition::action);
        return definition.build();
    }

    private static ItemDefinition constants(ItemDefinition likeness) {
        var definition = ItemDefinition.named(WorldPrototype.WORLD).kind(WorldPrototype.WORLD);
        likeness.actions().forEach(definition::action);
        return definition.build();
    }

    Shape readShape(String text) {
        return read(text).shape();
    }

    Material readMaterial(String text) {
        return read(text)
                .material()
                .orElseThrow(() -> new CorruptException("found no material, expected one"));
    }

    Action readAction(String text) {
        List<Action> actions = read(text).actions();
        if (actions.size() != 1) {
            throw new CorruptException("found " + actions.size() + " actions, expected one");
        }
        return actions.getFirst();
    }
}
