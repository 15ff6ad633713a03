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
 * The names that expressions may use, with their types, and the compiler of these expressions. The
 * names are {@code physics}, {@code physical}, {@code semantic} and {@code item} of an item of one
 * kind. In actions, they also include {@code actor} and the parameters of the action. The scope
 * compiles each distinct text once. For one thread.
 */
public final class Scope {
    /** Name of the acting body, in the scope of actions. */
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

    /** Returns the scope for rules of items of that kind. */
    public static Scope ofItem(WorldPrototype prototype, String kind) {
        return new Scope(prototype, kind, Map.of(), false);
    }

    /**
     * Returns the scope for actions of items of that kind, with the names of the item, the acting
     * body and the parameters.
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

    /**
     * Returns whether the text was compiled before. In this case, {@link #compile} returns the
     * stored result.
     */
    public boolean knows(String text) {
        return known.containsKey(text);
    }

    /** Returns new bindings for these names. The names have no values yet. */
    public Bindings bindings() {
        return new Bindings(this);
    }

    KindNames own() {
        return own;
    }

    /**
     * Returns the names in the aspects of other items. These are bodies: the actor, and items given
     * as arguments.
     */
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
