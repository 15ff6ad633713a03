package reve.core.file;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.unit.Unit;
import reve.core.world.Action;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;

/** Actions as world files declare them; what {@link ActionReader} reads. */
final class ActionWriter {
    private ActionWriter() {}

    /** @throws IllegalArgumentException naming the action if no world file can declare it */
    static Map<String, Object> tree(Action action) {
        if (!(action instanceof DeclaredAction declared)) {
            throw new IllegalArgumentException("action " + action.name() + " is a "
                    + action.getClass().getName() + ", which a world file cannot declare");
        }
        Map<String, Object> tree = new LinkedHashMap<>();
        if (!declared.doc().isEmpty()) {
            tree.put("doc", declared.doc());
        }
        if (!declared.parameters().isEmpty()) {
            Map<String, Object> parameters = new LinkedHashMap<>();
            declared.parameters().forEach(parameter ->
                    parameters.put(parameter.name(), parameter(parameter)));
            tree.put("parameters", parameters);
        }
        tree.put("effects", declared.effects().stream().map(ActionWriter::effect).toList());
        return tree;
    }

    private static Map<String, Object> parameter(Parameter parameter) {
        Map<String, Object> tree = new LinkedHashMap<>();
        switch (parameter.type()) {
            case NUMBER -> { }
            case TEXT -> tree.put("type", "text");
            case TRUTH -> tree.put("type", "truth");
        }
        if (parameter.type() == ParameterType.NUMBER && parameter.components() != 1) {
            tree.put("components", YamlWriter.Numeral.of(parameter.components()));
        }
        if (!parameter.unit().equals(Unit.ONE)) {
            tree.put("unit", parameter.unit().symbol());
        }
        if (!parameter.doc().isEmpty()) {
            tree.put("doc", parameter.doc());
        }
        return tree;
    }

    private static Map<String, Object> effect(Effect effect) {
        Map<String, Object> tree = new LinkedHashMap<>();
        switch (effect) {
            case Effect.Impulse impulse -> tree.put("impulse", operand(impulse.impulse()));
            case Effect.SetProperty set -> {
                tree.put("set", "physics." + set.property());
                tree.put("to", operand(set.to()));
            }
            case Effect.SetColour set -> {
                tree.put("set", "physical.colour");
                tree.put("to", operand(set.to()));
            }
            case Effect.SetSymbol set -> {
                tree.put("symbol", set.symbol());
                tree.put("to", operand(set.to()));
            }
            case Effect.Raise raise -> tree.put("raise", raise.event());
        }
        return tree;
    }

    private static Object operand(Operand operand) {
        return switch (operand) {
            case Operand.Argument argument -> "$" + argument.parameter().name();
            case Operand.Numbers numbers -> numbers(numbers.values());
            case Operand.Symbol symbol -> symbol.value();
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
