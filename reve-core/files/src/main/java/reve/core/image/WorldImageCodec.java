// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

import reve.core.mesh.Assets;
import reve.core.world.Attachment;
import reve.core.world.Force;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.TableCopy;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The codec of world images as sections. The sections {@code world} and {@code items} are JSON. A
 * further section contains the bytes of each column that is not all zeros. For one thread.
 */
public final class WorldImageCodec {

    private static final String WORLD = "world";
    private static final String ITEMS = "items";

    private final ItemTexts texts;

    /**
     * @param assets source of the items' mesh and texture files
     */
    public WorldImageCodec(WorldPrototype prototype, Assets assets) {
        texts = new ItemTexts(prototype, assets);
    }

    /**
     * Encodes an image as sections.
     *
     * @throws IllegalArgumentException naming item and action if a world file cannot declare an
     *     action of an item
     */
    public Map<String, byte[]> write(WorldImage image) {
        Map<String, byte[]> sections = new LinkedHashMap<>();
        sections.put(WORLD, Trees.write(world(image)));
        sections.put(ITEMS, Trees.write(items(image.symbols().values())));
        for (TableCopy table : image.tables()) {
            for (int i = 0; i < table.properties().size(); i++) {
                byte[] rows = table.column(i).toArray(ValueLayout.JAVA_BYTE);
                if (!isZero(rows)) {
                    sections.put(section(table, i), rows);
                }
            }
        }
        return sections;
    }

    /**
     * Decodes sections into an image of a world with the same prototype.
     *
     * @throws CorruptException if the sections belong to another prototype or contradict each other
     */
    public void read(Map<String, byte[]> sections, WorldImage into) {
        try {
            readUnchecked(sections, into);
        } catch (IllegalArgumentException | JacksonException e) {
            throw new CorruptException("it contradicts itself: " + e.getMessage(), e);
        }
    }

    private void readUnchecked(Map<String, byte[]> sections, WorldImage into) {
        JsonNode world = Trees.read(required(sections, WORLD));
        if (!Trees.text(world, "byteOrder").equals(ByteOrder.nativeOrder().toString())) {
            throw new CorruptException("it was written on a machine of the other byte order");
        }
        List<JsonNode> tables = Trees.list(world, "tables");
        if (tables.size() != into.tables().size()) {
            throw new CorruptException(tables.size() + " kinds, expected " + into.tables().size());
        }
        PMap<ItemId, ItemSymbols> items =
                TreePMap.from(readItems(Trees.read(required(sections, ITEMS))));
        for (int i = 0; i < tables.size(); i++) {
            readTable(tables.get(i), items.size(), sections, into.tables().get(i));
        }
        into.setSymbolic(Trees.integer(world, "frame"), Trees.integer(world, "lastId"), items);
        into.setAge(Trees.integer(world, "age"));
        into.setForces(Trees.list(world, "forces").stream().map(WorldImageCodec::force).toList());
    }

    private static Map<String, Object> world(WorldImage image) {
        Map<String, Object> world = new LinkedHashMap<>();
        world.put("frame", image.frame());
        world.put("age", image.age());
        world.put("lastId", image.lastId());
        world.put(
                "forces",
                image.forces().stream()
                        .map(
                                force ->
                                        List.of(
                                                force.item().value(),
                                                force.newtons(),
                                                force.frames()))
                        .toList());
        world.put("byteOrder", ByteOrder.nativeOrder().toString());
        world.put(
                "tables",
                image.tables().stream()
                        .map(
                                table ->
                                        Map.of(
                                                "kind",
                                                table.kind(),
                                                "rows",
                                                table.rowCount(),
                                                "physicsRows",
                                                table.physicsRowCount()))
                        .toList());
        return world;
    }

    private static Force force(JsonNode tree) {
        double[] newtons = Trees.numbers(tree.path(1));
        if (newtons.length != 3) {
            throw new CorruptException("a force has " + newtons.length + " components");
        }
        return new Force(
                new ItemId(Trees.integer(tree.path(0))),
                List.of(newtons[0], newtons[1], newtons[2]),
                Trees.integer(tree.path(2)));
    }

