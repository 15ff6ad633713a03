// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.rule.Bindings;
import reve.core.rule.EvaluationException;
import reve.core.rule.Expression;
import reve.core.unit.Unit;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;

import java.util.List;

/** The value of an effect: an argument, an expression or a constant. */
public sealed interface Operand {
    /**
     * Returns the value as numbers in the given unit.
     *
     * @throws ActionRefused if the call has no value of this form
     */
    double[] numbers(ActionCall call, int count, Unit unit) throws ActionRefused;

    /**
     * Returns the value in the form in which a symbol stores it: a text, a truth value, a list, or
     * a number. A number from an argument is in the argument's own unit. A number from an
     * expression is in SI units.
     *
     * @throws ActionRefused if the call has no value for the operand
     */
    Object symbol(ActionCall call) throws ActionRefused;

    /** The caller's argument for a parameter, for example {@code $impulse}. */
    record Argument(Parameter parameter) implements Operand {
        @Override
        public double[] numbers(ActionCall call, int count, Unit unit) {
            double[] numbers = call.arguments().vector(parameter.name());
            for (int i = 0; i < numbers.length; i++) {
                numbers[i] = parameter.unit().convert(numbers[i], unit);
            }
            return numbers;
        }

        @Override
        public Object symbol(ActionCall call) {
            return switch (parameter.type()) {
                case NUMBER -> call.arguments().number(parameter.name());
                case TEXT, ITEM -> call.arguments().text(parameter.name());
                case TRUTH -> call.arguments().truth(parameter.name());
            };
        }
    }

    /** The result of an expression, for example {@code $physics.temperature + heat}. */
    record Computed(Expression expression) implements Operand {
        @Override
        public double[] numbers(ActionCall call, int count, Unit unit) throws ActionRefused {
            Bindings names = CallNames.of(expression, call);
            call.world().activity().begin(new Evaluating("value", expression, call.target()));
            try {
                double[] numbers = expression.numbers(names, count);
                for (int i = 0; i < numbers.length; i++) {
                    numbers[i] /= unit.scale();
                }
                return numbers;
            } catch (EvaluationException failed) {
                throw new ActionRefused("no-value", failed.getMessage());
            } finally {
                call.world().activity().end(names.steps());
            }
        }

        @Override
        public Object symbol(ActionCall call) throws ActionRefused {
            Bindings names = CallNames.of(expression, call);
            call.world().activity().begin(new Evaluating("value", expression, call.target()));
            try {
                return expression.evaluate(names);
            } catch (EvaluationException failed) {
                throw new ActionRefused("no-value", failed.getMessage());
            } finally {
                call.world().activity().end(names.steps());
            }
        }
    }

    /** Constant numbers. */
    record Numbers(double[] values, Unit unit) implements Operand {
        /** Copies the numbers. */
        public Numbers {
            values = values.clone();
        }

        /** Returns a copy of the numbers. */
        @Override
        public double[] values() {
            return values.clone();
        }

        @Override
        public double[] numbers(ActionCall call, int count, Unit to) {
            double[] numbers = values();
            for (int i = 0; i < numbers.length; i++) {
                numbers[i] = unit.convert(numbers[i], to);
            }
            return numbers;
        }

        @Override
        public Object symbol(ActionCall call) {
            return values[0];
        }
    }

    /** A constant text, truth value or list. */
    record Symbol(Object value) implements Operand {
        /** Checks the type of the value. */
        public Symbol {
            if (!(value instanceof String
                    || value instanceof Boolean
                    || value instanceof List<?>)) {
                throw new IllegalArgumentException(
                        value + " is neither a text nor true or false nor a list");
            }
        }

        @Override
        public double[] numbers(ActionCall call, int count, Unit unit) {
            throw new IllegalStateException("`" + value + "` is not a number");
        }

        @Override
        public Object symbol(ActionCall call) {
            return value;
        }
    }
}
