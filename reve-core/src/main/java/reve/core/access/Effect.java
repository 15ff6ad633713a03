package reve.core.access;

import java.util.LinkedHashMap;
import java.util.Map;
import reve.core.unit.Unit;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Colour;
import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.ScalarType;
import reve.core.world.SemanticAspect;
import reve.core.world.WorldEvent;

/**
 * One thing that a {@link DeclaredAction} does to its item. Effects are checked first and applied
 * afterwards, so that an action happens as a whole.
 */
public sealed interface Effect {
    /** What this effect changes: {@code physics.velocity}, {@code semantic.lit}. */
    String changes();

    /**
     * Everything but the change itself.
     *
     * @return the change, which cannot fail
     * @throws ActionRefused if it cannot be made now
     */
    Runnable prepare(ActionCall call) throws ActionRefused;

    /** A kick: velocity += impulse / mass. */
    record Impulse(Operand impulse) implements Effect {
        /** The unit that the operand is asked for in. */
        public static final Unit UNIT = Unit.parse("N*s");

        @Override
        public String changes() {
            return "physics.velocity";
        }

        @Override
        public Runnable prepare(ActionCall call) throws ActionRefused {
            Item item = call.target();
            requirePhysics(item);
            double mass = item.physics().scalar("mass");
            if (mass == 0) {
                throw new ActionRefused("immovable",
                        item.name() + " has mass 0: no impulse can move it");
            }
            double[] velocity = item.physics().vector("velocity");
            double[] kick = impulse.numbers(call, UNIT);
            for (int i = 0; i < velocity.length; i++) {
                velocity[i] += kick[i] / mass;
            }
            return setting(call, "velocity", velocity);
        }
    }

    /** Gives a physics property a new value. */
    record SetProperty(String property, Operand to) implements Effect {
        @Override
        public String changes() {
            return "physics." + property;
        }

        @Override
        public Runnable prepare(ActionCall call) throws ActionRefused {
            requirePhysics(call.target());
            Unit unit = column(call, property).unit();
            return setting(call, property, to.numbers(call, unit));
        }
    }

    /** Gives the item another colour, {@code #rrggbb} or {@code #rrggbbaa}. */
    record SetColour(Operand to) implements Effect {
        @Override
        public String changes() {
            return "physical.colour";
        }

        @Override
        public Runnable prepare(ActionCall call) throws ActionRefused {
            try {
                Colour colour = Colour.parse((String) to.symbol(call));
                return () -> call.target().physical().setColour(colour);
            } catch (IllegalArgumentException notAColour) {
                throw new ActionRefused("not-a-colour", notAColour.getMessage());
            }
        }
    }

    /** Gives a semantic symbol a new value. */
    record SetSymbol(String symbol, Operand to) implements Effect {
        @Override
        public String changes() {
            return "semantic." + symbol;
        }

        @Override
        public Runnable prepare(ActionCall call) throws ActionRefused {
            try {
                Object value = SemanticAspect.requireSettable(call.world().prototype(),
                        call.target().name(), symbol, to.symbol(call));
                return () -> call.target().semantic().set(symbol, value);
            } catch (IllegalArgumentException notASymbol) {
                throw new ActionRefused("not-a-symbol", notASymbol.getMessage());
            }
        }
    }

    /** Tells everybody: fields {@code item}, {@code action} and, if there is one, {@code actor}. */
    record Raise(String event, String action) implements Effect {
        @Override
        public String changes() {
            return "event " + event;
        }

        @Override
        public Runnable prepare(ActionCall call) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("item", call.target().name());
            fields.put("action", action);
            call.actor().ifPresent(actor -> fields.put("actor", actor.name()));
            var raised = new WorldEvent(call.frame(), event, fields);
            return () -> call.world().raise(raised);
        }
    }

    private static void requirePhysics(Item item) throws ActionRefused {
        if (item.physics().isEmpty()) {
            throw new ActionRefused("no-physics",
                    item.name() + " is scenery: its physics aspect is empty");
        }
    }

    private static Runnable setting(ActionCall call, String property, double[] values)
            throws ActionRefused {
        ScalarType type = column(call, property).type();
        for (double value : values) {
            if (!type.holds(value)) {
                throw new ActionRefused("out-of-range", property + " of " + call.target().name()
                        + " cannot become " + value + ": it holds " + type);
            }
        }
        return () -> call.target().physics().set(property, values);
    }

    private static Column column(ActionCall call, String property) {
        return call.world().table(call.target().kind()).column(property);
    }
}
