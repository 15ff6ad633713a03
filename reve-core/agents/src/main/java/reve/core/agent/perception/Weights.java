// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.unit.Unit;
import reve.core.world.ColumnView;
import reve.core.world.ItemSymbols;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.util.Arrays;
import java.util.Optional;

/**
 * The weights of all bodies in one frame, and the largest weight that a body lifts. A world has
 * weights if it declares the symbol {@code strength} as a number with a unit of force. The weight
 * of a body is its mass times the magnitude of the constant {@code gravity}. For one thread.
 */
final class Weights {
    /** Name of the symbol that an agent perceives of items that are too heavy for its body. */
    static final String TOO_HEAVY = "tooHeavy";

    private static final String STRENGTH = "strength";
    private static final String GRAVITY = "gravity";
    private static final Unit NEWTON = Unit.parse("N");

    private final Optional<Unit> unit;
    private double[] mass = {};
    private double[] read = {};
    private int count;
    private double gravity;
    private double heaviest;
    private long version;

    Weights(WorldPrototype prototype) {
        unit =
                prototype
                        .symbol(STRENGTH)
                        .filter(declared -> declared.type() == SymbolType.NUMBER)
                        .map(SymbolDescriptor::unit)
                        .filter(NEWTON::sameDimension);
    }

    /** Copies the masses of a frame, if the world has weights. */
    void read(WorldSnapshot snapshot) {
        if (unit.isEmpty()) {
            return;
        }
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        int now = bodies.rowCount();
        if (read.length < now) {
            read = new double[now + now / 2];
        }
        SensedWorld.read(bodies.column(WorldPrototype.MASS), read, 0, now);
        ColumnView field = snapshot.table(WorldPrototype.WORLD).column(GRAVITY);
        double pull =
                Math.sqrt(
                        square(field.getDouble(0, 0))
                                + square(field.getDouble(0, 1))
                                + square(field.getDouble(0, 2)));
        if (pull == gravity && Arrays.equals(read, 0, now, mass, 0, count)) {
            return;
        }
        double[] free = mass;
        mass = read;
        read = free;
        count = now;
        gravity = pull;
        version++;
        heaviest = 0;
        for (int row = 0; row < count; row++) {
            heaviest = Math.max(heaviest, mass[row] * gravity);
        }
    }

    /** Returns the version of the weights, which changes if a weight changes. */
    long version() {
        return version;
    }

    /** Returns the largest weight of a body [N]. */
    double heaviest() {
        return heaviest;
    }

    private static double square(double number) {
        return number * number;
    }

    /**
     * Returns the largest weight that a body lifts [N]; infinite if the body has no symbol {@code
     * strength}.
     */
    double strength(ItemSymbols body) {
        return unit.isPresent() && body.get(STRENGTH).orElse(null) instanceof Double strength
                ? unit.get().toSi(strength)
                : Double.POSITIVE_INFINITY;
    }

    /**
     * Returns whether the weight of the body in a row exceeds a strength [N]. The result is false
     * for immovable bodies, which have the mass 0.
     */
    boolean isTooHeavy(int row, double strength) {
        return mass[row] * gravity > strength;
    }
}
