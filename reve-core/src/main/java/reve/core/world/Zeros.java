package reve.core.world;

/** Memory that is zero and stays so, for all columns of a ring that are. World's thread only. */
final class Zeros {

    private ColumnBuffers.Buffer zeros = ColumnBuffers.NONE;

    /** At least that many bytes. */
    ColumnBuffers.Buffer of(long bytes) {
        if (zeros.memory().byteSize() < bytes) {
            zeros = ColumnBuffers.zeros(Math.max(bytes, 2 * zeros.memory().byteSize()));
        }
        return zeros;
    }
}
