// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.access.ActionProvider;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.ProvidedAction;
import reve.core.access.Terms;
import reve.core.rule.Expression;
import reve.core.rule.ExpressionType;
import reve.core.rule.Scope;
import reve.core.unit.Unit;
import reve.core.world.Action;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Reader of the actions in the access aspects of items. It refuses actions that can never succeed.
 */
final class ActionReader {
    /**
     * Maximum number of different expressions (conditions and values) in the actions of one world.
     */
    static final int MAX_EXPRESSIONS = 5000;

    private final PhysicsReader physics;
    private final Definitions definitions;
    private final Problems problems;
    private final Quantities quantities;
    private final ProviderReader providers;

    /**
     * Scopes of expressions by key. The actions of many items share a scope, so that equal
     * expressions are compiled only once.
     */
    private final Map<ScopeKey, Scope> scopes = new HashMap<>();

    private Allowance expressions = new Allowance(MAX_EXPRESSIONS);

    /** Reads the definitions of items that actions create. */
    interface Definitions {
        Optional<ItemDefinition> read(Node node) throws WorldFileException;
    }

    /** Takes the expressions of all following actions from an allowance that others share. */
    void share(Allowance left) {
        expressions = left;
    }

    private record ScopeKey(String kind, List<Parameter> parameters) {}

    ActionReader(PhysicsReader physics, Definitions definitions, Problems problems) {
        this.physics = physics;
        this.definitions = definitions;
        this.problems = problems;
        this.quantities = new Quantities(problems);
        this.providers = new ProviderReader(problems);
    }

    /** The item whose action is read. */
    record Owner(String name, String kind, boolean hasPhysics) {}

    /**
     * Reads the action in a node whose key is its name. Records the problems and returns empty if
     * the action is wrong.
     */
    Optional<Action> read(Node node, Owner owner) throws WorldFileException {
        if (!node.isMapping()) {
            return Optional.empty();
        }
        Optional<Node> java = node.get(ProviderReader.JAVA);
        if (java.isPresent() == node.get("effects").isPresent()) {
            if (!problems.isMisspelt(node)) {
                problems.addAtKey(node, "an action has either `effects` or `java`");
            }
            return Optional.empty();
        }
        return java.isPresent() ? provided(node, java.get(), owner) : declared(node, owner);
    }

    private Optional<Action> declared(Node node, Owner owner) throws WorldFileException {
        Map<String, Optional<Parameter>> parameters = parameters(node);
        List<Parameter> known = parameters.values().stream().flatMap(Optional::stream).toList();
        var operands =
                new OperandReader(physics, problems, parameters, scope(owner, known), expressions);
        Terms terms = terms(node, operands);
        List<Effect> effects = new ArrayList<>();
        var reader = new EffectReader(node.key(), owner, physics, operands, definitions, problems);
        for (Node effect : node.get("effects").map(Node::children).orElse(List.of())) {
            reader.read(effect).ifPresent(effects::add);
        }
        try {
            return Optional.of(new DeclaredAction(node.key(), doc(node), known, terms, effects));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(node, refused.getMessage());
            return Optional.empty();
        }
    }

    private Optional<Action> provided(Node node, Node java, Owner owner) {
        node.get("parameters")
                .ifPresent(
                        parameters ->
                                problems.addAtKey(
                                        parameters,
                                        "an action in Java declares its parameters itself"));
        Optional<ActionProvider> provider = providers.action(java);
        if (provider.isEmpty()) {
            return Optional.empty();
        }
        Map<String, Optional<Parameter>> parameters = new LinkedHashMap<>();
        provider.get()
                .parameters()
                .forEach(parameter -> parameters.put(parameter.name(), Optional.of(parameter)));
        var operands =
                new OperandReader(
                        physics,
                        problems,
                        parameters,
                        scope(owner, provider.get().parameters()),
                        expressions);
        String doc = node.get("doc").isPresent() ? doc(node) : provider.get().doc();
        return Optional.of(
                new ProvidedAction(node.key(), doc, terms(node, operands), provider.get()));
    }

    private Scope scope(Owner owner, List<Parameter> parameters) {
        return scopes.computeIfAbsent(
                new ScopeKey(owner.kind, parameters),
                key -> Scope.ofAction(physics.prototype(), key.kind, key.parameters));
    }

    private static String doc(Node node) {
        return node.get("doc").flatMap(Node::text).orElse("");
    }

    private Terms terms(Node node, OperandReader operands) {
        List<String> needs =
                node.get("needs").map(Node::children).orElse(List.of()).stream()
                        .map(Node::text)
                        .flatMap(Optional::stream)
                        .toList();
        List<Expression> conditions = new ArrayList<>();
        Optional<Node> when = node.get("when");
        for (Node condition :
                when.filter(Node::isList).map(Node::children).orElse(when.stream().toList())) {
            condition
                    .text()
                    .flatMap(text -> operands.expression(condition, text, 0, ExpressionType.TRUTH))
                    .ifPresent(conditions::add);
        }
        return new Terms(needs, conditions);
    }

    /**
     * Reads the parameters by name. The Optional is empty for a parameter with a wrong declaration,
     * which is recorded as a problem.
     */
    private Map<String, Optional<Parameter>> parameters(Node action) {
        Map<String, Optional<Parameter>> parameters = new LinkedHashMap<>();
        for (Node node : action.get("parameters").map(Node::children).orElse(List.of())) {
            parameters.put(
                    node.key(),
                    PrototypeReader.unit(node, problems).flatMap(unit -> parameter(node, unit)));
        }
        return parameters;
    }

    private Optional<Parameter> parameter(Node node, Unit unit) {
        ParameterType type =
                switch (node.get("type").flatMap(Node::text).orElse("number")) {
                    case "text" -> ParameterType.TEXT;
                    case "truth" -> ParameterType.TRUTH;
                    case "item" -> ParameterType.ITEM;
                    default -> ParameterType.NUMBER;
                };
        try {
            if (OperandReader.RESERVED.contains(node.key())) {
                throw new IllegalArgumentException(
                        "parameter "
                                + node.key()
                                + ": the name means something else in expressions; choose another");
            }
            return Optional.of(
                    new Parameter(
                            node.key(),
                            type,
                            PrototypeReader.components(node),
                            unit,
                            bound(node, "min", unit, Double.NEGATIVE_INFINITY),
                            bound(node, "max", unit, Double.POSITIVE_INFINITY),
                            doc(node)));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(node, refused.getMessage());
            return Optional.empty();
        }
    }

    private double bound(Node parameter, String key, Unit unit, double otherwise) {
        return parameter.get(key).flatMap(node -> quantities.number(node, unit)).orElse(otherwise);
    }
}
