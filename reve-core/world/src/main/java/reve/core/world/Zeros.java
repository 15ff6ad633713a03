// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * Constant memory of zeros, shared by all column copies in a {@link SnapshotRing} that contain only
 * zeros. World's thread only.
 */
final class Zeros {

    /**
     * Divisor: memory that must grow gets an eighth more than requested, because a growing column
     * probably grows further.
     */
    private static final int SLACK = 8;

    private ColumnBuffers.Buffer zeros = ColumnBuffers.NONE;

    /** Returns at least that many bytes of zeros. */
    ColumnBuffers.Buffer of(long bytes) {
        if (zeros.memory().byteSize() < bytes) {
            zeros = ColumnBuffers.zeros(bytes + bytes / SLACK);
        }
        return zeros;
    }
}
