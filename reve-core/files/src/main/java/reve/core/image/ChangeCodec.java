// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import org.jspecify.annotations.Nullable;

import reve.core.mesh.Assets;
import reve.core.world.Action;
import reve.core.world.Colour;
import reve.core.world.Column;
import reve.core.world.ConnectionLook;
import reve.core.world.Force;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.Material;
import reve.core.world.Pose;
import reve.core.world.Shape;
import reve.core.world.World;
import reve.core.world.WorldChange;
import reve.core.world.WorldPrototype;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.Arrays;
import java.util.Base64;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The codec of {@link WorldChange}s as JSON. A journal uses it to repeat changes on an equal world.
 * For one thread.
 */
public final class ChangeCodec {

    private final ItemTexts texts;

    /**
     * @param assets source of the items' mesh and texture files
     */
    public ChangeCodec(WorldPrototype prototype, Assets assets) {
        texts = new ItemTexts(prototype, assets);
    }

    /**
     * Encodes a change.
     *
     * @param columnRows bytes of all rows of a directly edited column, after the change; null for
     *     any other change
     * @throws IllegalArgumentException if an item of the change cannot be written, or if the change
     *     is a restoration of the world, which only an image can describe
     */
    public Map<String, Object> write(WorldChange change, byte @Nullable [] columnRows) {
        return switch (change) {
            case WorldChange.Added added -> added(added);
            case WorldChange.Removed removed ->
                    tree("remove", removed.item().value(), "cascade", !removed.cascade().isEmpty());
            case WorldChange.Renamed renamed ->
                    tree("rename", renamed.item().value(), "to", renamed.to());
            case WorldChange.Attached attached ->
                    tree(
                            "attach",
                            attached.item().value(),
                            "parent",
                            attached.to().parent().value(),
                            "pose",
                            numbers(attached.to().pose()));
            case WorldChange.Detached detached -> tree("detach", detached.item().value());
            case WorldChange.Edited edited -> edited(edited);
            case WorldChange.Pushed pushed ->
                    tree(
                            "push",
                            pushed.force().item().value(),
                            "newtons",
                            pushed.force().newtons(),
                            "frames",
                            pushed.force().frames());
            case WorldChange.ColumnEdited column ->
                    tree(
                            "column",
                            column.property(),
                            "kind",
                            column.kind(),
                            "rows",
                            columnRows == null
                                    ? ""
                                    : Base64.getEncoder().encodeToString(columnRows));
            case WorldChange.Restored restored ->
                    throw new IllegalArgumentException(
                            "the world went back to frame "
                                    + restored.frame()
                                    + ": write an image");
        };
    }

    /**
     * Repeats a change. For the world's thread, in a phase that permits adding and removing items.
     *
     * @throws CorruptException if the change has no meaning in this world
     */
    public void apply(World world, JsonNode change) {
        try {
            applyUnchecked(world, change);
        } catch (IllegalArgumentException | IllegalStateException | JacksonException e) {
            throw new CorruptException(
                    "the change " + shortened(change) + " cannot be made: " + e.getMessage(), e);
        }
    }

    private void applyUnchecked(World world, JsonNode change) {
        if (change.has("add")) {
            add(world, change);
        } else if (change.has("remove")) {
            if (Trees.field(change, "cascade").asBoolean()) {
                world.removeCascade(id(change, "remove"));
            } else {
                world.remove(id(change, "remove"));
            }
        } else if (change.has("rename")) {
            world.restoreName(id(change, "rename"), Trees.text(change, "to"));
        } else if (change.has("attach")) {
            world.attach(
                    id(change, "attach"), id(change, "parent"), pose(Trees.field(change, "pose")));
        } else if (change.has("detach")) {
            world.detach(id(change, "detach"));
        } else if (change.has("edit")) {
            edit(world.item(id(change, "edit")), change);
        } else if (change.has("push")) {
            world.forces()
                    .add(
                            new Force(
                                    id(change, "push"),
                                    Arrays.stream(Trees.numbers(Trees.field(change, "newtons")))
                                            .boxed()
                                            .toList(),
                                    Trees.integer(change, "frames")));
        } else {
            writeColumn(world, change);
        }
    }

    private void add(World world, JsonNode change) {
        List<ItemDefinition> items = Trees.list(change, "items").stream().map(texts::read).toList();
        String maker = change.has("maker") ? Trees.text(change, "maker") : null;
        Item first = world.addAll(items, maker).getFirst();
        if (!first.id().equals(id(change, "add"))) {
            throw new CorruptException(
                    first + " was added, expected an item with the id " + id(change, "add"));
        }
    }

    private Map<String, Object> added(WorldChange.Added added) {
        Map<String, Object> tree =
                tree(
                        "add",
                        added.first().value(),
                        "items",
                        added.definitions().stream().map(texts::tree).toList());
        if (added.maker() != null) {
            tree.put("maker", added.maker());
        }
        return tree;
    }

