// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.rule.Bindings;
import reve.core.rule.EvaluationException;
import reve.core.rule.Expression;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Item;

import java.util.ArrayList;
import java.util.List;

/**
 * The conditions and capabilities that an action requires. Immutable.
 *
 * @param needs capabilities that the acting body must have
 * @param conditions expressions that must all be true
 */
public record Terms(List<String> needs, List<Expression> conditions) {
    /** Terms without conditions and capabilities. Every call meets them. */
    public static final Terms NONE = new Terms(List.of(), List.of());

    /** Copies the lists. */
    public Terms {
        needs = List.copyOf(needs);
        conditions = List.copyOf(conditions);
    }

    /**
     * Checks the terms for one call.
     *
     * @throws ActionRefused with one of two codes: {@code not-capable} names the missing
     *     capabilities of the actor, {@code condition-failed} names the condition and the values of
     *     its names
     */
    void require(Action action, ActionCall call) throws ActionRefused {
        if (!needs.isEmpty()) {
            requireCapable(action, call);
        }
        for (Expression condition : conditions) {
            require(condition, call);
        }
    }

    private void requireCapable(Action action, ActionCall call) throws ActionRefused {
        Item actor = Subject.ACTOR.in(call);
        List<String> has = call.capabilities();
        List<String> lacks = needs.stream().filter(need -> !has.contains(need)).toList();
        if (!lacks.isEmpty()) {
            throw new ActionRefused(
                    "not-capable",
                    "action "
                            + action.name()
                            + " of "
                            + call.target().name()
                            + " needs the capability "
                            + quoted(lacks)
                            + "; "
                            + actor.name()
                            + " has "
                            + (has.isEmpty() ? "none" : "only " + quoted(has))
                            + (has.containsAll(actor.access().capabilities())
                                    ? ""
                                    : " by this agent's token"));
        }
    }

    private static void require(Expression condition, ActionCall call) throws ActionRefused {
        Bindings names = CallNames.of(condition, call);
        call.world().activity().begin(new Evaluating("condition", condition, call.target()));
        try {
            if (!condition.truth(names)) {
                throw new ActionRefused(
                        "condition-failed",
                        "`" + condition.text() + "` does not hold: " + found(condition, names));
            }
        } catch (EvaluationException failed) {
            throw new ActionRefused("condition-failed", failed.getMessage());
        } finally {
            call.world().activity().end(names.steps());
        }
    }

    /**
     * Returns a text for messages that contains the values of the names in a condition. An example
     * is {@code physics.temperature is 380.0, semantic.lit is missing}.
     */
    private static String found(Expression condition, Bindings names) {
        List<String> found = new ArrayList<>();
        for (String name : condition.uses()) {
            found.add(name + " is " + names.described(name));
        }
        return found.isEmpty() ? "it never does" : String.join(", ", found);
    }

    private static String quoted(List<String> names) {
        return "`" + String.join("`, `", names) + "`";
    }
}
