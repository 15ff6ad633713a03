// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

import reve.core.world.ColumnSnapshot;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Mesh;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.TableSnapshot;
import reve.core.world.Texture;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.ByteBuffer;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Deque;
import java.util.HashMap;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;

/**
 * The newest state of a world in the form in which web pages show it. A version number counts
 * changes. Each part has the version of its last change. An item keeps the same slot (an index) as
 * long as it exists. The columns of bodies are arrays by slot, in single precision. For one thread.
 */
final class Scene {

    private static final ValueLayout.OfDouble DOUBLE = ValueLayout.JAVA_DOUBLE;
    private static final ValueLayout.OfInt INT = ValueLayout.JAVA_INT;
    private static final ValueLayout.OfLong LONG = ValueLayout.JAVA_LONG;

    private static final int[] NO_REFERENCES = {};

    private static final List<String> CONTACT_FORCES =
            List.of(WorldPrototype.CONTACT_FORCE, WorldPrototype.REACTION_FORCE);

    /** Minimum time between two comparisons of all items' symbols [ns]. */
    private static final long SYMBOLS_NANOS = 200_000_000;

    private static final int FIRST_SLOTS = 64;

    private final Map<ItemId, Integer> slotById = new HashMap<>();
    private final Deque<Integer> freeSlots = new ArrayDeque<>();
    private int slots;
    private @Nullable ItemSymbols[] items = new ItemSymbols[FIRST_SLOTS];
    private int[][] references = new int[FIRST_SLOTS][];

    /**
     * For each slot, the version of the last structural change. Such a change means that the item
     * entered, left, or changed its symbols or references.
     */
    private int[] structureChanged = new int[FIRST_SLOTS];

    private int newestStructure;
    private final Column[] columns = new Column[SceneColumns.values().length];

    /** The slot of each body, by row of the body table. */
    private int[] slotOfRow = {};

    /** Number of times that slotOfRow was computed. */
    private int mapping;

    private long[] ids = {};
    private @Nullable PMap<ItemId, ItemSymbols> symbols;
    private long symbolsNanos;
    private boolean stale = true;

    private final Contacts contacts = new Contacts();

    /** The columns whose sum is the contact force on each body; empty if the world has none. */
    private List<String> contactForces = List.of();

    private double[] forces = {};

    /** The frame whose contact forces were read last. */
    private long contactsFrame = -1;

    /** The optional columns that the last read included, one bit for each. */
    private int optional;

    private int version;
    private long frame = -1;
    private double time;

    private final Map<Object, Integer> assetIds = new IdentityHashMap<>();
    private final Map<Integer, ByteBuffer> assets = new TreeMap<>();
    private int lastAsset;

    /**
     * The values of one column, by slot. Each float in a column of colours contains the bits of an
     * integer.
     */
    private static final class Column {
        private final int components;
        private float[] values;
        private int[] changed;

        /** Version of the last change of any value. */
        private int newest;

        /** The {@link Scene#mapping} that the last read used. */
        private int mapping;

        /**
         * The bytes of the snapshot's column at the last read, with which the next read compares.
         */
        private byte[] seen = {};

        Column(int components) {
            this.components = components;
            this.values = new float[FIRST_SLOTS * components];
            this.changed = new int[FIRST_SLOTS];
        }

        boolean isSame(MemorySegment segment) {
            return segment.byteSize() == seen.length
                    && segment.mismatch(MemorySegment.ofArray(seen)) < 0;
        }

        void keep(MemorySegment segment) {
            if (seen.length != segment.byteSize()) {
                seen = new byte[(int) segment.byteSize()];
            }
            MemorySegment.ofArray(seen).copyFrom(segment);
        }
    }

    Scene() {
        for (SceneColumns column : SceneColumns.values()) {
            columns[column.ordinal()] = new Column(column.components());
        }
    }

    /**
     * Returns the version. It increases when something changes, and is 0 before the first frame.
     */
    int version() {
        return version;
    }

    long frame() {
        return frame;
    }

    double time() {
        return time;
    }

    /** Returns the number of slots. Free slots are included. */
    int slots() {
        return slots;
    }

    /** Returns the item of a slot; null if the slot is free. */
    @Nullable ItemSymbols item(int slot) {
        return items[slot];
    }

