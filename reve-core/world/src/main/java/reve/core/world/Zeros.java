// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * Constant memory of zeros. All column copies in a {@link SnapshotRing} that contain only zeros
 * share it. For the world's thread only.
 */
final class Zeros {

    /**
     * Divisor that determines the reserve of new memory. Memory that must grow gets an eighth more
     * than requested, because a growing column probably grows further.
     */
    private static final int SLACK = 8;

    private ColumnBuffers.Buffer zeros = ColumnBuffers.NONE;

    /** Returns zeroed memory of at least this size [bytes]. */
    ColumnBuffers.Buffer of(long bytes) {
        if (zeros.memory().byteSize() < bytes) {
            zeros = ColumnBuffers.zeros(bytes + bytes / SLACK);
        }
        return zeros;
    }
}
