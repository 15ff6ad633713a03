// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/** One thing that an action does to an item, as data. {@link Changes} does it. Immutable. */
public sealed interface Effect {
    /** What this effect changes: {@code physics.velocity}, {@code semantic.lit of actor}. */
    String changes();

    /** The item that it changes. */
    Subject of();

    /** A kick: velocity += impulse / mass. */
    record Impulse(Subject of, Operand impulse) implements Effect {
        /** The unit that the operand is asked for in. */
        public static final Unit UNIT = Unit.parse("N*s");

        /** A kick of the item itself. */
        public Impulse(Operand impulse) {
            this(Subject.ITEM, impulse);
        }

        @Override
        public String changes() {
            return "physics.velocity" + of.suffix();
        }
    }

    /**
     * A force beside those of laws.
     *
     * @param seconds how long it acts, in whole frames and one frame at least
     */
    record Force(Subject of, Operand force, double seconds) implements Effect {
        /** The unit that the operand is asked for in. */
        public static final Unit UNIT = Unit.parse("N");

        /** Checks the time. */
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

    /** Gives a physics property a new value. */
    record SetProperty(Subject of, String property, Operand to) implements Effect {
        /** A value of the item itself. */
        public SetProperty(String property, Operand to) {
            this(Subject.ITEM, property, to);
        }

        @Override
        public String changes() {
            return "physics." + property + of.suffix();
        }
    }

    /** Puts the item somewhere else: its location in the world's frame (3) [m]. */
    record SetLocation(Subject of, Operand to) implements Effect {
        /** The unit that the operand is asked for in. */
        public static final Unit UNIT = Unit.parse("m");

        @Override
        public String changes() {
            return "physical.location" + of.suffix();
        }
    }

    /** Turns the item: a quaternion xyzw (4) of any length but 0. */
    record SetOrientation(Subject of, Operand to) implements Effect {
        @Override
        public String changes() {
            return "physical.orientation" + of.suffix();
        }
    }

    /** Gives the item another colour, {@code #rrggbb} or {@code #rrggbbaa}. */
    record SetColour(Subject of, Operand to) implements Effect {
        /** A colour of the item itself. */
        public SetColour(Operand to) {
            this(Subject.ITEM, to);
        }

        @Override
        public String changes() {
            return "physical.colour" + of.suffix();
        }
    }

    /** Gives a semantic symbol a new value. */
    record SetSymbol(Subject of, String symbol, Operand to) implements Effect {
        /** A symbol of the item itself. */
        public SetSymbol(String symbol, Operand to) {
            this(Subject.ITEM, symbol, to);
        }

        @Override
        public String changes() {
            return "semantic." + symbol + of.suffix();
        }
    }

    /** Makes the item move with another from now on, from where it is. */
    record Attach(Subject of, Subject to) implements Effect {
        @Override
        public String changes() {
            return STRUCTURE;
        }
    }

    /** Lets an attached item be on its own, where it is. */
    record Detach(Subject of) implements Effect {
        @Override
        public String changes() {
            return STRUCTURE;
        }
    }

    /**
     * Adds an item. Its name is that of the definition, a hyphen, and its id, so that it is never
     * taken twice.
     *
     * @param with what it has other than the definition says, by name: {@code physics.PROPERTY},
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

    /** Takes the item out of the world; refused while others refer to it or are attached to it. */
    record Remove(Subject of) implements Effect {
        @Override
        public String changes() {
            return STRUCTURE;
        }
    }

    /**
     * Tells everybody: fields {@code item}, {@code action}, if there is one {@code actor}, and
     * others.
     *
     * @param with texts, numbers and truth values by name
     */
    record Raise(String event, String action, Map<String, Operand> with) implements Effect {
        /** Copies the fields. */
        public Raise {
            with = Collections.unmodifiableMap(new LinkedHashMap<>(with));
        }

        /** Without further fields. */
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

    /** What attaching, detaching and removing change: one of them is enough for one action. */
    String STRUCTURE = "what is attached or removed";
}
