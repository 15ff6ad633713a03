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
 * The names that expressions may use, with their types: {@code physics}, {@code physical}, {@code
 * semantic} and {@code item} of an item of one kind; in actions also {@code actor} and the action's
 * parameters. Compiles each text once. For one thread.
 */
public final class Scope {
    /** The acting body, in the scope of actions. */
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

    /** Returns the names for rules of items of that kind. */
    public static Scope ofItem(WorldPrototype prototype, String kind) {
        return new Scope(prototype, kind, Map.of(), false);
    }

    /**
     * Returns the names for actions of items of that kind: of the item, of the acting body, and of
     * the parameters.
     */
    public static Scope ofAction(
            WorldPrototype prototype, String kind, Iterable<Parameter> parameters) {
        var byName = new LinkedHashMap<String, Parameter>();
        parameters.forEach(parameter -> byName.put(parameter.name(), parameter));
        return new Scope(prototype, kind, byName, true);
    }

    /**
     * Compiles an expression.
     *
     * @throws ExpressionException if the text is too long or not an expression, uses unknown names,
     *     or its types do not match
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

    /** Returns whether the text was compiled before, so that compiling it again costs nothing. */
    public boolean knows(String text) {
        return known.containsKey(text);
    }

    /** Returns empty bindings for these names. */
    public Bindings bindings() {
        return new Bindings(this);
    }

    KindNames own() {
        return own;
    }

    /** Returns the names of actors and of items that are arguments, which are bodies. */
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
