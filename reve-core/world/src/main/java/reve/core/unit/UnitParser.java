// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

/**
 * Parser of texts into {@link Unit}s. It accepts the same grammar as the physics engine's {@code
 * vesper_unit_parse}:
 *
 * <pre>
 * product = power { ("*" | "·" | "/") power };  power = atom [ "^" integer | raised digits ];
 * atom = symbol | number | "(" product ")"
 * </pre>
 */
final class UnitParser {
    private static final int MAX_LENGTH = 255;
    private static final String EXAMPLE = "; write it like kg*m^2/s^2 or N/m";
    private static final int MAX_DEPTH = 16;
    private static final int MAX_EXPONENT = 127;
    private static final String RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    private static final char RAISED_MINUS = '⁻';
    private static final int BASES = SiBase.values().length;

    private final String text;
    private int at;

    /** True if the text read so far ends with a power that was written with {@code ^}. */
    private boolean endsWithExponent;

    /** A unit under construction. Its scale is a fraction, so that ratios stay exact. */
    private static final class Quantity {
        private final int[] exponents = new int[BASES];
        private double numerator = 1;
        private double denominator = 1;
    }

    private UnitParser(String text) {
        this.text = text;
    }

    static Unit parse(String text) {
        String symbol = text.strip();
        if (symbol.equals("1")) {
            return Unit.ONE;
        }
        return new UnitParser(symbol).parse();
    }

    private Unit parse() {
        if (text.isEmpty()) {
            throw refuse("it is empty; a plain number has the unit 1");
        }
        if (text.length() > MAX_LENGTH) {
            throw new IllegalArgumentException(
                    "unit `"
                            + text.substring(0, 64)
                            + "…`: it is longer than "
                            + MAX_LENGTH
                            + " characters");
        }
        Quantity quantity = product(0);
        if (at < text.length()) {
            throw refuse(
                    isDigit(peek())
                            ? "the number at column "
                                    + (at + 1)
                                    + " is no exponent; write m^2 for square metres"
                            : found() + ", expected *, /, ^ or the end" + EXAMPLE);
        }
        // A text without any letter, such as "1000", is refused. It is probably a typing error and
        // not a scale.
        if (text.chars().allMatch(c -> c < 'A' && c != '%')) {
            throw refuse("it is a number; a plain number has the unit 1");
        }
        double scale = quantity.numerator / quantity.denominator;
        if (!(scale > 0) || !Double.isFinite(scale)) {
            throw refuse("its scale is out of range");
        }
        byte[] exponents = new byte[BASES];
        for (int i = 0; i < BASES; i++) {
            exponents[i] = (byte) quantity.exponents[i];
        }
        return new Unit(exponents, scale, text);
    }

    private Quantity product(int depth) {
        Quantity product = power(depth);
        while (true) {
            char sign = peek();
            boolean times = sign == '*' || sign == '·' || sign == '⋅';
            if (!times && sign != '/') {
                return product;
            }
            at++;
            if (sign == '/' && endsWithExponent && isDigit(peek())) {
                throw refuse(
                        "the number behind its exponent is ambiguous; exponents are whole, and a"
                                + " half of m^2 is (m^2)/2");
            }
            multiply(product, power(depth), times ? 1 : -1);
        }
    }

    private Quantity power(int depth) {
        Quantity base = atom(depth);
        endsWithExponent = peek() == '^';
        int exponent;
        if (endsWithExponent) {
            at++;
            exponent = exponent();
        } else if (isRaised(peek())) {
            exponent = raised();
        } else {
            return base;
        }
        var power = new Quantity();
        multiply(power, base, exponent);
        return power;
    }

    private int exponent() {
        int sign = peek() == '-' ? -1 : 1;
        at += sign < 0 ? 1 : 0;
        int begin = at;
        int exponent = 0;
        while (at < text.length() && isDigit(text.charAt(at)) && exponent <= MAX_EXPONENT) {
            exponent = 10 * exponent + text.charAt(at++) - '0';
        }
        return checked(exponent, begin, sign);
    }

    private int raised() {
        int sign = text.charAt(at) == RAISED_MINUS ? -1 : 1;
        at += sign < 0 ? 1 : 0;
        int begin = at;
        int exponent = 0;
        while (at < text.length()
                && RAISED.indexOf(text.charAt(at)) >= 0
                && exponent <= MAX_EXPONENT) {
            exponent = 10 * exponent + RAISED.indexOf(text.charAt(at++));
        }
        return checked(exponent, begin, sign);
    }

