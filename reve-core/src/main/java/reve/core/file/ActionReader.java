package reve.core.file;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.unit.Unit;
import reve.core.world.Colour;
import reve.core.world.ItemSymbols;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SemanticAspect;
import reve.core.world.WorldPrototype;

/** Reads the actions of access aspects, and refuses those that could never work. */
final class ActionReader {
    private static final List<String> EFFECTS = List.of("impulse", "set", "symbol", "raise");
    /** What the server itself tells agents, and those who start it and read its output. */
    private static final List<String> OWN_EVENTS = List.of("joined", "left", "acted",
            "law-loaded", "law-unloaded", "fault", "ready", "snapshot", "snapshot-failed", "end");
    private static final String COLOUR = "physical.colour";
    private static final String PHYSICS = "physics.";

    private final PhysicsReader physics;
    private final Problems problems;
    private final Quantities quantities;

    ActionReader(PhysicsReader physics, Problems problems) {
        this.physics = physics;
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /** Whose action is read. */
    record Owner(String name, String kind, boolean hasPhysics) {}

    /** The action under its name; empty and problems noted if it is wrong. */
    Optional<DeclaredAction> read(Node node, Owner owner) {
        if (!node.isMapping()) {
            return Optional.empty();
        }
        Map<String, Optional<Parameter>> parameters = parameters(node);
        List<Effect> effects = new ArrayList<>();
        for (Node effect : node.get("effects").map(Node::children).orElse(List.of())) {
            effect(effect, node.key(), parameters, owner).ifPresent(effects::add);
        }
        try {
            return Optional.of(new DeclaredAction(node.key(),
                    node.get("doc").flatMap(Node::text).orElse(""),
                    parameters.values().stream().flatMap(Optional::stream).toList(), effects));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(node, refused.getMessage());
            return Optional.empty();
        }
    }

    /** By name; empty where the declaration is wrong, which is reported here and only here. */
    private Map<String, Optional<Parameter>> parameters(Node action) {
        Map<String, Optional<Parameter>> parameters = new LinkedHashMap<>();
        for (Node node : action.get("parameters").map(Node::children).orElse(List.of())) {
            parameters.put(node.key(), PrototypeReader.unit(node, problems)
                    .flatMap(unit -> parameter(node, unit)));
        }
        return parameters;
    }

    private Optional<Parameter> parameter(Node node, Unit unit) {
        ParameterType type = switch (node.get("type").flatMap(Node::text).orElse("number")) {
            case "text" -> ParameterType.TEXT;
            case "truth" -> ParameterType.TRUTH;
            default -> ParameterType.NUMBER;
        };
        try {
            return Optional.of(new Parameter(node.key(), type, PrototypeReader.components(node),
                    unit, node.get("doc").flatMap(Node::text).orElse("")));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(node, refused.getMessage());
            return Optional.empty();
        }
    }

    private Optional<Effect> effect(Node node, String action,
            Map<String, Optional<Parameter>> parameters, Owner owner) {
        List<Node> given = EFFECTS.stream().map(node::get).flatMap(Optional::stream).toList();
        if (given.size() != 1) {
            if (node.isMapping()) {
                problems.add(node, node.label() + ": an effect is exactly one of `"
                        + String.join("`, `", EFFECTS) + "`, found " + given.size());
            }
            return Optional.empty();
        }
        Node what = given.getFirst();
        boolean takesValue = what.key().equals("set") || what.key().equals("symbol");
        Optional<Node> to = node.get("to");
        if (takesValue != to.isPresent()) {
            problems.add(to.orElse(what), takesValue
                    ? "`" + what.key() + "` needs `to`, the new value"
                    : "`to` does not go with `" + what.key() + "`");
            return Optional.empty();
        }
        return switch (what.key()) {
            case "impulse" -> impulse(what, parameters, owner);
            case "set" -> set(what, to.orElseThrow(), parameters, owner);
            case "symbol" -> symbol(what, to.orElseThrow(), parameters, owner);
            default -> raise(what, action);
        };
    }

    private Optional<Effect> impulse(Node node, Map<String, Optional<Parameter>> parameters,
            Owner owner) {
        if (!owner.kind.equals(WorldPrototype.BODY)) {
            problems.addAtKey(node, "only bodies take an impulse, this is a " + owner.kind);
            return Optional.empty();
        }
        if (!requirePhysics(node, owner)) {
            return Optional.empty();
        }
        return numbers(node, 3, Effect.Impulse.UNIT, ScalarType.F64, parameters)
                .map(Effect.Impulse::new);
    }

    private Optional<Effect> set(Node what, Node to, Map<String, Optional<Parameter>> parameters,
            Owner owner) {
        String target = what.text().orElse("");
        if (target.equals(COLOUR) && owner.kind.equals(WorldPrototype.BODY)) {
            return colour(to, parameters).map(Effect.SetColour::new);
        }
        if (!target.startsWith(PHYSICS)) {
            problems.add(what, "set: found " + what.describe() + ", expected physics.PROPERTY"
                    + (owner.kind.equals(WorldPrototype.BODY) ? " or " + COLOUR : ""));
            return Optional.empty();
        }
        Optional<PropertyDescriptor> property =
                physics.find(what, target.substring(PHYSICS.length()), owner.kind);
        if (property.isEmpty() || !requirePhysics(what, owner)) {
            return Optional.empty();
        }
        if (property.get().type() == ScalarType.REF) {
            problems.add(what, "set: " + property.get().name()
                    + " refers to an item, which an action cannot change");
            return Optional.empty();
        }
        return numbers(to, property.get().components(), property.get().unit(),
                property.get().type(), parameters)
                .map(operand -> new Effect.SetProperty(property.get().name(), operand));
    }

    private boolean requirePhysics(Node node, Owner owner) {
        if (!owner.hasPhysics) {
            problems.addAtKey(node, "the item has no `physics`, so this action could never work");
        }
        return owner.hasPhysics;
    }

    private Optional<Effect> symbol(Node what, Node to,
            Map<String, Optional<Parameter>> parameters, Owner owner) {
        Optional<String> name = what.text();
        if (name.isEmpty()) {
            return Optional.empty();
        }
        if (ItemSymbols.DERIVED.contains(name.get())) {
            problems.add(what, "symbol: " + name.get()
                    + " is derived by the world and cannot be set");
            return Optional.empty();
        }
        Optional<Operand> value = isParameter(to) ? symbolArgument(to, parameters)
                : symbolConstant(to, name.get(), owner);
        return value.map(operand -> new Effect.SetSymbol(name.get(), operand));
    }

    private Optional<Operand> symbolArgument(Node to,
            Map<String, Optional<Parameter>> parameters) {
        return named(to, parameters).filter(parameter -> {
            if (parameter.components() != 1) {
                problems.add(to, to.label() + ": a symbol takes one value, $"
                        + parameter.name() + " has " + parameter.components());
            }
            return parameter.components() == 1;
        }).map(Operand.Argument::new);
    }

    private Optional<Operand> symbolConstant(Node to, String symbol, Owner owner) {
        if (to.isList()) {
            problems.add(to, "to: found a list, a symbol takes a text, a number or a truth value");
            return Optional.empty();
        }
        try {
            return to.scalar()
                    .map(value -> SemanticAspect.requireSettable(physics.prototype(), owner.name,
                            symbol, value))
                    .map(value -> value instanceof Double number
                            ? new Operand.Numbers(new double[] {number}, Unit.ONE)
                            : new Operand.Symbol(value));
        } catch (IllegalArgumentException refused) {
            problems.add(to, refused.getMessage());
            return Optional.empty();
        }
    }

    private Optional<Operand> colour(Node to, Map<String, Optional<Parameter>> parameters) {
        if (isParameter(to)) {
            return named(to, parameters)
                    .filter(parameter -> isText(to, parameter)).map(Operand.Argument::new);
        }
        try {
            Colour.parse(to.text().orElse(to.describe()));
            return to.text().map(Operand.Symbol::new);
        } catch (IllegalArgumentException refused) {
            problems.add(to, "to: " + refused.getMessage());
            return Optional.empty();
        }
    }

    private boolean isText(Node node, Parameter parameter) {
        boolean text = parameter.type() == ParameterType.TEXT;
        if (!text) {
            problems.add(node, node.label() + ": a colour is a text, $" + parameter.name()
                    + " is not");
        }
        return text;
    }

    private Optional<Effect> raise(Node node, String action) {
        Optional<String> event = node.text();
        if (event.filter(OWN_EVENTS::contains).isPresent()) {
            problems.add(node, "raise: the event " + event.get()
                    + " is the server's own; choose a name other than "
                    + String.join(", ", OWN_EVENTS.subList(0, OWN_EVENTS.size() - 1)) + " and "
                    + OWN_EVENTS.getLast());
            return Optional.empty();
        }
        return event.map(name -> new Effect.Raise(name, action));
    }

    private Optional<Operand> numbers(Node node, int count, Unit unit, ScalarType type,
            Map<String, Optional<Parameter>> parameters) {
        if (isParameter(node)) {
            return named(node, parameters)
                    .filter(parameter -> suits(node, parameter, count, unit))
                    .map(Operand.Argument::new);
        }
        if (node.truth().isPresent()) {
            problems.add(node, node.label() + ": found " + node.describe() + ", expected numbers");
            return Optional.empty();
        }
        return quantities.numbers(node, count, unit)
                .filter(values -> physics.fits(node, type, values))
                .map(values -> new Operand.Numbers(values, unit));
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

    private static boolean isParameter(Node node) {
        return node.text().filter(text -> text.startsWith("$")).isPresent();
    }

    /** The parameter that a value such as {@code $p} names. */
    private Optional<Parameter> named(Node node, Map<String, Optional<Parameter>> parameters) {
        String name = node.text().orElseThrow().substring(1);
        Optional<Parameter> declared = parameters.get(name);
        if (declared == null) {
            problems.add(node, node.label() + ": the action has no parameter `"
                    + Node.shorten(name) + "`" + Suggestion.of(name, parameters.keySet()));
            return Optional.empty();
        }
        return declared;
    }
}
