package reve.core.world;

/** The type of one number in a column. */
public enum ScalarType {
    F32(Float.BYTES),
    F64(Double.BYTES),
    I32(Integer.BYTES),
    U32(Integer.BYTES),
    /** The {@link ItemId} of another item; 0 means none. */
    REF(Long.BYTES);

    private static final double MAX_F64 = 1e100;
    private static final double MAX_F32 = 1e30;

    private final int bytes;

    ScalarType(int bytes) {
        this.bytes = bytes;
    }

    /** Size of one number [byte]. */
    public int bytes() {
        return bytes;
    }

    /**
     * Whether an action or an edit may give a column of this type the number, in SI units. Reals
     * are bounded far below what the type holds, so that sums of forces and cubes of distances
     * stay finite: 1e100, in single precision 1e30.
     */
    public boolean takes(double value) {
        return holds(value) && switch (this) {
            case F64 -> Math.abs(value) <= MAX_F64;
            case F32 -> Math.abs(value) <= MAX_F32;
            case I32, U32, REF -> true;
        };
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
