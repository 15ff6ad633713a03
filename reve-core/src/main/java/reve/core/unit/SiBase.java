// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

/** The seven SI base units, in the order in which {@link Unit#exponents()} gives them. */
public enum SiBase {
    METRE("m"),
    KILOGRAM("kg"),
    SECOND("s"),
    AMPERE("A"),
    KELVIN("K"),
    MOLE("mol"),
    CANDELA("cd");

    private final String symbol;

    SiBase(String symbol) {
        this.symbol = symbol;
    }

    /** The symbol of this base unit, such as {@code kg}. */
    public String symbol() {
        return symbol;
    }
}
