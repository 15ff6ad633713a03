package reve.pe;

/** Element type of a property. */
public enum ScalarType {
    F32(Float.BYTES), F64(Double.BYTES), I32(Integer.BYTES), U32(Integer.BYTES);

    private final int bytes;

    ScalarType(int bytes) {
        this.bytes = bytes;
    }

    /** Size of one element [byte]; also its natural alignment. */
    public int bytes() {
        return bytes;
    }
}
