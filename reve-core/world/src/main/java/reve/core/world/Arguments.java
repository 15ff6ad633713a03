// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.text.Visible;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.Collectors;

/**
 * The arguments of one call, checked against the action's parameters. No argument is missing,
 * unknown or not finite, and all arguments have the declared type and length. Immutable. For any
 * thread.
 */
public final class Arguments {
    /** Maximum length of a text argument [characters]. */
    public static final int MAX_TEXT_LENGTH = 1024;

    private final Map<String, Object> values;

    private Arguments(Map<String, Object> values) {
        this.values = values;
    }

    /**
     * Checks the arguments of a caller. Each must be a {@link Number}, a {@link List} of numbers, a
     * {@link String} or a {@link Boolean}, depending on its parameter.
     *
     * @throws ActionRefused with code {@code missing-argument}, {@code unknown-argument}, {@code
     *     wrong-type}, {@code wrong-components}, {@code not-finite} or {@code out-of-range}. The
     *     message names the action, the parameter and the values that the parameter accepts
     */
    public static Arguments check(Action action, Map<String, ?> given) throws ActionRefused {
        var values = new LinkedHashMap<String, Object>();
        for (Parameter parameter : action.parameters()) {
            Object argument = given.get(parameter.name());
            if (argument == null) {
                throw new ActionRefused(
                        "missing-argument",
                        "action "
                                + action.name()
                                + " needs `"
                                + parameter.name()
                                + "`, "
                                + parameter.expectation());
            }
            values.put(parameter.name(), checked(action, parameter, argument));
        }
        for (String name : given.keySet()) {
            if (!values.containsKey(name)) {
                throw new ActionRefused(
                        "unknown-argument",
                        "action "
                                + action.name()
                                + " has no `"
                                + Visible.shortened(name)
                                + "`; it takes "
                                + parameterNames(action));
            }
        }
        return new Arguments(values);
    }

    /** Returns the number of a parameter with one component, in the parameter's unit. */
    public double number(String name) {
        return vector(name)[0];
    }

    /** Returns a copy of the numbers of a parameter, in the parameter's unit. */
    public double[] vector(String name) {
        return get(name, double[].class).clone();
    }

    /** Returns a text or the name of an item. No item of this name needs to exist. */
    public String text(String name) {
        return get(name, String.class);
    }

    /** Returns a truth value. */
    public boolean truth(String name) {
        return get(name, Boolean.class);
    }

    private <T> T get(String name, Class<T> type) {
        Object value = values.get(name);
        if (!type.isInstance(value)) {
            throw new IllegalArgumentException(
                    "argument `"
                            + name
                            + "` is "
                            + (value == null
                                    ? "no parameter of this action"
                                    : "a " + value.getClass().getSimpleName()));
        }
        return type.cast(value);
    }

    private static Object checked(Action action, Parameter parameter, Object argument)
            throws ActionRefused {
        return switch (parameter.type()) {
            case NUMBER -> numbers(action, parameter, argument);
            case TEXT, ITEM -> {
                if (!(argument instanceof String text)) {
                    throw wrongType(action, parameter, argument);
                }
                if (text.length() > MAX_TEXT_LENGTH) {
                    throw new ActionRefused(
                            "wrong-type",
                            subject(action, parameter)
                                    + " takes a "
                                    + "text of at most "
                                    + MAX_TEXT_LENGTH
                                    + " characters, found "
                                    + text.length());
                }
                if (!Names.isUnicode(text)) {
                    throw new ActionRefused(
                            "wrong-type",
                            subject(action, parameter)
                                    + " takes Unicode text, found half of a surrogate pair");
                }
                yield text;
            }
            case TRUTH -> {
                if (!(argument instanceof Boolean)) {
                    throw wrongType(action, parameter, argument);
                }
                yield argument;
            }
        };
    }

    private static double[] numbers(Action action, Parameter parameter, Object argument)
            throws ActionRefused {
        List<?> list = argument instanceof List<?> several ? several : List.of(argument);
        for (Object element : list) {
            if (!(element instanceof Number)) {
                throw wrongType(action, parameter, element);
            }
        }
        if (list.size() != parameter.components()) {
            throw new ActionRefused(
                    "wrong-components",
                    subject(action, parameter)
                            + " takes "
                            + parameter.expectation()
                            + ", found "
                            + list.size()
                            + " numbers");
        }
        double[] numbers = new double[list.size()];
        for (int i = 0; i < numbers.length; i++) {
            numbers[i] = ((Number) list.get(i)).doubleValue();
            if (!Double.isFinite(numbers[i])) {
                throw new ActionRefused(
                        "not-finite",
                        subject(action, parameter) + " takes finite numbers, found " + list.get(i));
            }
            if (numbers[i] < parameter.minimum() || numbers[i] > parameter.maximum()) {
                throw new ActionRefused(
                        "out-of-range",
                        subject(action, parameter)
                                + " takes "
                                + parameter.expectation()
                                + ", found "
                                + list.get(i));
            }
        }
        return numbers;
    }

    private static ActionRefused wrongType(Action action, Parameter parameter, Object found) {
        String what =
                switch (found) {
                    case String text -> "a text";
                    case Boolean truth -> "a truth value";
                    case Number number -> "a number";
                    case List<?> list -> "a list";
                    default -> "something else";
                };
        return new ActionRefused(
                "wrong-type",
                subject(action, parameter)
                        + " takes "
                        + parameter.expectation()
                        + ", found "
                        + what);
    }

    private static String subject(Action action, Parameter parameter) {
        return "`" + parameter.name() + "` of action " + action.name();
    }

    private static String parameterNames(Action action) {
        return action.parameters().isEmpty()
                ? "no arguments"
                : action.parameters().stream()
                        .map(Parameter::name)
                        .collect(Collectors.joining("`, `", "`", "`"));
    }
}
