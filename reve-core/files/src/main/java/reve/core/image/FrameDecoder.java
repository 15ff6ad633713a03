// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import org.pcollections.PMap;
import org.pcollections.TreePMap;

import reve.core.mesh.Assets;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.TableCopy;
import reve.core.world.WorldEvent;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * Decodes the frames of a {@link FrameEncoder} into an image of the world. All frames must be read,
 * in their order, from the first one on. For one thread.
 */
public final class FrameDecoder {
    private final WorldImageCodec codec;
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();

    /** The highest id of any item so far. */
    private long lastId;

    /**
     * A decoded frame.
     *
     * @param time simulated time at the end of the frame [s]
     * @param events the events since the previous frame that was encoded
     */
    public record Frame(long frame, double time, List<WorldEvent> events) {}

    /**
     * @param assets source of the items' mesh and texture files
     */
    public FrameDecoder(WorldPrototype prototype, Assets assets) {
        codec = new WorldImageCodec(prototype, assets);
    }

    /**
     * Decodes a frame.
     *
     * @param into the image that contains the previous frame; empty before the first one. It
     *     contains neither the age of the world nor forces of actions
     * @throws CorruptException if the frame belongs to another world or contradicts itself; the
     *     image is then invalid
     */
    public Frame read(byte[] bytes, WorldImage into) {
        Map<String, byte[]> sections = Sections.read(bytes);
        try {
            byte[] head = sections.get(FrameEncoder.FRAME);
            if (head == null) {
                throw new CorruptException("it has no section " + FrameEncoder.FRAME);
            }
            return read(Trees.read(head), sections, into);
        } catch (IllegalArgumentException | JacksonException e) {
            throw new CorruptException("it contradicts itself: " + e.getMessage(), e);
        }
    }

    private Frame read(JsonNode frame, Map<String, byte[]> sections, WorldImage into) {
        if (!Trees.text(frame, "byteOrder").equals(ByteOrder.nativeOrder().toString())) {
            throw new CorruptException("it comes from a machine of the other byte order");
        }
        readItems(frame);
        List<JsonNode> rows = Trees.list(frame, "rows");
        if (rows.size() != into.tables().size()) {
            throw new CorruptException(rows.size() + " kinds, expected " + into.tables().size());
        }
        for (int i = 0; i < rows.size(); i++) {
            readTable(rows.get(i), sections, into.tables().get(i));
        }
        long number = Trees.integer(frame, "frame");
        into.setSymbolic(number, lastId, symbols);
        return new Frame(
                number,
                Trees.number("time", Trees.field(frame, "time")),
                Trees.listIfAny(frame, "events").stream().map(FrameDecoder::event).toList());
    }

    private void readItems(JsonNode frame) {
        Map<ItemId, ItemSymbols> changed = new HashMap<>();
        if (frame.has("items")) {
            changed.putAll(codec.readItems(frame.get("items")));
        }
        for (JsonNode entry : Trees.listIfAny(frame, "symbols")) {
            var id = new ItemId(Trees.integer(entry.path(0)));
            ItemSymbols item = symbols.get(id);
            if (item == null) {
                throw new CorruptException("symbols of item " + id + ", which does not exist");
            }
            item = item.withDerived(Trees.values(entry.path(1)));
            changed.put(id, entry.size() < 3 ? item : item.withGiven(Trees.values(entry.get(2))));
        }
        changed.keySet().forEach(id -> lastId = Math.max(lastId, id.value()));
        symbols = symbols.plusAll(changed);
        for (JsonNode id : Trees.listIfAny(frame, "removed")) {
            symbols = symbols.minus(new ItemId(Trees.integer(id)));
        }
    }

    private void readTable(JsonNode counts, Map<String, byte[]> sections, TableCopy into) {
        int rows = (int) Trees.integer(counts.path(0));
        int physicsRows = (int) Trees.integer(counts.path(1));
        if (rows < 0 || rows > symbols.size()) {
            throw new CorruptException(rows + " rows, but " + symbols.size() + " items");
        }
        boolean isSameSize = rows == into.rowCount();
        into.resize(rows, physicsRows);
        for (int i = 0; i < into.properties().size(); i++) {
            String section = FrameEncoder.section(into.kind(), into.properties().get(i).name());
            byte[] bytes = sections.get(section);
            if (bytes != null) {
                readColumn(section, bytes, into.column(i), into.properties().get(i).rowBytes());
            } else if (!isSameSize && into.column(i).byteSize() > 0) {
                throw new CorruptException("the section " + section + " is missing");
            }
        }
    }

    private static void readColumn(
            String section, byte[] bytes, MemorySegment column, int rowBytes) {
        long begin =
                bytes.length < Integer.BYTES
                        ? -1
                        : (long) rowBytes
                                * ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN).getInt();
        int length = bytes.length - Integer.BYTES;
        if (begin < 0 || begin + length > column.byteSize()) {
            throw new CorruptException(
                    "the section "
                            + section
                            + " has "
                            + bytes.length
                            + " bytes for a column of "
                            + column.byteSize());
        }
        MemorySegment.copy(bytes, Integer.BYTES, column, ValueLayout.JAVA_BYTE, begin, length);
    }

    private static WorldEvent event(JsonNode tree) {
        Map<String, Object> fields = new LinkedHashMap<>();
        Trees.field(tree, "fields")
                .properties()
                .forEach(field -> fields.put(field.getKey(), value(field.getValue())));
        return new WorldEvent(Trees.integer(tree, "frame"), Trees.text(tree, "type"), fields);
    }

    /** Returns a value of an event; whole numbers stay whole, so that they are sent as such. */
    private static Object value(JsonNode node) {
        return node.isIntegralNumber() ? (Object) node.asLong() : Trees.value(node);
    }
}
