// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/** Element type of a property's column, or {@link #FIELD}. */
public enum ScalarType {
    F32(Float.BYTES),
    F64(Double.BYTES),
    I32(Integer.BYTES),
    U32(Integer.BYTES),
    /** No column but a function of position, which a law library brings. */
    FIELD(0);

    private final int bytes;

    ScalarType(int bytes) {
        this.bytes = bytes;
    }

    /** Size of one element [byte], also its natural alignment; 0 for a field, which has none. */
    public int bytes() {
        return bytes;
    }
}
