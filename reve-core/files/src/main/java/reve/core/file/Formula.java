// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.text.Suggestion;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.function.DoubleBinaryOperator;
import java.util.function.DoubleUnaryOperator;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * A formula in the text of a repeated item, for example {@code 0.1 * i}, {@code [cos(i), sin(i),
 * 0]} or {@code 3 * ball(7)}. It is computed from the numbers of each repetition. A value is one
 * number or a list of numbers, and operators and functions apply to each element. Results are the
 * same on every machine. Immutable.
 */
final class Formula {
    /** Maximum length of a formula [characters]. This also limits its nesting. */
    static final int MAX_LENGTH = 512;

    private static final Pattern TOKEN =
            Pattern.compile(
                    "\\s*(?:(\\d++(?:\\.\\d*+)?(?:[eE][+-]?\\d++)?|\\.\\d++(?:[eE][+-]?\\d++)?)"
                            + "|([A-Za-z][A-Za-z0-9_.]*+)|(\\S)|$)");
    private static final Map<String, Double> CONSTANTS = Map.of("pi", Math.PI);
    private static final Map<String, DoubleUnaryOperator> FUNCTIONS =
            Map.ofEntries(
                    Map.entry("sin", StrictMath::sin), Map.entry("cos", StrictMath::cos),
                    Map.entry("tan", StrictMath::tan), Map.entry("asin", StrictMath::asin),
                    Map.entry("acos", StrictMath::acos), Map.entry("atan", StrictMath::atan),
                    Map.entry("sqrt", StrictMath::sqrt), Map.entry("cbrt", StrictMath::cbrt),
                    Map.entry("exp", StrictMath::exp), Map.entry("log", StrictMath::log),
                    Map.entry("abs", StrictMath::abs), Map.entry("floor", StrictMath::floor));
    private static final Map<String, DoubleBinaryOperator> FUNCTIONS_OF_TWO =
            Map.of("min", Math::min, "max", Math::max, "atan2", StrictMath::atan2);

    /** A part of a formula. It has one value in each repetition. */
    private interface Term {
        double[] value(double[] variables, long number);
    }

    private final Term term;

    private Formula(Term term) {
        this.term = term;
    }

    /**
     * Parses a formula.
     *
     * @param variables names that the formula may use, for example {@code i}
     * @throws IllegalArgumentException with the reason; the message does not contain the formula
     */
    static Formula parse(String text, List<String> variables) {
        if (text.length() > MAX_LENGTH) {
            throw new IllegalArgumentException("is longer than " + MAX_LENGTH + " characters");
        }
        return new Formula(new Parser(text, variables).parse());
    }

    /** Returns whether formulas have a function or constant of this name. */
    static boolean isTaken(String name) {
        return CONSTANTS.containsKey(name)
                || FUNCTIONS.containsKey(name)
                || FUNCTIONS_OF_TWO.containsKey(name)
                || RandomNumbers.FUNCTIONS.containsKey(name);
    }

    /**
     * Returns the value in one repetition: one or more numbers, which may be infinite or NaN.
     *
     * @param variables values of the variables, in order
     * @param number number of the repetition, from 0; random numbers depend on this number and on a
     *     seed
     * @throws IllegalArgumentException if lists of different lengths are combined
     */
    double[] value(double[] variables, long number) {
        return term.value(variables, number);
    }

    private static double[] map(double[] values, DoubleUnaryOperator function) {
        double[] mapped = new double[values.length];
        for (int i = 0; i < mapped.length; i++) {
            mapped[i] = function.applyAsDouble(values[i]);
        }
        return mapped;
    }

    private static double[] combine(double[] a, double[] b, DoubleBinaryOperator operator) {
        if (a.length != b.length && a.length != 1 && b.length != 1) {
            throw new IllegalArgumentException(
                    "combines " + a.length + " numbers with " + b.length);
        }
        double[] combined = new double[Math.max(a.length, b.length)];
        for (int i = 0; i < combined.length; i++) {
            combined[i] =
                    operator.applyAsDouble(a[a.length == 1 ? 0 : i], b[b.length == 1 ? 0 : i]);
        }
        return combined;
    }

    /** A recursive-descent parser. A formula is a sum of products of powers. */
    private static final class Parser {
        private final String text;
        private final List<String> variables;
        private final Matcher token;
        private String next = "";
        private boolean nextIsNumber;
        private boolean nextIsName;

        Parser(String text, List<String> variables) {
            this.text = text;
            this.variables = variables;
            token = TOKEN.matcher(text);
            advance();
        }

        Term parse() {
            Term term = sum();
            if (!next.isEmpty()) {
                throw unexpected("the end");
            }
            return term;
        }

