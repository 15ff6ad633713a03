// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

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

/** The codec of items as texts in the form of a world file. For one thread. */
final class ItemTexts {

    /**
     * Maximum number of cached texts. Equal texts of different items are cached once, so a world
     * needs few texts.
     */
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
     * Returns the text of an item without id, name, symbols and attachment. Many items therefore
     * have the same text.
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

    /**
     * Returns the symbolic data of an item from its id, name and decoded text. Symbols and
     * attachment are still missing.
     */
    ItemSymbols read(ItemId id, String name, ItemDefinition likeness) {
        ItemDefinition named =
                name.equals(WorldPrototype.WORLD) ? constants(likeness) : likeness.renamed(name);
        return new ItemSymbols(id, named, prototype.classes());
    }

    /**
     * Returns the complete item as a tree. The symbols are separate from the item's text, because
     * their names may be invalid in a world file.
     */
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

    /**
     * Returns a definition with only the actions of the item {@code world}. The text omits the kind
     * of this item, because a world file does not permit it.
     */
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
