package reve.core.access;

import reve.core.unit.Unit;
import reve.core.world.ActionCall;
import reve.core.world.Parameter;

/** Where an effect takes its value from. */
public sealed interface Operand {
    /** The number or numbers, in the given unit. */
    double[] numbers(ActionCall call, Unit unit);

    /** The value as a symbol takes it: a text, a number (in its own unit) or a truth value. */
    Object symbol(ActionCall call);

    /** What the caller gave for a parameter: {@code $impulse}. */
    record Argument(Parameter parameter) implements Operand {
        @Override
        public double[] numbers(ActionCall call, Unit unit) {
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
                case TEXT -> call.arguments().text(parameter.name());
                case TRUTH -> call.arguments().truth(parameter.name());
            };
        }
    }

    /** The same numbers every time. */
    record Numbers(double[] values, Unit unit) implements Operand {
        public Numbers {
            values = values.clone();
        }

        @Override
        public double[] values() {
            return values.clone();
        }

        @Override
        public double[] numbers(ActionCall call, Unit to) {
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

    /** The same text or truth value every time. */
    record Symbol(Object value) implements Operand {
        public Symbol {
            if (!(value instanceof String || value instanceof Boolean)) {
                throw new IllegalArgumentException(value + " is neither a text nor true or false");
            }
        }

        @Override
        public double[] numbers(ActionCall call, Unit unit) {
            throw new IllegalStateException("`" + value + "` is not a number");
        }

        @Override
        public Object symbol(ActionCall call) {
            return value;
        }
    }
}
