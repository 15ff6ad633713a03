// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;

/** The type of one number in a column. */
public enum ScalarType {
    /** A real of 4 bytes. */
    F32(Float.BYTES),
    /** A real of 8 bytes. */
    F64(Double.BYTES),
    /** A signed whole number of 4 bytes. */
    I32(Integer.BYTES),
    /** An unsigned whole number of 4 bytes. */
    U32(Integer.BYTES),
    /** The {@link ItemId} of another item; 0 means none. */
    REF(Long.BYTES);

    /** Bounds of magnitudes that files, actions and edits may set, in the unit of the property. */
    public static final double MAX_F64 = 1e100;

    /** Least magnitude other than 0. */
    public static final double MIN_F64 = 1e-100;

    private static final double MAX_F32 = 1e30;
    private static final double MIN_F32 = 1e-35;

    private final int bytes;

    ScalarType(int bytes) {
        this.bytes = bytes;
    }

    /** Size of one number [byte]. */
    public int bytes() {
        return bytes;
    }

    /**
     * Why an action or an edit may not give a column of this type the number; empty if it may.
     * Reals are bounded far from what the type holds, so that sums of forces, cubes of distances
     * and quotients of masses stay finite: 0 or 1e-100 to 1e100, in single precision 1e-35 to 1e30.
     */
    public Optional<String> refusal(double value) {
        if (!holds(value)) {
            return Optional.of("it holds " + this);
        }
        return switch (this) {
            case F64 -> outside(value, MIN_F64, MAX_F64);
            case F32 -> outside(value, MIN_F32, MAX_F32);
            case I32, U32, REF -> Optional.empty();
        };
    }

    private static Optional<String> outside(double value, double least, double most) {
        double magnitude = Math.abs(value);
        return magnitude == 0 || magnitude >= least && magnitude <= most
                ? Optional.empty()
                : Optional.of(
                        "an action or an edit sets 0 or a magnitude from " + least + " to " + most);
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
