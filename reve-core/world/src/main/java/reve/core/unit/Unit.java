// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;

/**
 * A physical unit: {@code scale * m^a * kg^b * s^c * A^d * K^e * mol^f * cd^g}. Angles are numbers
 * (rad = 1). Units with an offset (degrees Celsius) are not supported, because a number is
 * converted to SI by one multiplication.
 *
 * <p>Two units are equal if dimension and scale are equal. The symbol only records how the unit was
 * written. Units are immutable. For any thread.
 */
public final class Unit {
    /** The unit of pure numbers and of angles in radians. */
    public static final Unit ONE = new Unit(new byte[SiBase.values().length], 1.0, "1");

    /** The order of base units in the symbol of a unit, such as kg*m^2/s^2. */
    private static final List<SiBase> ORDER =
            List.of(
                    SiBase.KILOGRAM,
                    SiBase.METRE,
                    SiBase.SECOND,
                    SiBase.AMPERE,
                    SiBase.KELVIN,
                    SiBase.MOLE,
                    SiBase.CANDELA);

    private final byte[] exponents;
    private final double scale;
    private final String symbol;

    Unit(byte[] exponents, double scale, String symbol) {
        this.exponents = exponents;
        this.scale = scale;
        this.symbol = symbol;
    }

    /**
     * Parses a unit such as {@code kg}, {@code m/s}, {@code kg*m^2/s^2}, {@code km/h}, {@code N·s},
     * {@code m^3/(kg*s^2)}, {@code deg} or {@code 1}. The operators {@code *} and {@code /} are
     * evaluated from left to right.
     *
     * @throws IllegalArgumentException naming the text and the error
     */
    public static Unit parse(String text) {
        return UnitParser.parse(text);
    }

    /** Returns the exponent of one SI base unit. */
    public int exponent(SiBase base) {
        return exponents[base.ordinal()];
    }

    /** Returns a new array of the exponents of m, kg, s, A, K, mol and cd. */
    public byte[] exponents() {
        return exponents.clone();
    }

    /** Returns the size of this unit in coherent SI units: 1000 for km, 1 for kg. */
    public double scale() {
        return scale;
    }

    /** Returns the unit as written, without blanks. */
    public String symbol() {
        return symbol;
    }

    /**
     * Returns the coherent SI unit of this dimension: kg for g, m/s for km/h. A unit that is
     * already coherent keeps its symbol: N, rad. Degrees become rad.
     */
    public Unit si() {
        if (scale == 1) {
            return this;
        }
        return symbol.equals("deg") || symbol.equals("°")
                ? new Unit(exponents, 1, "rad")
                : coherent(exponents);
    }

    /**
     * Returns the coherent SI unit of a product of numbers in the SI units of both dimensions.
     *
     * @throws IllegalArgumentException if an exponent is out of range
     */
    public Unit times(Unit other) {
        return combined(other, 1);
    }

    /**
     * Returns the coherent SI unit of a quotient of numbers in the SI units of both dimensions.
     *
     * @throws IllegalArgumentException if an exponent is out of range
     */
    public Unit per(Unit other) {
        return combined(other, -1);
    }

    private Unit combined(Unit other, int sign) {
        byte[] sums = new byte[exponents.length];
        for (int i = 0; i < sums.length; i++) {
            int sum = exponents[i] + sign * other.exponents[i];
            if (sum != (byte) sum) {
                throw new IllegalArgumentException(
                        "the exponent " + sum + " is out of range, which is -128 to 127");
            }
            sums[i] = (byte) sum;
        }
        return coherent(sums);
    }

    private static Unit coherent(byte[] exponents) {
        List<String> above = new ArrayList<>();
        List<String> below = new ArrayList<>();
        for (SiBase base : ORDER) {
            int exponent = exponents[base.ordinal()];
            if (exponent != 0) {
                int power = Math.abs(exponent);
                (exponent > 0 ? above : below).add(base.symbol() + (power == 1 ? "" : "^" + power));
            }
        }
        String symbol =
                (above.isEmpty() ? "1" : String.join("*", above))
                        + (below.isEmpty()
                                ? ""
                                : below.size() == 1
                                        ? "/" + below.getFirst()
                                        : "/(" + String.join("*", below) + ")");
        return new Unit(exponents.clone(), 1, symbol);
    }

    /** Returns whether numbers in this unit can be converted to the other unit. */
    public boolean sameDimension(Unit other) {
        return Arrays.equals(exponents, other.exponents);
    }

    /** Converts a number in this unit to coherent SI units. */
    public double toSi(double value) {
        return value * scale;
    }

    /**
     * Converts a number in this unit to another unit. Returns exactly the same number if the scales
     * are equal.
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
