// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

/** The seven SI base units, in the order of {@link Unit#exponents()}. */
public enum SiBase {
    /** Length. */
    METRE("m"),
    /** Mass. */
    KILOGRAM("kg"),
    /** Time. */
    SECOND("s"),
    /** Electric current. */
    AMPERE("A"),
    /** Temperature. */
    KELVIN("K"),
    /** Amount of substance. */
    MOLE("mol"),
    /** Luminous intensity. */
    CANDELA("cd");

    private final String symbol;

    SiBase(String symbol) {
        this.symbol = symbol;
    }

    /** Returns the symbol of this base unit, such as {@code kg}. */
    public String symbol() {
        return symbol;
    }
}