    /**
     * Returns the slots of the items to which this slot's item refers, for example the two bodies
     * of a spring. The value is -1 if there is no such item.
     */
    int[] references(int slot) {
        return references[slot] == null ? NO_REFERENCES : references[slot];
    }

    boolean hasNewStructure(int since) {
        return newestStructure > since;
    }

    boolean hasNewStructure(int slot, int since) {
        return structureChanged[slot] > since;
    }

    boolean hasChanged(SceneColumns column, int since) {
        return columns[column.ordinal()].newest > since;
    }

    boolean hasChanged(SceneColumns column, int slot, int since) {
        return columns[column.ordinal()].changed[slot] > since;
    }

    float[] values(SceneColumns column) {
        return columns[column.ordinal()].values;
    }

    /** Returns the ids of meshes and textures. Textures come before the meshes that use them. */
    Set<Integer> assets() {
        return assets.keySet();
    }

    /** Returns a mesh or a texture as a message. */
    ByteBuffer asset(int id) {
        return assets.get(id).duplicate();
    }

    /** Returns the id of a mesh or texture. Returns 0 if the scene does not contain it. */
    int assetId(Object asset) {
        return assetIds.getOrDefault(asset, 0);
    }

    /** Returns whether the world measures the contact forces on bodies. */
    boolean measuresContacts() {
        return !contactForces.isEmpty();
    }

    /** Makes the next read compare all data, including data that seems unchanged. */
    void forget() {
        stale = true;
    }

    /** Returns whether the last read included these optional columns. */
    boolean hasRead(int wanted) {
        return (wanted & ~optional) == 0;
    }

    /**
     * Reads a snapshot.
     *
     * @param wanted optional columns to read
     * @return false if the snapshot was overwritten during the read; the scene is then invalid
     *     until the next successful read
     */
    boolean read(WorldSnapshot snapshot, int wanted) {
        if (snapshot.frame() == frame && !stale && hasRead(wanted)) {
            return true;
        }
        version++;
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        try {
            boolean moved = hasOtherRows(bodies);
            long now = System.nanoTime();
            if (stale
                    || moved
                    || snapshot.symbols() != symbols && now - symbolsNanos > SYMBOLS_NANOS) {
                symbolsNanos = now;
                readStructure(snapshot, bodies);
            }
            for (SceneColumns column : SceneColumns.values()) {
                if (column == SceneColumns.CONTACTS) {
                    if (column.isWanted(wanted)) {
                        readContacts(snapshot, bodies);
                    }
                } else if (column.isWanted(wanted)) {
                    readColumn(column, bodies);
                }
            }
        } catch (RuntimeException nonsense) {
            if (!snapshot.lost()) {
                throw nonsense;
            }
        }
        if (snapshot.lost()) {
            stale = true;
            return false;
        }
        stale = false;
        optional = wanted;
        frame = snapshot.frame();
        time = snapshot.timeSeconds();
        return true;
    }

    /**
     * Copies the ids of the bodies' rows. Returns whether these ids differ from those of the last
     * read.
     */
    private boolean hasOtherRows(TableSnapshot bodies) {
        MemorySegment rows = bodies.ids().segment();
        boolean same =
                bodies.rowCount() == ids.length
                        && MemorySegment.mismatch(
                                        rows,
                                        0,
                                        rows.byteSize(),
                                        MemorySegment.ofArray(ids),
                                        0,
                                        rows.byteSize())
                                < 0;
        if (!same) {
            ids = rows.toArray(LONG);
        }
        return !same;
    }

    private void readStructure(WorldSnapshot snapshot, TableSnapshot bodies) {
        mapping++;
        contactForces =
                bodies.columns().stream()
                        .map(ColumnSnapshot::name)
                        .filter(CONTACT_FORCES::contains)
                        .toList();
        symbols = snapshot.symbols();
        boolean[] seen = new boolean[slots + symbols.size()];
        boolean mayLoseAssets = false;
        for (ItemSymbols item : symbols.values()) {
            int slot = slotById.computeIfAbsent(item.id(), id -> newSlot());
            seen[slot] = true;
            ItemSymbols before = items[slot];
            if (before != item) {
                if (before == null || looksOther(before, item)) {
                    noteStructure(slot);
                }
                mayLoseAssets |= before != null && hasAssets(before);
                items[slot] = item;
                addAssets(item);
            }
        }
        for (int slot = 0; slot < slots; slot++) {
            ItemSymbols gone = items[slot];
            if (gone != null && !seen[slot]) {
                mayLoseAssets |= hasAssets(gone);
                slotById.remove(gone.id());
                items[slot] = null;
                references[slot] = NO_REFERENCES;
                noteStructure(slot);
                freeSlots.add(slot);
            }
        }
        if (mayLoseAssets) {
            dropUnusedAssets();
        }
        if (slotOfRow.length < ids.length) {
            slotOfRow = new int[ids.length + ids.length / 4];
        }
        for (int row = 0; row < ids.length; row++) {
            slotOfRow[row] = slotById.getOrDefault(new ItemId(ids[row]), -1);
        }
        for (TableSnapshot table : snapshot.tables()) {
            if (table != bodies) {
                readReferences(table);
            }
        }
    }