        private void advance() {
            token.lookingAt();
            next = token.group().strip();
            nextIsNumber = token.group(1) != null;
            nextIsName = token.group(2) != null;
            token.region(token.end(), text.length());
        }

        private boolean skip(String symbol) {
            boolean matches = next.equals(symbol);
            if (matches) {
                advance();
            }
            return matches;
        }

        private void expect(String symbol) {
            if (!skip(symbol)) {
                throw unexpected("`" + symbol + "`");
            }
        }

        private IllegalArgumentException unexpected(String expected) {
            return new IllegalArgumentException(
                    "has "
                            + (next.isEmpty() ? "its end" : "`" + next + "`")
                            + " where "
                            + expected
                            + " is expected");
        }

        private Term sum() {
            Term term = product();
            while (true) {
                if (skip("+")) {
                    term = operation(term, product(), (a, b) -> a + b);
                } else if (skip("-")) {
                    term = operation(term, product(), (a, b) -> a - b);
                } else {
                    return term;
                }
            }
        }

        private Term product() {
            Term term = signed();
            while (true) {
                if (skip("*")) {
                    term = operation(term, signed(), (a, b) -> a * b);
                } else if (skip("/")) {
                    term = operation(term, signed(), (a, b) -> a / b);
                } else if (skip("%")) {
                    term = operation(term, signed(), (a, b) -> a - b * Math.floor(a / b));
                } else {
                    return term;
                }
            }
        }

        private Term signed() {
            if (skip("-")) {
                Term term = signed();
                return (variables, number) -> map(term.value(variables, number), a -> -a);
            }
            Term base = single();
            return skip("^") ? operation(base, signed(), StrictMath::pow) : base;
        }

        private static Term operation(Term left, Term right, DoubleBinaryOperator operator) {
            return (variables, number) ->
                    combine(
                            left.value(variables, number),
                            right.value(variables, number),
                            operator);
        }

        private Term single() {
            String symbol = next;
            if (skip("(")) {
                Term term = sum();
                expect(")");
                return term;
            }
            if (skip("[")) {
                return list(listed("]"));
            }
            if (nextIsNumber) {
                advance();
                return constant(Double.parseDouble(symbol));
            }
            if (nextIsName) {
                advance();
                return skip("(") ? call(symbol, listed(")")) : named(symbol);
            }
            throw unexpected("a number, a name or a bracket");
        }

        private List<Term> listed(String end) {
            List<Term> terms = new ArrayList<>();
            do {
                terms.add(sum());
            } while (skip(","));
            expect(end);
            return terms;
        }

        private static Term constant(double value) {
            double[] values = {value};
            return (variables, number) -> values;
        }

        private static Term list(List<Term> terms) {
            return (variables, number) -> {
                double[] values = new double[terms.size()];
                for (int i = 0; i < values.length; i++) {
                    values[i] = one(terms.get(i).value(variables, number), "a list");
                }
                return values;
            };
        }

        private static double one(double[] values, String where) {
            if (values.length != 1) {
                throw new IllegalArgumentException(
                        "has a list where " + where + " takes one number");
            }
            return values[0];
        }

        private Term named(String name) {
            int index = variables.indexOf(name);
            if (index >= 0) {
                return (variables, number) -> new double[] {variables[index]};
            }
            Double constant = CONSTANTS.get(name);
            if (constant == null) {
                throw new IllegalArgumentException(
                        "names `"
                                + name
                                + "`, which is unknown; known "
                                + "are "
                                + String.join(", ", variables)
                                + Suggestion.of(name, variables));
            }
            return constant(constant);
        }

        private static Term call(String name, List<Term> arguments) {
            DoubleUnaryOperator function = FUNCTIONS.get(name);
            DoubleBinaryOperator ofTwo = FUNCTIONS_OF_TWO.get(name);
            RandomNumbers.Function random = RandomNumbers.FUNCTIONS.get(name);
            if (function == null && ofTwo == null && random == null) {
                throw new IllegalArgumentException("calls `" + name + "`, which is no function");
            }
            int count = ofTwo != null ? 2 : 1;
            if (arguments.size() != count) {
                throw new IllegalArgumentException(
                        "gives " + name + " " + arguments.size() + " arguments, expected " + count);
            }
            Term first = arguments.getFirst();
            if (ofTwo != null) {
                return operation(first, arguments.getLast(), ofTwo);
            }
            if (function != null) {
                return (variables, number) -> map(first.value(variables, number), function);
            }
            return (variables, number) ->
                    random.value(
                            new RandomNumbers(
                                    (long) one(first.value(variables, number), name), number));
        }
    }
}