    private Map<String, Object> edited(WorldChange.Edited edited) {
        Map<String, Object> tree =
                tree(
                        "edit",
                        edited.item().value(),
                        "aspect",
                        edited.aspect().name(),
                        "property",
                        edited.property());
        Object to = edited.to();
        if (to != null) {
            tree.put("to", value(to));
        }
        return tree;
    }

    private Object value(Object to) {
        return switch (to) {
            case Shape shape -> texts.write(shape);
            case Material material -> texts.write(material);
            case Colour colour -> colour.toString();
            case Action action -> texts.write(action);
            case List<?> list ->
                    list.stream()
                            .map(element -> element instanceof ItemId id ? id.value() : element)
                            .toList();
            default -> to;
        };
    }

    private void edit(Item item, JsonNode change) {
        String property = Trees.text(change, "property");
        JsonNode to = change.path("to");
        switch (WorldChange.Aspect.valueOf(Trees.text(change, "aspect"))) {
            case PHYSICAL -> editPhysical(item, property, to);
            case SEMANTIC -> {
                if (to.isMissingNode()) {
                    item.semantic().remove(property);
                } else {
                    item.semantic().restore(property, Trees.value(to));
                }
            }
            case ACCESS -> {
                if (to.isMissingNode()) {
                    item.access().remove(property);
                } else {
                    item.access().set(texts.readAction(Trees.text("the field to", to)));
                }
            }
            case PHYSICS -> editPhysics(item, property, to);
        }
    }

    private void editPhysical(Item item, String property, JsonNode to) {
        switch (property) {
            case "location" -> {
                double[] n = Trees.numbers(to);
                item.physical().setLocation(n[0], n[1], n[2]);
            }
            case "orientation" -> {
                double[] n = Trees.numbers(to);
                item.physical().setOrientation(n[0], n[1], n[2], n[3]);
            }
            case "shape" ->
                    item.physical().setShape(texts.readShape(Trees.text("the field to", to)));
            case "material" ->
                    item.physical()
                            .setMaterial(
                                    to.isMissingNode()
                                            ? Optional.empty()
                                            : Optional.of(
                                                    texts.readMaterial(
                                                            Trees.text("the field to", to))));
            case "colour" ->
                    item.physical().setColour(Colour.parse(Trees.text("the field to", to)));
            case ConnectionLook.WIDTH -> {
                if (!to.isNumber()) {
                    throw new CorruptException("found " + to + ", expected a width [m]");
                }
                item.physical().setWidth(to.asDouble());
            }
            default ->
                    throw new CorruptException(
                            "the physical aspect has no " + property + " that could be set");
        }
    }

    private static void editPhysics(Item item, String property, JsonNode to) {
        if (to.isMissingNode()) {
            // The clearing of the aspect is recorded as one change per property. The first of these
            // changes clears all properties.
            item.physics().clear();
        } else if (to.path(0).isIntegralNumber()) {
            item.physics().setReferences(property, references(to));
        } else {
            item.physics().set(property, Trees.numbers(to));
        }
    }

    /**
     * Reads ids of items. They are written as integers, while other numbers have a decimal point.
     */
    private static ItemId[] references(JsonNode to) {
        ItemId[] ids = new ItemId[to.size()];
        for (int i = 0; i < ids.length; i++) {
            ids[i] = new ItemId(Trees.integer(to.get(i)));
        }
        return ids;
    }

    private static void writeColumn(World world, JsonNode change) {
        Column column =
                world.table(Trees.text(change, "kind")).column(Trees.text(change, "column"));
        byte[] rows = Base64.getDecoder().decode(Trees.text(change, "rows"));
        if (rows.length != column.segment().byteSize()) {
            throw new CorruptException(
                    column
                            + " holds "
                            + column.segment().byteSize()
                            + " bytes, found "
                            + rows.length);
        }
        MemorySegment.copy(rows, 0, column.segment(), ValueLayout.JAVA_BYTE, 0, rows.length);
        column.touch();
    }

    static Pose pose(JsonNode numbers) {
        double[] n = Trees.numbers(numbers);
        if (n.length != 7) {
            throw new CorruptException("a pose has " + n.length + " numbers");
        }
        return new Pose(n[0], n[1], n[2], n[3], n[4], n[5], n[6]);
    }

    static List<Double> numbers(Pose pose) {
        return List.of(pose.x(), pose.y(), pose.z(), pose.qx(), pose.qy(), pose.qz(), pose.qw());
    }

    private static ItemId id(JsonNode change, String name) {
        return new ItemId(Trees.integer(change, name));
    }

    private static String shortened(JsonNode change) {
        String text = change.toString();
        return text.length() > 200 ? text.substring(0, 200) + "..." : text;
    }

    /**
     * Returns a map from a list of alternating keys and values. The map has the order of the list.
     */
    private static Map<String, Object> tree(Object... keysAndValues) {
        Map<String, Object> tree = new LinkedHashMap<>();
        for (int i = 0; i < keysAndValues.length; i += 2) {
            tree.put((String) keysAndValues[i], keysAndValues[i + 1]);
        }
        return tree;
    }
}
