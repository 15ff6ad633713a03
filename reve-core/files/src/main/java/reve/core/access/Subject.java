// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Item;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;

import java.util.Optional;

/**
 * The item that an effect changes.
 *
 * @param name {@code item}, {@code actor}, or the name of a parameter that takes an item
 */
public record Subject(String name) {
    /** The item that has the action. */
    public static final Subject ITEM = new Subject("item");

    /** The body of the agent that acts. */
    public static final Subject ACTOR = new Subject("actor");

    /** Returns the subject for an item that the caller gives as an argument. */
    public static Subject argument(Parameter parameter) {
        if (parameter.type() != ParameterType.ITEM) {
            throw new IllegalArgumentException(
                    "parameter " + parameter.name() + " takes no item, but a " + parameter.type());
        }
        return new Subject(parameter.name());
    }

    /**
     * Returns the item in a call.
     *
     * @throws ActionRefused {@code no-actor}, {@code no-such-item} or {@code not-a-body}, if the
     *     call has no such item
     */
    Item in(ActionCall call) throws ActionRefused {
        if (equals(ITEM)) {
            return call.target();
        }
        if (equals(ACTOR)) {
            return call.actor()
                    .orElseThrow(
                            () ->
                                    new ActionRefused(
                                            "no-actor",
                                            "the action needs an actor with a body in"
                                                    + " the world"));
        }
        return named(call, name);
    }

    /** Returns the body that an argument names. */
    static Item named(ActionCall call, String parameter) throws ActionRefused {
        String wanted = call.arguments().text(parameter);
        Optional<Item> found = call.world().find(wanted);
        if (found.isEmpty()) {
            throw new ActionRefused(
                    "no-such-item", "`" + parameter + "`: the world has no item " + wanted);
        }
        if (found.get().physical().isEmpty()) {
            throw new ActionRefused(
                    "not-a-body",
                    "`"
                            + parameter
                            + "`: "
                            + wanted
                            + " is a "
                            + found.get().kind()
                            + ", expected a body");
        }
        return found.get();
    }

    /**
     * Returns the last part of a value's name, for example {@code " of actor"}. Returns an empty
     * text for the item that has the action.
     */
    String suffix() {
        return equals(ITEM) ? "" : " of " + name;
    }
}
