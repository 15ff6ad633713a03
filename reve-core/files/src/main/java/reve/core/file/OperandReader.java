// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.access.Operand;
import reve.core.rule.Expression;
import reve.core.rule.ExpressionException;
import reve.core.rule.ExpressionType;
import reve.core.rule.Scope;
import reve.core.unit.Unit;
import reve.core.world.Colour;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SemanticAspect;
import reve.core.world.SymbolDescriptor;

import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.Predicate;
import java.util.regex.Pattern;

/**
 * Reader of the values in the effects of one action. A value is a constant or, after a {@code $}, a
 * parameter or an expression.
 */
final class OperandReader {
    /** Names that parameters must not have, because expressions reserve them. */
    static final Set<String> RESERVED =
            Set.of("physics", "physical", "semantic", "item", Scope.ACTOR);

    private static final Pattern NAME = Pattern.compile("[A-Za-z][A-Za-z0-9_]*");

    private final PhysicsReader physics;
    private final Problems problems;
    private final Quantities quantities;
    private final Map<String, Optional<Parameter>> parameters;
    private final Scope scope;
    private final Allowance expressions;

    /**
     * @param parameters parameters of the action by name; the Optional is empty if the declaration
     *     is wrong, which was already reported
     * @param expressions number of different expressions that the world's actions may still have
     */
    OperandReader(
            PhysicsReader physics,
            Problems problems,
            Map<String, Optional<Parameter>> parameters,
            Scope scope,
            Allowance expressions) {
        this.physics = physics;
        this.problems = problems;
        this.quantities = new Quantities(problems);
        this.parameters = parameters;
        this.scope = scope;
        this.expressions = expressions;
    }

    Map<String, Optional<Parameter>> parameters() {
        return parameters;
    }

    /** Reads numbers for a property. */
    Optional<Operand> numbers(Node node, PropertyDescriptor property) {
        return numbers(
                node,
                property.components(),
                property.unit(),
                values -> physics.fits(node, property, values));
    }

    /**
     * Reads a value of {@code count} numbers in a unit. The numbers must be in the range of this
     * type of column.
     */
    Optional<Operand> numbers(Node node, int count, Unit unit, ScalarType type) {
        return numbers(node, count, unit, values -> physics.fits(node, type, values));
    }

    private Optional<Operand> numbers(Node node, int count, Unit unit, Predicate<double[]> fits) {
        if (isParameter(node)) {
            return named(node)
                    .filter(parameter -> suits(node, parameter, count, unit))
                    .map(Operand.Argument::new);
        }
        if (isExpression(node)) {
            return computed(node, count == 1 ? ExpressionType.NUMBER : ExpressionType.LIST);
        }
        if (node.truth().isPresent()) {
            problems.add(node, node.label() + ": found " + node.describe() + ", expected numbers");
            return Optional.empty();
        }
        return quantities
                .numbers(node, count, unit)
                .filter(fits)
                .map(values -> new Operand.Numbers(values, unit));
    }

    Optional<Operand> colour(Node node) {
        if (isParameter(node)) {
            return named(node)
                    .filter(parameter -> isText(node, parameter))
                    .map(Operand.Argument::new);
        }
        if (isExpression(node)) {
            return computed(node, ExpressionType.TEXT);
        }
        try {
            Colour.parse(node.text().orElse(node.describe()));
            return node.text().map(Operand.Symbol::new);
        } catch (IllegalArgumentException refused) {
            problems.add(node, node.label() + ": " + refused.getMessage());
            return Optional.empty();
        }
    }

    /** Reads a value for a symbol of an item. */
    Optional<Operand> symbol(Node node, String item, String symbol) {
        if (isParameter(node)) {
            return named(node)
                    .filter(parameter -> isSingle(node, parameter, "symbol"))
                    .map(Operand.Argument::new);
        }
        if (isExpression(node)) {
            return computed(
                    node,
                    physics.prototype()
                            .symbol(symbol)
                            .map(OperandReader::type)
                            .orElse(ExpressionType.ANY));
        }
        Optional<Object> constant = constant(node);
        if (constant.isEmpty()
                && node.isList()) { // the schema check refuses values that are no list
            problems.add(
                    node,
                    node.label() + ": expected true or false, a number, a text or a list of these");
        }
        try {
            return constant.map(
                            value ->
                                    SemanticAspect.requireSettable(
                                            physics.prototype(), item, symbol, value))
                    .map(OperandReader::constant);
        } catch (IllegalArgumentException refused) {
            problems.add(node, refused.getMessage());
            return Optional.empty();
        }
    }

    /** Reads a value for a field of an event: a text, a number or a boolean. */
    Optional<Operand> field(Node node) {
        if (isParameter(node)) {
            return named(node)
                    .filter(parameter -> isSingle(node, parameter, "field"))
                    .map(Operand.Argument::new);
        }
        return isExpression(node)
                ? computed(node, ExpressionType.ANY)
                : node.scalar().map(OperandReader::widened).map(OperandReader::constant);
    }

