// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;

/** The type of one number in a column. */
public enum ScalarType {
    /** 4-byte floating point number. */
    F32(Float.BYTES),
    /** 8-byte floating point number. */
    F64(Double.BYTES),
    /** 4-byte signed integer. */
    I32(Integer.BYTES),
    /** 4-byte unsigned integer. */
    U32(Integer.BYTES),
    /** The {@link ItemId} of another item; 0 means none. */
    REF(Long.BYTES);

    /**
     * Maximum magnitude of 64-bit numbers that files, actions and edits may set, in the unit of the
     * property.
     */
    public static final double MAX_F64 = 1e100;

    /**
     * Minimum magnitude of 64-bit numbers other than 0 that files, actions and edits may set, in
     * the unit of the property.
     */
    public static final double MIN_F64 = 1e-100;

    private static final double MAX_F32 = 1e30;
    private static final double MIN_F32 = 1e-35;

    private final int bytes;

    ScalarType(int bytes) {
        this.bytes = bytes;
    }

    /** Returns the size of one number [bytes]. */
    public int bytes() {
        return bytes;
    }

    /**
     * Returns the reason why an action or an edit must not store the number in a column of this
     * type; empty if it is allowed. The number 0 is allowed. Other numbers need a magnitude of
     * 1e-100 to 1e100, or of 1e-35 to 1e30 in single precision.
     *
     * <p>The limits are narrower than the range of the type. Sums of forces, cubes of distances and
     * quotients of masses therefore stay finite.
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

    /**
     * Returns whether a column of this type can hold the number. A floating point number may be
     * rounded, but must not overflow.
     */
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
