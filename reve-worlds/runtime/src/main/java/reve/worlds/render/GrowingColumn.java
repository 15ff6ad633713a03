// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.List;

/**
 * A growing buffer of packed little-endian numbers of 4 bytes. This is the format of columns in
 * messages to the renderer.
 */
final class GrowingColumn {

    private ByteBuffer bytes = allocate(1024);

    void add(float x, float y, float z) {
        room(3).putFloat(x).putFloat(y).putFloat(z);
    }

    void add(float x, float y, float z, float w) {
        room(4).putFloat(x).putFloat(y).putFloat(z).putFloat(w);
    }

    void add(int value) {
        room(1).putInt(value);
    }

    /** Returns the added numbers; valid until the next change. */
    ByteBuffer content() {
        return bytes.duplicate().flip();
    }

    /**
     * Returns the number of rows of several columns. The columns must have the same length.
     *
     * @param components numbers per row of each column
     */
    static int sharedRowCount(List<GrowingColumn> columns, List<Integer> components) {
        int rows = columns.getFirst().bytes.position() / 4 / components.getFirst();
        for (int i = 0; i < columns.size(); i++) {
            int found = columns.get(i).bytes.position() / 4 / components.get(i);
            if (found != rows) {
                throw new IllegalStateException(
                        "column "
                                + i
                                + " of a scene has "
                                + found
                                + " rows, the first one has "
                                + rows
                                + "; give every row all its values");
            }
        }
        return rows;
    }

    private ByteBuffer room(int values) {
        if (bytes.remaining() < values * 4) {
            bytes = allocate(Math.multiplyExact(bytes.capacity(), 2)).put(bytes.flip());
        }
        return bytes;
    }

    private static ByteBuffer allocate(int capacity) {
        return ByteBuffer.allocateDirect(capacity).order(ByteOrder.LITTLE_ENDIAN);
    }
}