    /**
     * Reads an expression.
     *
     * @param text the expression without the {@code $} before it
     */
    Optional<Expression> expression(Node node, String text, int begin, ExpressionType expected) {
        if (!scope.knows(text) && !expressions.take(1)) {
            problems.add(
                    node,
                    node.label()
                            + ": the actions have more than "
                            + expressions.most()
                            + " different expressions, which is the limit: "
                            + "let actions share conditions and values, as those of a prefab do");
            return Optional.empty();
        }
        try {
            Expression expression = scope.compile(text);
            if (!expression.type().suits(expected)) {
                problems.add(
                        node,
                        node.label()
                                + ": `"
                                + Node.shorten(text)
                                + "` is "
                                + expression.type().words()
                                + ", expected "
                                + expected.words());
                return Optional.empty();
            }
            return Optional.of(expression);
        } catch (ExpressionException refused) {
            problems.addInText(
                    node, begin + refused.offset(), node.label() + ": " + refused.getMessage());
            return Optional.empty();
        }
    }

    /**
     * Returns a constant in the form in which a symbol stores it: a text, boolean, number, or a
     * list of these.
     */
    static Optional<Object> constant(Node node) {
        if (node.isList()) {
            List<Object> elements =
                    node.children().stream()
                            .map(Node::scalar)
                            .flatMap(Optional::stream)
                            .map(OperandReader::widened)
                            .toList();
            return elements.size() == node.children().size()
                    ? Optional.of(elements)
                    : Optional.empty();
        }
        return node.scalar().map(OperandReader::widened);
    }

    private static Object widened(Object scalar) {
        return scalar instanceof Long whole ? (Object) (double) whole : scalar;
    }

    private static Operand constant(Object value) {
        return value instanceof Double number
                ? new Operand.Numbers(new double[] {number}, Unit.ONE)
                : new Operand.Symbol(value);
    }

    private Optional<Operand> computed(Node node, ExpressionType expected) {
        return expression(node, node.text().orElseThrow().substring(1), 1, expected)
                .map(Operand.Computed::new);
    }

    private static ExpressionType type(SymbolDescriptor symbol) {
        return switch (symbol.type()) {
            case TEXT -> ExpressionType.TEXT;
            case NUMBER -> ExpressionType.NUMBER;
            case TRUTH -> ExpressionType.TRUTH;
            case LIST -> ExpressionType.LIST;
        };
    }

    private boolean suits(Node node, Parameter parameter, int count, Unit unit) {
        String name = "$" + parameter.name();
        String problem = "";
        if (parameter.type() != ParameterType.NUMBER) {
            problem = name + " is no number";
        } else if (parameter.components() != count) {
            problem = name + " has components: " + parameter.components() + ", expected " + count;
        } else if (!parameter.unit().sameDimension(unit)) {
            problem = "unit " + parameter.unit() + " of " + name + " does not fit " + unit;
        }
        if (!problem.isEmpty()) {
            problems.add(node, node.label() + ": " + problem);
        }
        return problem.isEmpty();
    }

    private boolean isSingle(Node node, Parameter parameter, String taker) {
        if (parameter.components() != 1) {
            problems.add(
                    node,
                    node.label()
                            + ": a "
                            + taker
                            + " takes one value, $"
                            + parameter.name()
                            + " has "
                            + parameter.components());
        }
        return parameter.components() == 1;
    }

    private boolean isText(Node node, Parameter parameter) {
        boolean text = parameter.type() == ParameterType.TEXT;
        if (!text) {
            problems.add(
                    node, node.label() + ": a colour is a text, $" + parameter.name() + " is not");
        }
        return text;
    }

    private static boolean isExpression(Node node) {
        return node.text().filter(text -> text.startsWith("$")).isPresent();
    }

    /**
     * Returns whether the value has the form {@code $p}, even if there is no parameter {@code p}.
     */
    private boolean isParameter(Node node) {
        return node.text()
                .filter(text -> text.startsWith("$"))
                .map(text -> text.substring(1))
                .filter(
                        name ->
                                parameters.containsKey(name)
                                        || NAME.matcher(name).matches()
                                                && !RESERVED.contains(name)
                                                && !name.equals("true")
                                                && !name.equals("false"))
                .isPresent();
    }

    private Optional<Parameter> named(Node node) {
        String name = node.text().orElseThrow().substring(1);
        Optional<Parameter> declared = parameters.get(name);
        if (declared == null) {
            problems.add(
                    node,
                    node.label()
                            + ": the action has no parameter `"
                            + Node.shorten(name)
                            + "`"
                            + problems.suggestion(name, parameters.keySet()));
            return Optional.empty();
        }
        return declared;
    }
}
