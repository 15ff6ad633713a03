// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import reve.core.unit.Unit;
import reve.core.world.Item;
import reve.core.world.LevelTest;
import reve.core.world.Motion;
import reve.core.world.Parameter;

import java.util.Arrays;
import java.util.List;

/**
 * An expression that makes a level of an item active. Besides the names of the item, it reads the
 * {@link #names()}, which describe the motion of the item as a whole. Immutable.
 */
public record LevelRule(Expression expression) implements LevelTest {
    private static final String MASS = "mass";
    private static final String LOCATION = "location";
    private static final String VELOCITY = "velocity";
    private static final String ANGULAR_VELOCITY = "angularVelocity";
    private static final String ENERGY = "energy";
    private static final String VIBRATION = "vibration";

    /** Returns the names that describe the motion, with their units. */
    static List<Parameter> names() {
        return List.of(
                Parameter.number(MASS, 1, Unit.parse("kg"), "Mass of the item."),
                Parameter.number(LOCATION, 3, Unit.parse("m"), "Centre of mass."),
                Parameter.number(VELOCITY, 3, Unit.parse("m/s"), "Of the centre of mass."),
                Parameter.number(ANGULAR_VELOCITY, 3, Unit.parse("rad/s"), "As a rigid body."),
                Parameter.number(ENERGY, 1, Unit.parse("J"), "Kinetic energy."),
                Parameter.number(VIBRATION, 1, Unit.parse("J"), "Kinetic energy of vibrations."));
    }

    @Override
    public String text() {
        return expression.text();
    }

    @Override
    public Result test(Item item, Motion motion) {
        Bindings bindings = expression.bindings().of(item);
        bindings.with(MASS, motion.mass())
                .with(LOCATION, list(motion.centre()))
                .with(VELOCITY, list(motion.velocity()))
                .with(ANGULAR_VELOCITY, list(motion.angularVelocity()))
                .with(ENERGY, motion.energy())
                .with(VIBRATION, motion.vibration());
        boolean holds = false;
        long failure = 0;
        try {
            holds = expression.truth(bindings);
        } catch (EvaluationException noValue) {
            failure = Meter.STEPS_OF_FAILURE;
        }
        return new Result(holds, bindings.steps() + failure);
    }

    /** Returns a description for people. For any thread. */
    @Override
    public String toString() {
        return "the condition of a level: `" + expression.text() + "`";
    }

    private static List<Double> list(double[] numbers) {
        return Arrays.stream(numbers).boxed().toList();
    }
}
