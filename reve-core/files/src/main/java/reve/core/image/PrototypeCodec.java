// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import reve.core.text.Visible;
import reve.core.unit.Unit;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The codec of world prototypes as trees (maps and lists). A tree contains the name of the standard
 * prototype and the properties that were added to it.
 */
public final class PrototypeCodec {

    private PrototypeCodec() {}

    /** Returns a tree that {@link Trees#write} can encode. */
    public static Map<String, Object> write(WorldPrototype prototype) {
        int standard = WorldPrototype.standard(prototype.name()).properties().size();
        List<PropertyDescriptor> all = prototype.properties();
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("name", prototype.name());
        tree.put(
                "added",
                all.subList(standard, all.size()).stream().map(PrototypeCodec::tree).toList());
        tree.put(
                "symbols",
                prototype.symbols().stream()
                        .map(
                                symbol ->
                                        Map.of(
                                                "name",
                                                symbol.name(),
                                                "type",
                                                symbol.type().name(),
                                                "unit",
                                                symbol.unit().symbol(),
                                                "doc",
                                                symbol.doc()))
                        .toList());
        return tree;
    }

    /**
     * @throws CorruptException if the tree is not a prototype
     */
    public static WorldPrototype read(JsonNode tree) {
        try {
            return WorldPrototype.standard(Trees.text(tree, "name"))
                    .extendedBy(
                            Trees.list(tree, "added").stream()
                                    .map(PrototypeCodec::property)
                                    .toList())
                    .withSymbols(
                            Trees.list(tree, "symbols").stream()
                                    .map(PrototypeCodec::symbol)
                                    .toList());
        } catch (IllegalArgumentException e) {
            throw new CorruptException("no prototype: " + e.getMessage(), e);
        }
    }

    private static Map<String, Object> tree(PropertyDescriptor property) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("name", property.name());
        tree.put("kind", property.kind());
        tree.put("type", property.type().name());
        tree.put("components", property.components());
        tree.put("unit", property.unit().symbol());
        property.refersTo().ifPresent(kind -> tree.put("refersTo", kind));
        if (Double.isFinite(property.minimum())) {
            tree.put("minimum", property.minimum());
        }
        tree.put("doc", property.doc());
        return tree;
    }

    private static SymbolDescriptor symbol(JsonNode tree) {
        return new SymbolDescriptor(
                Trees.text(tree, "name"),
                type(SymbolType.class, tree),
                Unit.parse(Trees.text(tree, "unit")),
                Trees.text(tree, "doc"));
    }

    private static <T extends Enum<T>> T type(Class<T> types, JsonNode tree) {
        String name = Trees.text(tree, "type");
        try {
            return Enum.valueOf(types, name);
        } catch (IllegalArgumentException e) {
            throw new CorruptException(
                    "the field type is \""
                            + Visible.shortened(name)
                            + "\", expected one of "
                            + List.of(types.getEnumConstants()),
                    e);
        }
    }

    private static PropertyDescriptor property(JsonNode tree) {
        return new PropertyDescriptor(
                Trees.text(tree, "name"),
                Trees.text(tree, "kind"),
                type(ScalarType.class, tree),
                (int) Trees.integer(tree, "components"),
                Unit.parse(Trees.text(tree, "unit")),
                Optional.ofNullable(tree.get("refersTo"))
                        .map(kind -> Trees.text("the field refersTo", kind)),
                tree.has("minimum")
                        ? Trees.number("the field minimum", tree.get("minimum"))
                        : Double.NEGATIVE_INFINITY,
                Trees.text(tree, "doc"));
    }
}