    /**
     * Returns whether a change of symbols changes the drawing or the name of the item on the page.
     */
    private static boolean looksOther(ItemSymbols before, ItemSymbols after) {
        return !before.name().equals(after.name())
                || looksOther(before.shape(), after.shape())
                || !before.material().equals(after.material())
                || !before.look().equals(after.look())
                || !before.sensors().equals(after.sensors())
                || !before.get("class").equals(after.get("class"));
    }

    /**
     * Returns whether a change of the shape changes more than its size, which is a column of its
     * own.
     */
    private static boolean looksOther(Shape before, Shape after) {
        return before instanceof Mesh || after instanceof Mesh
                ? before != after
                : before.code() != after.code();
    }

    private void noteStructure(int slot) {
        structureChanged[slot] = version;
        newestStructure = version;
    }

    private int newSlot() {
        Integer free = freeSlots.poll();
        int slot = free == null ? slots++ : free;
        if (slot >= items.length) {
            int room = 2 * items.length;
            items = Arrays.copyOf(items, room);
            references = Arrays.copyOf(references, room);
            structureChanged = Arrays.copyOf(structureChanged, room);
            for (Column column : columns) {
                column.values = Arrays.copyOf(column.values, room * column.components);
                column.changed = Arrays.copyOf(column.changed, room);
            }
        }
        for (Column column : columns) {
            // A reused slot still contains the values of its earlier item.
            column.changed[slot] = version;
            column.newest = version;
        }
        contacts.forget(slot);
        Arrays.fill(columns[SceneColumns.CONTACTS.ordinal()].values, 2 * slot, 2 * slot + 2, 0);
        return slot;
    }

    private void readReferences(TableSnapshot table) {
        List<ColumnSnapshot> columns =
                table.columns().stream().filter(column -> column.type() == ScalarType.REF).toList();
        if (columns.isEmpty()) {
            return;
        }
        int count = columns.stream().mapToInt(ColumnSnapshot::components).sum();
        int[] found = new int[count];
        for (int row = 0; row < table.rowCount(); row++) {
            Integer slot = slotById.get(table.idAt(row));
            if (slot == null) {
                continue;
            }
            int at = 0;
            for (ColumnSnapshot column : columns) {
                for (int i = 0; i < column.components(); i++) {
                    long id = column.getReference(row, i);
                    found[at++] = id > 0 ? slotById.getOrDefault(new ItemId(id), -1) : -1;
                }
            }
            if (!Arrays.equals(found, references[slot])) {
                references[slot] = found.clone();
                noteStructure(slot);
            }
        }
    }

    /** Adds the contacts that begin in a frame to the counts of their bodies. */
    private void readContacts(WorldSnapshot snapshot, TableSnapshot bodies) {
        if (contactForces.isEmpty() || snapshot.frame() == contactsFrame) {
            return;
        }
        int rows = Math.min(ids.length, slotOfRow.length);
        if (forces.length < 3 * rows) {
            forces = new double[3 * slotOfRow.length];
        }
        Arrays.fill(forces, 0, 3 * rows, 0);
        for (String name : contactForces) {
            ColumnSnapshot column = bodies.column(name);
            int present = Math.min(rows, column.rowCount());
            for (int row = 0; row < present; row++) {
                for (int axis = 0; axis < 3; axis++) {
                    forces[3 * row + axis] += column.getDouble(row, axis);
                }
            }
        }
        if (snapshot.lost()) {
            return;
        }
        contactsFrame = snapshot.frame();
        Column counts = columns[SceneColumns.CONTACTS.ordinal()];
        contacts.read(
                snapshot.timeSeconds(),
                rows,
                slotOfRow,
                forces,
                (slot, newtons) -> {
                    counts.values[2 * slot]++;
                    counts.values[2 * slot + 1] = (float) newtons;
                    counts.changed[slot] = version;
                    counts.newest = version;
                });
    }

