// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/** The element type of a property's column, or {@link #FIELD} for a property without a column. */
public enum ScalarType {
    /** A real of 4 bytes. */
    F32(Float.BYTES),
    /** A real of 8 bytes. */
    F64(Double.BYTES),
    /** A signed whole number of 4 bytes. */
    I32(Integer.BYTES),
    /** An unsigned whole number of 4 bytes, or a reference to a row. */
    U32(Integer.BYTES),
    /** A function of position instead of a column; a law library provides it. */
    FIELD(0);

    private final int bytes;

    ScalarType(int bytes) {
        this.bytes = bytes;
    }

    /**
     * Returns the size of one element [byte], which is also its natural alignment; 0 for a field.
     */
    public int bytes() {
        return bytes;
    }
}
