// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.Parameter;
import reve.core.world.WorldPrototype;

import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Objects;

/**
 * Which names expressions may use, and of which type: {@code physics}, {@code physical}, {@code
 * semantic} and {@code item} of an item of one kind; in actions, also {@code actor} and the
 * action's parameters. Understands each text once. One thread.
 */
public final class Scope {
    /** The body that acts, in the scope of actions. */
    public static final String ACTOR = "actor";

    private final KindNames own;
    private final KindNames other;
    private final Map<String, Parameter> parameters;
    private final boolean withActor;
    private final Map<String, Expression> known = new HashMap<>();
    private @Nullable Language language;

    private Scope(
            WorldPrototype prototype,
            String kind,
            Map<String, Parameter> parameters,
            boolean withActor) {
        this.own = new KindNames(prototype, kind);
        this.other = new KindNames(prototype, WorldPrototype.BODY);
        this.parameters = parameters;
        this.withActor = withActor;
    }

    /** Names of an item of that kind, for rules. */
    public static Scope ofItem(WorldPrototype prototype, String kind) {
        return new Scope(prototype, kind, Map.of(), false);
    }

    /** Names of an item of that kind, of the body that acts, and the action's parameters. */
    public static Scope ofAction(
            WorldPrototype prototype, String kind, Iterable<Parameter> parameters) {
        var byName = new LinkedHashMap<String, Parameter>();
        parameters.forEach(parameter -> byName.put(parameter.name(), parameter));
        return new Scope(prototype, kind, byName, true);
    }

    /**
     * Understands an expression.
     *
     * @throws ExpressionException if it is too long, no expression, uses names that are not there,
     *     or its types do not fit
     */
    public Expression compile(String text) throws ExpressionException {
        Expression expression = known.get(text);
        if (expression == null) {
            if (language == null) {
                language = new Language(this);
            }
            expression = Objects.requireNonNull(language).compile(text);
            known.put(text, expression);
        }
        return expression;
    }

    /** Whether this text was understood before, and costs nothing to understand. */
    public boolean knows(String text) {
        return known.containsKey(text);
    }

    /** Room for the values of these names. */
    public Bindings bindings() {
        return new Bindings(this);
    }

    KindNames own() {
        return own;
    }

    /** What actors and items that are given as arguments have; they are bodies. */
    KindNames other() {
        return other;
    }

    boolean withActor() {
        return withActor;
    }

    Map<String, Parameter> parameters() {
        return parameters;
    }
}
