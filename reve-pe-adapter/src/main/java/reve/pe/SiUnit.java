// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.Arrays;

/**
 * A physical unit: {@code scale} times the product of powers of the SI base units. Equality
 * compares exponents and scale; the symbol is for messages.
 *
 * @param metre exponent of the metre; the next six are the exponents of the other SI base units
 * @param scale size of the unit in SI, finite and above 0
 * @param symbol for messages; the engine receives at most 15 bytes of UTF-8
 */
public record SiUnit(
        byte metre,
        byte kilogram,
        byte second,
        byte ampere,
        byte kelvin,
        byte mole,
        byte candela,
        double scale,
        String symbol) {
    /** The second, which is the usual time unit of a prototype. */
    public static final SiUnit SECOND = of(new byte[] {0, 0, 1, 0, 0, 0, 0}, 1.0, "s");

    /** Refuses a scale that is not a positive number. */
    public SiUnit {
        if (!(scale > 0) || Double.isInfinite(scale)) {
            throw new IllegalArgumentException(
                    "unit '"
                            + symbol
                            + "': scale is "
                            + scale
                            + ", expected a finite number above 0");
        }
    }

    /** Returns a unit with exponents in the order m, kg, s, A, K, mol, cd; exactly 7. */
    public static SiUnit of(byte[] exponents, double scale, String symbol) {
        if (exponents.length != 7) {
            throw new IllegalArgumentException(
                    "unit '"
                            + symbol
                            + "': "
                            + exponents.length
                            + " exponents, expected 7 (m, kg, s, A, K, mol, cd)");
        }
        return new SiUnit(
                exponents[0],
                exponents[1],
                exponents[2],
                exponents[3],
                exponents[4],
                exponents[5],
                exponents[6],
                scale,
                symbol);
    }

    /** Returns a new array of the exponents in the order m, kg, s, A, K, mol, cd. */
    public byte[] exponents() {
        return new byte[] {metre, kilogram, second, ampere, kelvin, mole, candela};
    }

    /** Returns true for units of equal dimension and scale; ignores the symbol. */
    @Override
    public boolean equals(Object other) {
        return other instanceof SiUnit unit
                && unit.scale == scale
                && Arrays.equals(unit.exponents(), exponents());
    }

    @Override
    public int hashCode() {
        return 31 * Arrays.hashCode(exponents()) + Double.hashCode(scale);
    }
}
