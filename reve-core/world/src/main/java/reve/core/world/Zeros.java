// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** Memory that is zero and stays so, for all columns of a ring that are. World's thread only. */
final class Zeros {

    /** What outgrew the zeros is likely to go on growing. */
    private static final int SLACK = 8;

    private ColumnBuffers.Buffer zeros = ColumnBuffers.NONE;

    /** At least that many bytes. */
    ColumnBuffers.Buffer of(long bytes) {
        if (zeros.memory().byteSize() < bytes) {
            zeros = ColumnBuffers.zeros(bytes + bytes / SLACK);
        }
        return zeros;
    }
}
