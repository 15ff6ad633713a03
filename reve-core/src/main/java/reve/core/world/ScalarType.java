package reve.core.world;

/** The type of one number in a column. */
public enum ScalarType {
    F32(Float.BYTES),
    F64(Double.BYTES),
    I32(Integer.BYTES),
    U32(Integer.BYTES),
    /** The {@link ItemId} of another item; 0 means none. */
    REF(Long.BYTES);

    private final int bytes;

    ScalarType(int bytes) {
        this.bytes = bytes;
    }

    /** Size of one number [byte]. */
    public int bytes() {
        return bytes;
    }

    /** Whether a column of this type can hold the number; reals may be rounded, not overflow. */
    public boolean holds(double value) {
        return switch (this) {
            case F64 -> Double.isFinite(value);
            case F32 -> Float.isFinite((float) value);
            case I32 -> value == (int) value;
            case U32 -> value == (long) value && value >= 0 && value <= 0xFFFF_FFFFL;
            case REF -> false;
        };
    }
}
