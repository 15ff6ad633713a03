// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import reve.core.world.Column;
import reve.core.world.ItemId;
import reve.core.world.Table;
import reve.core.world.World;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/**
 * A short digest of all columns of a world. It contains two numbers for each column, both modulo
 * 2^64. The first number is the sum of the hashes of all rows. The second is the same sum, in which
 * each hash is multiplied by the id of the row's item. For the world's thread only.
 *
 * <p>Two worlds with different columns have different digests, except with a negligible
 * probability. The two numbers of a column also identify the item if the column differs in one item
 * only.
 */
public final class WorldDigest {

    /**
     * Name of the part of the digest for the order of rows. This part covers the item in each row
     * and the number of rows with a physics aspect.
     */
    public static final String ROWS = "rows";

    private static final long FACTOR = 0x9E3779B97F4A7C15L;

    private final World world;
    private final List<Part> parts = new ArrayList<>();

    /**
     * The data that two numbers of the digest cover. These are a column or, if {@code column} is
     * empty, the order of rows.
     */
    private record Part(Table table, Optional<Column> column) {}

    /**
     * The first difference between two worlds of the same prototype.
     *
     * @param property the property that differs; {@link #ROWS} if the items of the kind or their
     *     order differ
     * @param item the only item that differs in this property; empty if several items differ
     */
    public record Difference(String kind, String property, Optional<ItemId> item) {}

    /** Prepares digests of a world. The set of its tables must not change. */
    public WorldDigest(World world) {
        this.world = world;
        for (Table table : world.tables()) {
            parts.add(new Part(table, Optional.empty()));
            table.columns().forEach(column -> parts.add(new Part(table, Optional.of(column))));
        }
    }

    /** Returns the number of numbers in the digest. */
    public int size() {
        return 2 * parts.size();
    }

    /** Writes the digest, which has {@link #size} numbers. Allocates no memory. */
    public void compute(long[] into) {
        for (int i = 0; i < parts.size(); i++) {
            Part part = parts.get(i);
            if (part.column.isPresent()) {
                sum(part.table, part.column.get(), into, 2 * i);
            } else {
                sumRows(part.table, into, 2 * i);
            }
        }
    }

    /**
     * Returns the first difference between the world and the digest of another world, in the order
     * of the prototype. Prefers a difference that identifies an item.
     */
    public Optional<Difference> firstDifference(long[] others) {
        long[] own = new long[size()];
        compute(own);
        Optional<Difference> first = Optional.empty();
        for (int i = 0; i < parts.size(); i++) {
            long plain = others[2 * i] - own[2 * i];
            long weighted = others[2 * i + 1] - own[2 * i + 1];
            if (plain != 0 || weighted != 0) {
                Difference found = difference(parts.get(i), plain, weighted);
                if (found.item.isPresent() || found.property.equals(ROWS)) {
                    return Optional.of(found); // one item is more precise than several items
                }
                first = first.or(() -> Optional.of(found));
            }
        }
        return first;
    }

    private static Difference difference(Part part, long plain, long weighted) {
        Table table = part.table;
        if (part.column.isEmpty()) {
            return new Difference(table.kind(), ROWS, Optional.empty());
        }
        Optional<ItemId> only = Optional.empty();
        for (int row = 0; row < table.rowCount() && only.isEmpty(); row++) {
            if (table.idAt(row).value() * plain == weighted) {
                only = Optional.of(table.idAt(row));
            }
        }
        return new Difference(table.kind(), part.column.get().name(), only);
    }

    private static void sumRows(Table table, long[] into, int at) {
        long plain = mix(table.physicsRowCount(), table.rowCount());
        for (int row = 0; row < table.rowCount(); row++) {
            plain += mix(row, table.idAt(row).value());
        }
        into[at] = plain;
        into[at + 1] = 0;
    }

    private static void sum(Table table, Column column, long[] into, int at) {
        MemorySegment values = column.segment();
        int components = column.components();
        long plain = 0;
        long weighted = 0;
        boolean wide = column.type().bytes() == Long.BYTES;
        for (int row = 0; row < table.rowCount(); row++) {
            long first = (long) row * components;
            long hash =
                    wide
                            ? hashLongs(values, first, components)
                            : hashInts(values, first, components);
            plain += hash;
            weighted += hash * table.idAt(row).value();
        }
        into[at] = plain;
        into[at + 1] = weighted;
    }

    private static long hashLongs(MemorySegment values, long first, int count) {
        long hash = count;
        for (long i = first; i < first + count; i++) {
            hash = mix(hash, values.getAtIndex(ValueLayout.JAVA_LONG, i));
        }
        return hash;
    }

    private static long hashInts(MemorySegment values, long first, int count) {
        long hash = count;
        for (long i = first; i < first + count; i++) {
            hash = mix(hash, values.getAtIndex(ValueLayout.JAVA_INT, i));
        }
        return hash;
    }

    /**
     * Hashes two numbers so that each bit of both affects the result. Uses the finalizer of
     * SplitMix64.
     */
    private static long mix(long hash, long word) {
        long mixed = (hash * FACTOR ^ word) * 0xBF58476D1CE4E5B9L;
        mixed = (mixed ^ mixed >>> 29) * 0x94D049BB133111EBL;
        return mixed ^ mixed >>> 32;
    }
}
