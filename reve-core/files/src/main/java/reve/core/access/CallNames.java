// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.rule.Bindings;
import reve.core.rule.Expression;
import reve.core.rule.Scope;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;

import java.util.ArrayList;
import java.util.List;

/**
 * Source of the values of names. The names occur in the expressions of an action, and their values
 * belong to one call of the action.
 */
final class CallNames {
    private CallNames() {}

    static Bindings of(Expression expression, ActionCall call) throws ActionRefused {
        Bindings bindings = expression.bindings().of(call.target());
        for (String name : expression.roots()) {
            Parameter parameter = expression.parameters().get(name);
            if (parameter != null) {
                bind(bindings, parameter, call);
            } else if (name.equals(Scope.ACTOR)) {
                bindings.withItem(name, Subject.ACTOR.in(call));
            }
        }
        return bindings;
    }

    private static void bind(Bindings bindings, Parameter parameter, ActionCall call)
            throws ActionRefused {
        String name = parameter.name();
        switch (parameter.type()) {
            case TEXT -> bindings.with(name, call.arguments().text(name));
            case TRUTH -> bindings.with(name, call.arguments().truth(name));
            case ITEM -> bindings.withItem(name, Subject.named(call, name));
            case NUMBER -> {
                List<Double> numbers = new ArrayList<>();
                for (double number : call.arguments().vector(name)) {
                    numbers.add(parameter.unit().toSi(number));
                }
                bindings.with(name, numbers.size() == 1 ? numbers.getFirst() : numbers);
            }
        }
    }
}