    /**
     * Returns a tree of items, which is the section {@code items} of an image. It contains these
     * data:
     *
     * <ul>
     *   <li>the distinct texts of items
     *   <li>for each item its id, name, text and symbols, and if it is attached its parent and pose
     *   <li>the symbols that rules have set
     *   <li>for each agent the ids of the items that its actions created
     * </ul>
     */
    Map<String, Object> items(Collection<ItemSymbols> symbols) {
        Map<String, Integer> places = new LinkedHashMap<>();
        List<List<Object>> items = new ArrayList<>();
        List<List<Object>> derived = new ArrayList<>();
        Map<String, List<Long>> made = new LinkedHashMap<>();
        for (ItemSymbols item : symbols) {
            String text = texts.write(item);
            int place = places.computeIfAbsent(text, any -> places.size());
            List<Object> entry =
                    new ArrayList<>(List.of(item.id().value(), item.name(), place, item.given()));
            Attachment attachment = item.attachment();
            if (attachment != null) {
                entry.add(attachment.parent().value());
                entry.add(ChangeCodec.numbers(attachment.pose()));
            }
            items.add(entry);
            if (!item.derived().isEmpty()) {
                derived.add(List.of(item.id().value(), item.derived()));
            }
            if (item.maker() != null) {
                made.computeIfAbsent(item.maker(), any -> new ArrayList<>()).add(item.id().value());
            }
        }
        return Map.of(
                "texts",
                List.copyOf(places.keySet()),
                "items",
                items,
                "derived",
                derived,
                "made",
                made);
    }

    /** Returns the items of a tree by id. */
    Map<ItemId, ItemSymbols> readItems(JsonNode tree) {
        List<ItemDefinition> definitions =
                Trees.list(tree, "texts").stream()
                        .map(text -> texts.read(Trees.text("an item", text)))
                        .toList();
        Map<ItemId, ItemSymbols> items = new LinkedHashMap<>();
        for (JsonNode entry : Trees.list(tree, "items")) {
            var id = new ItemId(Trees.integer(entry.path(0)));
            int place = (int) Trees.integer(entry.path(2));
            if (place < 0 || place >= definitions.size()) {
                throw new CorruptException("item " + id + " has no text");
            }
            String name = Trees.text("a name", entry.path(1));
            items.put(
                    id,
                    texts.read(id, name, definitions.get(place))
                            .withGiven(Trees.values(entry.path(3)))
                            .attached(attachment(entry)));
        }
        for (JsonNode entry : Trees.list(tree, "derived")) {
            var id = new ItemId(Trees.integer(entry.path(0)));
            if (items.computeIfPresent(
                            id, (any, item) -> item.withDerived(Trees.values(entry.path(1))))
                    == null) {
                throw new CorruptException("symbols of item " + id + ", which does not exist");
            }
        }
        for (Map.Entry<String, JsonNode> maker : tree.path("made").properties()) {
            for (JsonNode entry : Trees.list(tree.path("made"), maker.getKey())) {
                var id = new ItemId(Trees.integer(entry));
                if (items.computeIfPresent(id, (any, item) -> item.madeBy(maker.getKey()))
                        == null) {
                    throw new CorruptException(
                            "the maker of item " + id + ", which does not exist");
                }
            }
        }
        return items;
    }

    private static @Nullable Attachment attachment(JsonNode entry) {
        if (entry.size() <= 4) {
            return null;
        }
        return new Attachment(
                new ItemId(Trees.integer(entry.get(4))), ChangeCodec.pose(entry.path(5)));
    }

    /**
     * Decodes the rows of a table.
     *
     * @param items total number of items, which limits the number of rows
     */
    private static void readTable(
            JsonNode tree, int items, Map<String, byte[]> sections, TableCopy into) {
        String kind = Trees.text(tree, "kind");
        if (!kind.equals(into.kind())) {
            throw new CorruptException("kind " + kind + ", expected " + into.kind());
        }
        int rows = Trees.count(tree, "rows", items);
        into.resize(rows, Trees.count(tree, "physicsRows", rows));
        for (int i = 0; i < into.properties().size(); i++) {
            MemorySegment column = into.column(i);
            byte[] bytes = sections.get(section(into, i));
            if (bytes == null) {
                column.fill((byte) 0);
            } else if (bytes.length == column.byteSize()) {
                MemorySegment.copy(bytes, 0, column, ValueLayout.JAVA_BYTE, 0, bytes.length);
            } else {
                throw new CorruptException(
                        section(into, i)
                                + " has "
                                + bytes.length
                                + " bytes, expected "
                                + column.byteSize());
            }
        }
    }

    private static String section(TableCopy table, int column) {
        return table.kind() + "." + table.properties().get(column).name();
    }

    private static byte[] required(Map<String, byte[]> sections, String name) {
        byte[] bytes = sections.get(name);
        if (bytes == null) {
            throw new CorruptException("the section " + name + " is missing");
        }
        return bytes;
    }

    private static boolean isZero(byte[] bytes) {
        for (byte b : bytes) {
            if (b != 0) {
                return false;
            }
        }
        return true;
    }
}
