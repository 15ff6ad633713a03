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
 * kind. The names in actions also include {@code actor} and the parameters of the action. The scope
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
     * Returns the scope for conditions of levels, with the names of the item and of its motion as a
     * whole, see {@link LevelRule}.
     */
    public static Scope ofLevels(WorldPrototype prototype) {
        var byName = new LinkedHashMap<String, Parameter>();
        LevelRule.names().forEach(name -> byName.put(name.name(), name));
        return new Scope(prototype, WorldPrototype.BODY, byName, false);
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
     * Returns whether the text was compiled before. The method {@link #compile} then returns the
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
     * Returns the names in the aspects of other items. These items are the actor and the items that
     * are given as arguments, and all of them are bodies.
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
