// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * Constant memory of zeros, shared by all columns of a ring that contain only zeros. World's thread
 * only.
 */
final class Zeros {

    /**
     * Larger memory is allocated with this fraction more, because a growing column probably grows
     * further.
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
