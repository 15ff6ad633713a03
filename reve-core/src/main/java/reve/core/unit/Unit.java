// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

import java.util.Arrays;

/**
 * A physical unit: {@code scale * m^a * kg^b * s^c * A^d * K^e * mol^f * cd^g}. Angles are numbers
 * (rad = 1). Units with a zero point of their own (degrees Celsius) do not exist here: a number in
 * a unit becomes a number in SI by one multiplication.
 *
 * <p>Immutable, any thread. Two units are equal when dimension and scale are; the symbol is only
 * how it was written.
 */
public final class Unit {
    /** The unit of plain numbers and of angles in radians. */
    public static final Unit ONE = new Unit(new byte[SiBase.values().length], 1.0, "1");

    private final byte[] exponents;
    private final double scale;
    private final String symbol;

    Unit(byte[] exponents, double scale, String symbol) {
        this.exponents = exponents;
        this.scale = scale;
        this.symbol = symbol;
    }

    /**
     * Reads a unit such as {@code kg}, {@code m/s}, {@code kg*m^2/s^2}, {@code km/h}, {@code N·s},
     * {@code m^3/(kg*s^2)}, {@code deg} or {@code 1}; {@code *} and {@code /} are taken from left
     * to right.
     *
     * @throws IllegalArgumentException naming the text and what is wrong with it
     */
    public static Unit parse(String text) {
        return UnitParser.parse(text);
    }

    /** The exponent of one SI base unit. */
    public int exponent(SiBase base) {
        return exponents[base.ordinal()];
    }

    /** A fresh array of the exponents of m, kg, s, A, K, mol and cd. */
    public byte[] exponents() {
        return exponents.clone();
    }

    /** How many coherent SI units one of this unit is: 1000 for km, 1 for kg. */
    public double scale() {
        return scale;
    }

    /** The unit as it was written, without blanks. */
    public String symbol() {
        return symbol;
    }

    /** Whether a number in this unit can be converted to the other. */
    public boolean sameDimension(Unit other) {
        return Arrays.equals(exponents, other.exponents);
    }

    /** The number in coherent SI units that a number in this unit stands for. */
    public double toSi(double value) {
        return value * scale;
    }

    /**
     * The number in unit {@code to} that a number in this unit stands for; exactly the same number
     * where the scales are equal.
     *
     * @throws IllegalArgumentException if the dimensions differ
     */
    public double convert(double value, Unit to) {
        if (!sameDimension(to)) {
            throw new IllegalArgumentException("unit " + symbol + " does not fit " + to.symbol);
        }
        return scale == to.scale ? value : value * scale / to.scale;
    }

    @Override
    public boolean equals(Object other) {
        return other instanceof Unit unit && sameDimension(unit) && scale == unit.scale;
    }

    @Override
    public int hashCode() {
        return 31 * Arrays.hashCode(exponents) + Double.hashCode(scale);
    }

    @Override
    public String toString() {
        return symbol;
    }
}
