// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import com.google.common.primitives.UnsignedLong;

import dev.cel.runtime.CelEvaluationException;
import dev.cel.runtime.CelRuntime;
import dev.cel.runtime.CelUnknownSet;
import dev.cel.runtime.CelVariableResolver;

import org.jspecify.annotations.Nullable;

import reve.core.unit.Unit;
import reve.core.world.Parameter;

import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;
import java.util.regex.Pattern;

/**
 * A compiled expression of a world file. Its cost is bounded, because a {@link Meter} ends an
 * evaluation that takes too many steps. Immutable. It is evaluated on the thread of the world whose
 * data it reads.
 */
public final class Expression {
    private static final Pattern PLACE = Pattern.compile("evaluation error( at <input>:\\d+)?: ");

    /**
     * Maximum length of the reason for a failure [characters]. The limit exists because the reason
     * may quote values.
     */
    private static final int MAX_REASON = 300;

    private final String text;
    private final ExpressionType type;
    private final Optional<Unit> unit;
    private final Set<String> uses;
    private final Scope scope;
    private final CelRuntime.Program program;
    private final Cost cost;

    Expression(
            Scope scope,
            String text,
            ExpressionType type,
            Optional<Unit> unit,
            Set<String> uses,
            CelRuntime.Program program,
            Cost cost) {
        this.scope = scope;
        this.text = text;
        this.type = type;
        this.unit = unit;
        this.uses = Collections.unmodifiableSet(uses);
        this.program = program;
        this.cost = cost;
    }

    /** Returns the source text. */
    public String text() {
        return text;
    }

    /** Returns the type of the result. */
    public ExpressionType type() {
        return type;
    }

    /**
     * Returns the SI unit of the result, which is inferred from the units of the names that the
     * expression reads. Empty if the unit does not follow from them.
     */
    public Optional<Unit> unit() {
        return unit;
    }

    /**
     * Returns the full names that the expression reads, in alphabetical order, for example {@code
     * actor.physics.mass} and {@code semantic.lit}.
     */
    public Set<String> uses() {
        return uses;
    }

    /** Returns the first parts of the names that the expression reads, such as {@code actor}. */
    public Set<String> roots() {
        Set<String> roots = new TreeSet<>();
        uses.forEach(name -> roots.add(name.split("\\.", 2)[0]));
        return roots;
    }

    /**
     * Returns the parameters of the action that contains the expression, by name; empty for a rule.
     */
    public Map<String, Parameter> parameters() {
        return scope.parameters();
    }

    /** Returns new bindings for the names of the expression. The names have no values yet. */
    public Bindings bindings() {
        return scope.bindings();
    }

    /**
     * Evaluates the expression to a Boolean, a finite Double, a String, or a List of these.
     *
     * @throws EvaluationException in these cases: a name has no value (for example, the physics of
     *     scenery), an operator does not accept the values, a number is not finite, or the
     *     evaluation takes too many steps
     */
    public Object evaluate(Bindings bindings) throws EvaluationException {
        var meter = new Meter(cost);
        try {
            CelVariableResolver resolver = bindings::find;
            return value(program.trace(resolver, meter));
        } catch (Meter.Exceeded exceeded) {
            throw failed(
                    "takes more than "
                            + Meter.MAX_STEPS
                            + " steps, which no expression may: "
                            + "let it loop over less, or over shorter texts and lists");
        } catch (CelEvaluationException failed) {
            throw failed(PLACE.matcher(String.valueOf(failed.getMessage())).replaceFirst(""));
        } finally {
            bindings.count(meter.steps());
        }
    }

    /**
     * Evaluates a condition. Throws the same exceptions as {@link #evaluate}. Also throws an
     * exception if the result is not true or false.
     */
    public boolean truth(Bindings bindings) throws EvaluationException {
        if (evaluate(bindings) instanceof Boolean truth) {
            return truth;
        }
        throw failed("is neither true nor false");
    }

    /**
     * Evaluates the expression to {@code count} numbers in SI units. Throws the same exceptions as
     * {@link #evaluate}. Also throws an exception if the result has another form.
     */
    public double[] numbers(Bindings bindings, int count) throws EvaluationException {
        Object value = evaluate(bindings);
        List<?> list = value instanceof List<?> several ? several : List.of(value);
        double[] numbers = new double[list.size()];
        for (int i = 0; i < numbers.length; i++) {
            if (!(list.get(i) instanceof Double number)) {
                throw failed("is " + value + ", expected " + expected(count));
            }
            numbers[i] = number;
        }
        if (numbers.length != count) {
            throw failed("is " + value + ", expected " + expected(count));
        }
        return numbers;
    }

    private static String expected(int count) {
        return count == 1 ? "a number" : count + " numbers";
    }

    private Object value(@Nullable Object raw) throws EvaluationException {
        return switch (raw) {
            case Boolean truth -> truth;
            case String words -> words;
            case Double number -> finite(number);
            case Long number -> (double) number;
            case UnsignedLong number -> number.doubleValue();
            case List<?> list -> {
                List<Object> values = new ArrayList<>(list.size());
                for (Object element : list) {
                    values.add(value(element));
                }
                yield Collections.unmodifiableList(values);
            }
            case CelUnknownSet unknown -> throw failed("a symbol that it reads is missing");
            case null, default ->
                    throw failed(
                            "gives "
                                    + (raw == null
                                            ? "nothing"
                                            : raw instanceof Map
                                                    ? "a map"
                                                    : "another kind of value")
                                    + ", expected true or false, a number, a text or a list");
        };
    }

    private double finite(double number) throws EvaluationException {
        if (Double.isFinite(number)) {
            return number;
        }
        throw failed("is " + number + ", expected a finite number");
    }

    private EvaluationException failed(String why) {
        return new EvaluationException("`" + text + "`: " + Bindings.shortened(why, MAX_REASON));
    }

    @Override
    public String toString() {
        return text;
    }
}