    private void readColumn(SceneColumns which, TableSnapshot bodies) {
        ColumnSnapshot source = bodies.column(which.property());
        MemorySegment segment = source.segment();
        Column column = columns[which.ordinal()];
        if (column.mapping == mapping && column.isSame(segment)) {
            return;
        }
        int rows = Math.min(Math.min(source.rowCount(), ids.length), slotOfRow.length);
        boolean any =
                switch (source.type()) {
                    case F64 -> readDoubles(segment, column, rows);
                    case F32 -> readWords(segment, column, rows);
                    case I32, U32 -> readWords(segment, column, rows);
                    case REF -> false;
                };
        if (any) {
            column.newest = version;
        }
        column.keep(segment);
        column.mapping = mapping;
    }

    private boolean readDoubles(MemorySegment segment, Column column, int rows) {
        int components = column.components;
        float[] values = column.values;
        boolean any = false;
        for (int row = 0; row < rows; row++) {
            int slot = slotOfRow[row];
            if (slot < 0) {
                continue;
            }
            boolean differs = false;
            for (int i = 0; i < components; i++) {
                float value = (float) segment.getAtIndex(DOUBLE, (long) row * components + i);
                int place = slot * components + i;
                if (Float.floatToRawIntBits(value) != Float.floatToRawIntBits(values[place])) {
                    values[place] = value;
                    differs = true;
                }
            }
            if (differs) {
                column.changed[slot] = version;
                any = true;
            }
        }
        return any;
    }

    /** Reads a column of 32-bit numbers. Their bits are not changed. */
    private boolean readWords(MemorySegment segment, Column column, int rows) {
        int components = column.components;
        float[] values = column.values;
        boolean any = false;
        for (int row = 0; row < rows; row++) {
            int slot = slotOfRow[row];
            if (slot < 0) {
                continue;
            }
            boolean differs = false;
            for (int i = 0; i < components; i++) {
                int bits = segment.getAtIndex(INT, (long) row * components + i);
                int place = slot * components + i;
                if (bits != Float.floatToRawIntBits(values[place])) {
                    values[place] = Float.intBitsToFloat(bits);
                    differs = true;
                }
            }
            if (differs) {
                column.changed[slot] = version;
                any = true;
            }
        }
        return any;
    }

    private static boolean hasAssets(ItemSymbols item) {
        return item.shape() instanceof Mesh
                || item.material().flatMap(material -> material.texture()).isPresent();
    }

    private void addAssets(ItemSymbols item) {
        for (Texture texture : textures(item)) {
            if (!assetIds.containsKey(texture)) {
                assetIds.put(texture, ++lastAsset);
                assets.put(lastAsset, AssetWriter.texture(lastAsset, texture));
            }
        }
        if (item.shape() instanceof Mesh mesh && !assetIds.containsKey(mesh)) {
            assetIds.put(mesh, ++lastAsset);
            assets.put(lastAsset, AssetWriter.mesh(lastAsset, mesh, this::assetId));
        }
    }

    /** Returns the textures of an item and of the parts of its mesh. */
    private static List<Texture> textures(ItemSymbols item) {
        List<Texture> textures = new ArrayList<>();
        item.material().flatMap(material -> material.texture()).ifPresent(textures::add);
        if (item.shape() instanceof Mesh mesh) {
            mesh.parts().forEach(part -> part.material().texture().ifPresent(textures::add));
        }
        return textures;
    }

    /** Discards meshes and textures that no item uses. Their ids are not used again. */
    private void dropUnusedAssets() {
        Map<Object, Integer> used = new IdentityHashMap<>();
        for (int slot = 0; slot < slots; slot++) {
            ItemSymbols item = items[slot];
            if (item != null) {
                textures(item).forEach(texture -> used.put(texture, assetId(texture)));
                if (item.shape() instanceof Mesh mesh) {
                    used.put(mesh, assetId(mesh));
                }
            }
        }
        assetIds.keySet().retainAll(used.keySet());
        assets.keySet().retainAll(Set.copyOf(used.values()));
    }
}
