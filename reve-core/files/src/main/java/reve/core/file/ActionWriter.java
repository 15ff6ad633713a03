// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.access.ProvidedAction;
import reve.core.access.Subject;
import reve.core.access.Terms;
import reve.core.rule.Expression;
import reve.core.unit.Unit;
import reve.core.world.Action;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.function.BiConsumer;
import java.util.function.Function;

/** Encoder of actions as trees (maps and lists), in the form that {@link ActionReader} reads. */
final class ActionWriter {
    private final Function<ItemDefinition, Map<String, Object>> definitions;

    private final BiConsumer<List<Parameter>, String> expressions;

    /** The parameters of the action that is being written. */
    private List<Parameter> parameters = List.of();

    /**
     * @param definitions encodes the items that actions create
     * @param expressions receives each expression, with the parameters of its action
     */
    ActionWriter(
            Function<ItemDefinition, Map<String, Object>> definitions,
            BiConsumer<List<Parameter>, String> expressions) {
        this.definitions = definitions;
        this.expressions = expressions;
    }

    /**
     * Returns the tree of an action.
     *
     * @throws IllegalArgumentException naming the action if a world file cannot declare it
     */
    Map<String, Object> tree(Action action) {
        List<Parameter> outer = parameters; // those of an action that creates the item of this one
        parameters = action.parameters();
        try {
            return treeOf(action);
        } finally {
            parameters = outer;
        }
    }

    private Map<String, Object> treeOf(Action action) {
        Map<String, Object> tree = new LinkedHashMap<>();
        if (!action.doc().isEmpty()) {
            tree.put("doc", action.doc());
        }
        switch (action) {
            case DeclaredAction declared -> {
                if (!declared.parameters().isEmpty()) {
                    Map<String, Object> fields = new LinkedHashMap<>();
                    declared.parameters()
                            .forEach(
                                    parameter ->
                                            fields.put(parameter.name(), parameter(parameter)));
                    tree.put("parameters", fields);
                }
                putTerms(tree, declared.terms());
                tree.put("effects", declared.effects().stream().map(this::effect).toList());
            }
            case ProvidedAction provided -> {
                putTerms(tree, provided.terms());
                tree.put("java", provided.provider().name());
            }
            default ->
                    throw new IllegalArgumentException(
                            "action "
                                    + action.name()
                                    + " is a "
                                    + action.getClass().getName()
                                    + ", which a world file cannot declare");
        }
        return tree;
    }

    private void putTerms(Map<String, Object> tree, Terms terms) {
        if (!terms.needs().isEmpty()) {
            tree.put("needs", terms.needs());
        }
        if (!terms.conditions().isEmpty()) {
            tree.put("when", terms.conditions().stream().map(this::text).toList());
        }
    }

    private static Map<String, Object> parameter(Parameter parameter) {
        Map<String, Object> tree = new LinkedHashMap<>();
        switch (parameter.type()) {
            case NUMBER -> {}
            case TEXT -> tree.put("type", "text");
            case TRUTH -> tree.put("type", "truth");
            case ITEM -> tree.put("type", "item");
        }
        if (parameter.components() != 1) {
            tree.put("components", YamlWriter.Numeral.of(parameter.components()));
        }
        if (!parameter.unit().equals(Unit.ONE)) {
            tree.put("unit", parameter.unit().symbol());
        }
        if (parameter.minimum() > Double.NEGATIVE_INFINITY) {
            tree.put("min", YamlWriter.Numeral.of(parameter.minimum()));
        }
        if (parameter.maximum() < Double.POSITIVE_INFINITY) {
            tree.put("max", YamlWriter.Numeral.of(parameter.maximum()));
        }
        if (!parameter.doc().isEmpty()) {
            tree.put("doc", parameter.doc());
        }
        return tree;
    }

    private Map<String, Object> effect(Effect effect) {
        Map<String, Object> tree = new LinkedHashMap<>();
        if (!effect.of().equals(Subject.ITEM)) {
            tree.put("item", effect.of().name());
        }
        switch (effect) {
            case Effect.Impulse impulse -> tree.put("impulse", operand(impulse.impulse()));
            case Effect.Force force -> {
                tree.put("force", operand(force.force()));
                if (force.seconds() > 0) {
                    tree.put("for", YamlWriter.Numeral.of(force.seconds()));
                }
            }
            case Effect.SetProperty set -> putSet(tree, "physics." + set.property(), set.to());
            case Effect.SetLocation set -> putSet(tree, "physical.location", set.to());
            case Effect.SetOrientation set -> putSet(tree, "physical.orientation", set.to());
            case Effect.SetColour set -> putSet(tree, "physical.colour", set.to());
            case Effect.SetSymbol set -> {
                tree.put("symbol", set.symbol());
                tree.put("to", operand(set.to()));
            }
            case Effect.Attach attach -> tree.put("attach", attach.to().name());
            case Effect.Detach detach -> tree.put("detach", true);
            case Effect.Remove remove -> tree.put("remove", true);
            case Effect.Create create -> {
                tree.put("create", definitions.apply(create.definition()));
                putWith(tree, create.with());
            }
            case Effect.Raise raise -> {
                tree.put("raise", raise.event());
                putWith(tree, raise.with());
            }
        }
        return tree;
    }

    private void putSet(Map<String, Object> tree, String what, Operand to) {
        tree.put("set", what);
        tree.put("to", operand(to));
    }

    private void putWith(Map<String, Object> tree, Map<String, Operand> with) {
        if (!with.isEmpty()) {
            Map<String, Object> values = new LinkedHashMap<>();
            with.forEach((name, value) -> values.put(name, operand(value)));
            tree.put("with", values);
        }
    }

    private String text(Expression expression) {
        expressions.accept(parameters, expression.text());
        return expression.text();
    }

    private Object operand(Operand operand) {
        return switch (operand) {
            case Operand.Argument argument -> "$" + argument.parameter().name();
            case Operand.Computed computed -> "$" + text(computed.expression());
            case Operand.Numbers numbers -> numbers(numbers.values());
            case Operand.Symbol symbol -> ItemWriter.symbol(symbol.value());
        };
    }

    private static Object numbers(double[] values) {
        List<Object> numerals = new ArrayList<>();
        for (double value : values) {
            numerals.add(YamlWriter.Numeral.of(value));
        }
        return values.length == 1 ? numerals.getFirst() : numerals;
    }
}
