// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import reve.core.text.Visible;
import reve.core.unit.Unit;
import reve.core.world.FieldDescriptor;
import reve.core.world.ItemClass;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The codec of world prototypes as trees (maps and lists). A tree contains the name of the standard
 * prototype, and the properties, symbols and classes that were added to it.
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
        if (!prototype.fields().isEmpty()) {
            tree.put("fields", prototype.fields().stream().map(PrototypeCodec::tree).toList());
        }
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
        if (!prototype.classes().isEmpty()) {
            tree.put(
                    "classes",
                    prototype.classes().all().stream().map(PrototypeCodec::tree).toList());
        }
        return tree;
    }

    /**
     * Decodes a prototype.
     *
     * @throws CorruptException if the tree is not a prototype
     */
    public static WorldPrototype read(JsonNode tree) {
        try {
            return WorldPrototype.standard(Trees.text(tree, "name"))
                    .extendedBy(
                            Trees.list(tree, "added").stream()
                                    .map(PrototypeCodec::property)
                                    .toList())
                    .withFields(
                            Trees.listIfAny(tree, "fields").stream()
                                    .map(PrototypeCodec::field)
                                    .toList())
                    .withSymbols(
                            Trees.list(tree, "symbols").stream()
                                    .map(PrototypeCodec::symbol)
                                    .toList())
                    .withClasses(
                            tree.has("classes")
                                    ? Trees.list(tree, "classes").stream()
                                            .map(PrototypeCodec::itemClass)
                                            .toList()
                                    : List.of());
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
        if (property.accumulated()) {
            tree.put("accumulated", true);
        }
        tree.put("doc", property.doc());
        return tree;
    }

    private static Map<String, Object> tree(FieldDescriptor field) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("name", field.name());
        tree.put("components", field.components());
        tree.put("unit", field.unit().symbol());
        tree.put("doc", field.doc());
        return tree;
    }

    private static FieldDescriptor field(JsonNode tree) {
        return new FieldDescriptor(
                Trees.text(tree, "name"),
                (int) Trees.integer(tree, "components"),
                Unit.parse(Trees.text(tree, "unit")),
                Trees.text(tree, "doc"));
    }

    private static Map<String, Object> tree(ItemClass itemClass) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("name", itemClass.name());
        tree.put("parent", itemClass.parent());
        tree.put("doc", itemClass.doc());
        tree.put("symbols", itemClass.symbols());
        tree.put("properties", itemClass.properties());
        return tree;
    }

    private static ItemClass itemClass(JsonNode tree) {
        Map<String, List<Double>> properties = new LinkedHashMap<>();
        Trees.field(tree, "properties")
                .properties()
                .forEach(
                        each ->
                                properties.put(
                                        each.getKey(),
                                        Arrays.stream(Trees.numbers(each.getValue()))
                                                .boxed()
                                                .toList()));
        return new ItemClass(
                Trees.text(tree, "name"),
                Trees.text(tree, "parent"),
                Trees.text(tree, "doc"),
                Trees.values(Trees.field(tree, "symbols")),
                properties);
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
                tree.path("accumulated").asBoolean(false),
                Trees.text(tree, "doc"));
    }
}
