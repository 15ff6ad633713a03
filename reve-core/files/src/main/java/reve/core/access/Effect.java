// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/** One change that an action makes to an item, as data. {@link Changes} applies it. Immutable. */
public sealed interface Effect {
    /**
     * Returns the name of the value that this effect changes, for example {@code physics.velocity}
     * or {@code semantic.lit of actor}.
     */
    String changes();

    /** Returns the item that this effect changes. */
    Subject of();

    /** Applies an impulse to the item: velocity += impulse / mass. */
    record Impulse(Subject of, Operand impulse) implements Effect {
        /** Unit of the effect's value. */
        public static final Unit UNIT = Unit.parse("N*s");

        /** Creates an impulse on the item that has the action. */
        public Impulse(Operand impulse) {
            this(Subject.ITEM, impulse);
        }

        @Override
        public String changes() {
            return "physics.velocity" + of.suffix();
        }
    }

    /**
     * Exerts a force on the item, in addition to the forces of laws.
     *
     * @param seconds duration of the force [s], rounded to whole frames, at least one frame
     */
    record Force(Subject of, Operand force, double seconds) implements Effect {
        /** Unit of the effect's value. */
        public static final Unit UNIT = Unit.parse("N");

        /** Checks the duration. */
        public Force {
            if (!(seconds >= 0 && Double.isFinite(seconds))) {
                throw new IllegalArgumentException(
                        "a force for " + seconds + " s, expected 0 s or longer");
            }
        }

        @Override
        public String changes() {
            return "the force" + of.suffix();
        }
    }

    /** Sets a physics property. */
    record SetProperty(Subject of, String property, Operand to) implements Effect {
        /** Sets a property of the item that has the action. */
        public SetProperty(String property, Operand to) {
            this(Subject.ITEM, property, to);
        }

        @Override
        public String changes() {
            return "physics." + property + of.suffix();
        }
    }

    /** Moves the item to a location in the world's reference frame (3) [m]. */
    record SetLocation(Subject of, Operand to) implements Effect {
        /** Unit of the effect's value. */
        public static final Unit UNIT = Unit.parse("m");

        @Override
        public String changes() {
            return "physical.location" + of.suffix();
        }
    }

    /**
     * Sets the orientation of the item. The value is a quaternion xyzw (4) of any length except 0.
     */
    record SetOrientation(Subject of, Operand to) implements Effect {
        @Override
        public String changes() {
            return "physical.orientation" + of.suffix();
        }
    }

    /** Sets the colour of the item. The value is {@code #rrggbb} or {@code #rrggbbaa}. */
    record SetColour(Subject of, Operand to) implements Effect {
        /** Sets the colour of the item that has the action. */
        public SetColour(Operand to) {
            this(Subject.ITEM, to);
        }

        @Override
        public String changes() {
            return "physical.colour" + of.suffix();
        }
    }

    /** Sets a semantic symbol. */
    record SetSymbol(Subject of, String symbol, Operand to) implements Effect {
        /** Sets a symbol of the item that has the action. */
        public SetSymbol(String symbol, Operand to) {
            this(Subject.ITEM, symbol, to);
        }

        @Override
        public String changes() {
            return "semantic." + symbol + of.suffix();
        }
    }

    /** Attaches the item to another item, the parent. The item keeps its present pose. */
    record Attach(Subject of, Subject to) implements Effect {
        @Override
        public String changes() {
            return STRUCTURE;
        }
    }

    /** Detaches the item from its parent. The item keeps its present pose in the world. */
    record Detach(Subject of) implements Effect {
        @Override
        public String changes() {
            return STRUCTURE;
        }
    }

    /**
     * Adds an item. Its name is the name of the definition, a hyphen, and the id of the item, so it
     * is always unique.
     *
     * @param with values that replace those of the definition, by name: {@code physics.PROPERTY},
     *     {@code semantic.SYMBOL}, {@code physical.location}, {@code physical.orientation} or
     *     {@code physical.colour}
     */
    record Create(ItemDefinition definition, Map<String, Operand> with) implements Effect {
        /** Copies the values. */
        public Create {
            with = Collections.unmodifiableMap(new LinkedHashMap<>(with));
        }

        @Override
        public Subject of() {
            return Subject.ITEM;
        }

        @Override
        public String changes() {
            return "the items like " + definition.name();
        }
    }

    /**
     * Removes the item from the world. The effect is refused while other items refer to the item or
     * are attached to it.
     */
    record Remove(Subject of) implements Effect {
        @Override
        public String changes() {
            return STRUCTURE;
        }
    }

    /**
     * Publishes an event with the fields {@code item} and {@code action}, and with further fields.
     * The event also has the field {@code actor} if an agent acts.
     *
     * @param with further fields: texts, numbers and truth values by name
     */
    record Raise(String event, String action, Map<String, Operand> with) implements Effect {
        /** Copies the fields. */
        public Raise {
            with = Collections.unmodifiableMap(new LinkedHashMap<>(with));
        }

        /** Creates an event without further fields. */
        public Raise(String event, String action) {
            this(event, action, Map.of());
        }

        @Override
        public Subject of() {
            return Subject.ITEM;
        }

        @Override
        public String changes() {
            return "event " + event;
        }
    }

    /**
     * Name for the value that the effects Attach, Detach and Remove change. Two effects of one
     * action must not change the same value, so an action contains at most one of these three.
     */
    String STRUCTURE = "what is attached or removed";
}
