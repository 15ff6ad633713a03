// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import org.pcollections.PMap;
import org.pcollections.TreePMap;

import reve.core.mesh.Assets;
import reve.core.world.ColumnSnapshot;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Encodes the frames of a world for one reader that keeps a copy of the world. A frame contains
 * what has changed since the previous frame that was encoded; the first one is complete. A {@link
 * FrameDecoder} reads the frames in the same order. For one thread.
 *
 * <p>A frame consists of sections. The section {@code frame} is JSON. A further section for each
 * column that has changed contains the number of the first changed row (4 bytes) and the rows up to
 * the last changed row. The readings of sensors, the forces of actions and the state of laws are
 * left out, because observers do not perceive them.
 */
public final class FrameEncoder {
    static final String FRAME = "frame";

    private static final byte[] NOTHING = {};

    private final WorldImageCodec codec;
    private final List<List<Sent>> tables = new ArrayList<>();
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();

    /** The bytes of a column that were sent last, and those of the frame that is being encoded. */
    private static final class Sent {
        private byte[] sent = NOTHING;
        private byte[] next = NOTHING;
        private boolean changes;

        void accept() {
            if (changes) {
                byte[] before = sent;
                sent = next;
                next = before;
            }
        }
    }

    /**
     * @param assets source of the items' mesh and texture files
     */
    public FrameEncoder(WorldPrototype prototype, Assets assets) {
        codec = new WorldImageCodec(prototype, assets);
    }

    /**
     * Encodes a frame.
     *
     * @param events the events since the previous frame that was encoded
     * @return empty, without effect, if the snapshot was overwritten while it was read
     * @throws IllegalArgumentException naming item and action if an item has no form in a world
     *     file
     */
    public Optional<byte[]> write(WorldSnapshot snapshot, List<WorldEvent> events) {
        Map<String, byte[]> sections = new LinkedHashMap<>();
        sections.put(FRAME, NOTHING); // the first section
        List<List<Integer>> rows = new ArrayList<>();
        List<TableSnapshot> views = snapshot.tables();
        for (int i = 0; i < views.size(); i++) {
            TableSnapshot table = views.get(i);
            rows.add(List.of(table.rowCount(), table.physicsRowCount()));
            writeTable(table, sent(i, table), sections);
        }
        if (snapshot.lost()) {
            return Optional.empty();
        }
        tables.forEach(columns -> columns.forEach(Sent::accept));
        Map<String, Object> frame = new LinkedHashMap<>();
        frame.put("frame", snapshot.frame());
        frame.put("time", snapshot.timeSeconds());
        frame.put("byteOrder", ByteOrder.nativeOrder().toString());
        frame.put("rows", rows);
        if (snapshot.symbols() != symbols) {
            writeItems(snapshot.symbols(), frame);
            symbols = snapshot.symbols();
        }
        if (!events.isEmpty()) {
            frame.put("events", events.stream().map(FrameEncoder::tree).toList());
        }
        sections.put(FRAME, Trees.write(frame));
        return Optional.of(Sections.write(sections));
    }

    private List<Sent> sent(int place, TableSnapshot table) {
        if (place == tables.size()) {
            List<Sent> columns = new ArrayList<>();
            for (int i = 0; i <= table.columns().size(); i++) { // the first one contains the ids
                columns.add(new Sent());
            }
            tables.add(columns);
        }
        return tables.get(place);
    }

    private static void writeTable(
            TableSnapshot table, List<Sent> sent, Map<String, byte[]> sections) {
        write(table.kind(), table.ids(), sent.getFirst(), sections);
        List<ColumnSnapshot> columns = table.columns();
        for (int i = 0; i < columns.size(); i++) {
            write(table.kind(), columns.get(i), sent.get(i + 1), sections);
        }
    }

    private static void write(
            String kind, ColumnSnapshot column, Sent sent, Map<String, byte[]> sections) {
        MemorySegment now = column.segment();
        boolean isSameSize = now.byteSize() == sent.sent.length;
        long first = now.mismatch(MemorySegment.ofArray(sent.sent));
        sent.changes = first >= 0;
        if (!sent.changes) {
            return;
        }
        if (sent.next.length != now.byteSize()) {
            sent.next = new byte[(int) now.byteSize()];
        }
        MemorySegment.copy(now, ValueLayout.JAVA_BYTE, 0, sent.next, 0, sent.next.length);
        int rowBytes = column.descriptor().rowBytes();
        int firstRow = isSameSize ? (int) (first / rowBytes) : 0;
        int end = isSameSize ? endOfChange(sent.sent, sent.next, rowBytes) : sent.next.length;
        int begin = Math.min(firstRow * rowBytes, end);
        sections.put(
                section(kind, column.name()),
                ByteBuffer.allocate(Integer.BYTES + end - begin)
                        .order(ByteOrder.LITTLE_ENDIAN)
                        .putInt(firstRow)
                        .put(sent.next, begin, end - begin)
                        .array());
    }

    /** Returns the end of the last row that differs [bytes]. */
    private static int endOfChange(byte[] before, byte[] now, int rowBytes) {
        int end = now.length;
        while (end > 0 && Arrays.equals(before, end - rowBytes, end, now, end - rowBytes, end)) {
            end -= rowBytes;
        }
        return end;
    }

    static String section(String kind, String column) {
        return kind + "." + column;
    }

    /**
     * Writes the items that differ from those that were sent last: {@code items} (complete), {@code
     * symbols} (only their symbols) and {@code removed}.
     */
    private void writeItems(PMap<ItemId, ItemSymbols> now, Map<String, Object> frame) {
        List<ItemSymbols> whole = new ArrayList<>();
        List<List<Object>> values = new ArrayList<>();
        int known = 0;
        for (ItemSymbols item : now.values()) {
            ItemSymbols before = symbols.get(item.id());
            if (before != null) {
                known++;
            }
            if (before == item) {
                continue;
            }
            if (before == null || !isSameButSymbols(before, item)) {
                whole.add(item);
            } else if (before.given() == item.given()) {
                values.add(List.of(item.id().value(), item.derived()));
            } else {
                values.add(List.of(item.id().value(), item.derived(), item.given()));
            }
        }
        if (!whole.isEmpty()) {
            frame.put("items", codec.items(whole));
        }
        if (!values.isEmpty()) {
            frame.put("symbols", values);
        }
        if (known < symbols.size()) {
            frame.put(
                    "removed",
                    symbols.keySet().stream()
                            .filter(id -> !now.containsKey(id))
                            .map(ItemId::value)
                            .toList());
        }
    }

    private static boolean isSameButSymbols(ItemSymbols before, ItemSymbols now) {
        return before.likeness() == now.likeness()
                && before.attachment() == now.attachment()
                && before.name().equals(now.name());
    }

    private static Map<String, Object> tree(WorldEvent event) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("frame", event.frame());
        tree.put("type", event.type());
        tree.put("fields", event.fields());
        return tree;
    }
}
