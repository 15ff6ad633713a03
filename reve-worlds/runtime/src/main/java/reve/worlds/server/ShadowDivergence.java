// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.ScalarType;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.Comparator;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.PriorityQueue;

/**
 * The differences between the bodies of a copy and those of the world, in the same frame.
 *
 * @param position largest distance between a body and its copy [unit of position]
 * @param positionItem name of this body; empty if all distances are 0
 * @param velocity largest difference of velocities [unit of velocity]
 * @param velocityItem name of this body
 * @param items the bodies with the largest differences, largest distance first
 */
record ShadowDivergence(
        double position,
        String positionItem,
        double velocity,
        String velocityItem,
        List<OfItem> items) {
    static final ShadowDivergence NONE = new ShadowDivergence(0, "", 0, "", List.of());

    /** Maximum number of bodies in {@code items}. */
    private static final int MOST_ITEMS = 64;

    private static final Comparator<Row> LARGEST_LAST =
            Comparator.comparingDouble(Row::position)
                    .thenComparingDouble(Row::velocity)
                    .thenComparing(Comparator.comparingInt(Row::row).reversed());

    /** The differences of one body. */
    record OfItem(String item, double position, double velocity) {
        Map<String, Object> fields() {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("item", item);
            fields.put(ShadowFrame.POSITION, position);
            fields.put(ShadowFrame.VELOCITY, velocity);
            return fields;
        }
    }

    private record Row(int row, double position, double velocity) {}

    /**
     * Compares a copy with a frame of the world. For the copy's thread only.
     *
     * @throws IllegalArgumentException if they have different bodies
     */
    static ShadowDivergence of(World copy, ShadowFrame frame) {
        Table bodies = copy.table(WorldPrototype.BODY);
        double[] positions =
                distances(bodies.column(ShadowFrame.POSITION), copy, frame.positions());
        double[] velocities =
                distances(bodies.column(ShadowFrame.VELOCITY), copy, frame.velocities());
        int far = 0;
        int fast = 0;
        PriorityQueue<Row> largest = new PriorityQueue<>(LARGEST_LAST);
        for (int row = 0; row < positions.length; row++) {
            far = positions[row] > positions[far] ? row : far;
            fast = velocities[row] > velocities[fast] ? row : fast;
            if (positions[row] > 0 || velocities[row] > 0) {
                largest.add(new Row(row, positions[row], velocities[row]));
                if (largest.size() > MOST_ITEMS) {
                    largest.remove();
                }
            }
        }
        if (largest.isEmpty()) {
            return NONE;
        }
        List<Row> sorted = new ArrayList<>(largest);
        sorted.sort(LARGEST_LAST.reversed());
        return new ShadowDivergence(
                positions[far],
                positions[far] > 0 ? name(copy, bodies, far) : "",
                velocities[fast],
                velocities[fast] > 0 ? name(copy, bodies, fast) : "",
                sorted.stream()
                        .map(
                                one ->
                                        new OfItem(
                                                name(copy, bodies, one.row),
                                                one.position,
                                                one.velocity))
                        .toList());
    }

    private static String name(World copy, Table bodies, int row) {
        Item item = copy.item(bodies.idAt(row));
        return item.name();
    }

    /**
     * Returns, for each row with physics, the Euclidean distance between the values of the copy and
     * of the world.
     */
    private static double[] distances(Column column, World copy, byte[] ofWorld) {
        MemorySegment there = ShadowFrame.rows(copy, column.name());
        MemorySegment here = MemorySegment.ofArray(ofWorld);
        if (there.byteSize() != here.byteSize()) {
            throw new IllegalArgumentException(
                    "the shadow has "
                            + there.byteSize() / column.descriptor().rowBytes()
                            + " bodies, the world "
                            + here.byteSize() / column.descriptor().rowBytes());
        }
        double[] distances = new double[(int) (there.byteSize() / column.descriptor().rowBytes())];
        int components = column.components();
        for (int row = 0; row < distances.length; row++) {
            double squares = 0;
            for (int i = row * components; i < (row + 1) * components; i++) {
                double difference = number(there, column, i) - number(here, column, i);
                squares += difference * difference;
            }
            distances[row] = Math.sqrt(squares);
        }
        return distances;
    }

    /** Returns a number of a column of reals. */
    static double number(MemorySegment rows, Column column, int index) {
        return column.type() == ScalarType.F64
                ? rows.get(ValueLayout.JAVA_DOUBLE_UNALIGNED, (long) index * Double.BYTES)
                : rows.get(ValueLayout.JAVA_FLOAT_UNALIGNED, (long) index * Float.BYTES);
    }

    /** Returns the fields of an event, which contain the largest differences. */
    Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put(ShadowFrame.POSITION, position);
        fields.put("positionItem", positionItem);
        fields.put(ShadowFrame.VELOCITY, velocity);
        fields.put("velocityItem", velocityItem);
        return fields;
    }
}