    private int checked(int exponent, int begin, int sign) {
        if (at == begin) {
            throw refuse(found() + ", expected a whole number as exponent" + EXAMPLE);
        }
        if (exponent > MAX_EXPONENT) {
            throw refuse("its exponents are out of range, which is -127 to 127");
        }
        return sign * exponent;
    }

    private Quantity atom(int depth) {
        char next = peek();
        if (next == '(') {
            return parenthesis(depth);
        }
        if (isDigit(next)) {
            return number();
        }
        if (isSymbolic(next)) {
            return symbol();
        }
        throw refuse(found() + ", expected a unit such as m, a number or (" + EXAMPLE);
    }

    private Quantity parenthesis(int depth) {
        if (depth == MAX_DEPTH) {
            throw refuse("its parentheses are nested too deep");
        }
        at++;
        Quantity inner = product(depth + 1);
        if (peek() != ')') {
            throw refuse(found() + ", expected *, /, ^ or )" + EXAMPLE);
        }
        at++;
        endsWithExponent = false;
        return inner;
    }

    /**
     * Reads a number above 0, for example 9.80665 or 1e3. The result is a unit without dimension
     * and with this number as its scale.
     */
    private Quantity number() {
        int begin = at;
        digits();
        if (at < text.length() && text.charAt(at) == '.') {
            at++;
            digits();
        }
        if (at < text.length() && (text.charAt(at) == 'e' || text.charAt(at) == 'E')) {
            int sign = at + 1 < text.length() && "+-".indexOf(text.charAt(at + 1)) >= 0 ? 1 : 0;
            if (at + 1 + sign < text.length() && isDigit(text.charAt(at + 1 + sign))) {
                at += 1 + sign;
                digits();
            }
        }
        var quantity = new Quantity();
        quantity.numerator = Double.parseDouble(text.substring(begin, at));
        if (!(quantity.numerator > 0) || !Double.isFinite(quantity.numerator)) {
            throw refuse("a number in it must be above 0 and in range");
        }
        return quantity;
    }

    private void digits() {
        while (at < text.length() && isDigit(text.charAt(at))) {
            at++;
        }
    }

    private Quantity symbol() {
        int begin = at;
        while (at < text.length() && isSymbolic(text.charAt(at))) {
            at++;
        }
        String name = text.substring(begin, at);
        UnitTable.Symbol known = UnitTable.find(name);
        if (known == null) {
            boolean isCelsius = name.equals("°C") || name.equals("℃") || name.equals("Celsius");
            throw refuse(
                    isCelsius
                            ? "it is not a plain multiple of SI units (for temperatures use K)"
                            : "`" + name + "` is not a unit that is known here");
        }
        var quantity = new Quantity();
        System.arraycopy(known.exponents(), 0, quantity.exponents, 0, BASES);
        quantity.numerator = known.scale().numerator();
        quantity.denominator = known.scale().denominator();
        return quantity;
    }

    /** Multiplies a product by a power of a factor: product *= factor^power. */
    private void multiply(Quantity product, Quantity factor, int power) {
        for (int i = 0; i < BASES; i++) {
            product.exponents[i] += factor.exponents[i] * power;
            if (Math.abs(product.exponents[i]) > MAX_EXPONENT) {
                throw refuse("its exponents are out of range, which is -127 to 127");
            }
        }
        int times = Math.abs(power);
        double above = power > 0 ? factor.numerator : factor.denominator;
        double below = power > 0 ? factor.denominator : factor.numerator;
        product.numerator *= StrictMath.pow(above, times);
        product.denominator *= StrictMath.pow(below, times);
    }

    /** Returns the next non-blank character; 0 at the end. */
    private char peek() {
        while (at < text.length() && text.charAt(at) == ' ') {
            at++;
        }
        return at < text.length() ? text.charAt(at) : 0;
    }

    private String found() {
        return at < text.length()
                ? "column "
                        + (at + 1)
                        + ": found `"
                        + Character.toString(text.codePointAt(at))
                        + "`"
                : "found the end";
    }

    private static boolean isDigit(char c) {
        return c >= '0' && c <= '9';
    }

    private static boolean isRaised(char c) {
        return c != 0 && (c == RAISED_MINUS || RAISED.indexOf(c) >= 0);
    }

    private static boolean isSymbolic(char c) {
        return c >= 'a' && c <= 'z'
                || c >= 'A' && c <= 'Z'
                || c == '%'
                || c >= 0x80 && c != '·' && c != '⋅' && !isRaised(c);
    }

    private IllegalArgumentException refuse(String why) {
        return new IllegalArgumentException("unit `" + text + "`: " + why);
    }
}
