// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.access.Subject;
import reve.core.file.ActionReader.Definitions;
import reve.core.file.ActionReader.Owner;
import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.StandardSymbols;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Reader of the effects of one action. */
final class EffectReader {
    private static final List<String> EFFECTS =
            List.of(
                    "impulse", "force", "set", "symbol", "attach", "detach", "create", "remove",
                    "raise");

    /** For each key that is valid in some kinds of effects only, the list of these kinds. */
    private static final Map<String, List<String>> COMPANIONS =
            Map.of(
                    "to",
                    List.of("set", "symbol"),
                    "for",
                    List.of("force"),
                    "with",
                    List.of("create", "raise"),
                    "item",
                    List.of("impulse", "force", "set", "symbol", "attach", "detach", "remove"));

    private static final List<String> OWN_FIELDS = List.of("item", "action", "actor");
    private static final String PHYSICAL = "physical.";
    private static final String LOCATION = "physical.location";
    private static final String ORIENTATION = "physical.orientation";
    private static final String COLOUR = "physical.colour";
    private static final String PHYSICS = "physics.";
    private static final String SEMANTIC = "semantic.";
    private static final Unit SECOND = Unit.parse("s");

    private final String action;
    private final Owner owner;
    private final PhysicsReader physics;
    private final OperandReader operands;
    private final Definitions definitions;
    private final Problems problems;

    EffectReader(
            String action,
            Owner owner,
            PhysicsReader physics,
            OperandReader operands,
            Definitions definitions,
            Problems problems) {
        this.action = action;
        this.owner = owner;
        this.physics = physics;
        this.operands = operands;
        this.definitions = definitions;
        this.problems = problems;
    }

    Optional<Effect> read(Node node) throws WorldFileException {
        List<Node> given = EFFECTS.stream().map(node::get).flatMap(Optional::stream).toList();
        if (given.size() != 1) {
            if (node.isMapping() && !problems.isMisspelt(node)) {
                problems.add(
                        node,
                        node.label()
                                + ": an effect is exactly one of `"
                                + String.join("`, `", EFFECTS)
                                + "`, found "
                                + given.size());
            }
            return Optional.empty();
        }
        Node what = given.getFirst();
        if (!companionsFit(node, what)) {
            return Optional.empty();
        }
        Optional<Subject> of =
                node.get("item").isEmpty()
                        ? Optional.of(Subject.ITEM)
                        : subject(node.get("item").get());
        return of.isEmpty()
                ? Optional.empty()
                : read(
                        node,
                        what,
                        of.get(),
                        of.get().equals(Subject.ITEM) ? owner : someBody(of.get()));
    }

    /**
     * Returns a substitute for the item of a subject (actor or argument). The real item is known
     * only when the action is called, so the substitute is a body with all properties of bodies.
     */
    private static Owner someBody(Subject subject) {
        return new Owner(subject.name(), WorldPrototype.BODY, true);
    }

    private boolean companionsFit(Node node, Node what) {
        for (Map.Entry<String, List<String>> companion : COMPANIONS.entrySet()) {
            Optional<Node> given = node.get(companion.getKey());
            if (given.isPresent() && !companion.getValue().contains(what.key())) {
                problems.add(
                        given.get(),
                        "`" + companion.getKey() + "` does not go with `" + what.key() + "`");
                return false;
            }
        }
        if (COMPANIONS.get("to").contains(what.key()) && node.get("to").isEmpty()) {
            problems.add(what, "`" + what.key() + "` needs `to`, the new value");
            return false;
        }
        return true;
    }

    private Optional<Effect> read(Node node, Node what, Subject subject, Owner itemOwner)
            throws WorldFileException {
        return switch (what.key()) {
            case "impulse" ->
                    vector(what, itemOwner, Effect.Impulse.UNIT)
                            .map(impulse -> new Effect.Impulse(subject, impulse));
            case "force" -> force(node, what, subject, itemOwner);
            case "set" -> set(what, node.get("to").orElseThrow(), subject, itemOwner);
            case "symbol" -> symbol(what, node.get("to").orElseThrow(), subject, itemOwner);
            case "attach" ->
                    requireBody(what, itemOwner)
                            ? subject(what).map(to -> new Effect.Attach(subject, to))
                            : Optional.empty();
            case "detach" ->
                    requireBody(what, itemOwner)
                            ? Optional.of(new Effect.Detach(subject))
                            : Optional.empty();
            case "remove" -> Optional.of(new Effect.Remove(subject));
            case "create" -> create(node, what);
            default -> raise(node, what);
        };
    }

    /**
     * Reads the name of the item that an effect changes: {@code item}, {@code actor}, or a
     * parameter of type item.
     */
    private Optional<Subject> subject(Node node) {
        String name = node.text().orElse("");
        if (name.equals(Subject.ITEM.name()) || name.equals(Subject.ACTOR.name())) {
            return Optional.of(new Subject(name));
        }
        Optional<Parameter> parameter = operands.parameters().get(name);
        if (parameter == null
                || parameter.isPresent() && parameter.get().type() != ParameterType.ITEM) {
            problems.add(
                    node,
                    node.label()
                            + ": found "
                            + node.describe()
                            + ", expected `item`, `actor` or the name of a parameter of type item");
            return Optional.empty();
        }
        return parameter.map(Subject::argument);
    }

    private Optional<Operand> vector(Node node, Owner itemOwner, Unit unit) {
        if (!itemOwner.kind().equals(WorldPrototype.BODY)) {
            String article = node.key().equals("impulse") ? "an " : "a ";
            problems.addAtKey(
                    node,
                    "only bodies take " + article + node.key() + ", this is a " + itemOwner.kind());
            return Optional.empty();
        }
        return requirePhysics(node, itemOwner)
                ? operands.numbers(node, 3, unit, ScalarType.F64)
                : Optional.empty();
    }

    private Optional<Effect> force(Node node, Node what, Subject subject, Owner itemOwner) {
        Optional<Operand> force = vector(what, itemOwner, Effect.Force.UNIT);
        double seconds = 0;
        if (node.get("for").isPresent()) {
            Node time = node.get("for").get();
            Optional<Double> given = new Quantities(problems).number(time, SECOND);
            if (given.isEmpty()) {
                return Optional.empty();
            }
            seconds = given.get();
            if (seconds < 0) {
                problems.add(time, "for: found " + seconds + " s, expected 0 s or longer");
                return Optional.empty();
            }
        }
        double lasting = seconds;
        return force.map(newtons -> new Effect.Force(subject, newtons, lasting));
    }

    private Optional<Effect> set(Node what, Node to, Subject subject, Owner itemOwner) {
        String target = what.text().orElse("");
        boolean body = itemOwner.kind().equals(WorldPrototype.BODY);
        if (target.startsWith(PHYSICS)) {
            return property(what, target.substring(PHYSICS.length()), itemOwner)
                    .filter(property -> requirePhysics(what, itemOwner))
                    .flatMap(
                            property ->
                                    numbers(to, property)
                                            .map(
                                                    operand ->
                                                            new Effect.SetProperty(
                                                                    subject,
                                                                    property.name(),
                                                                    operand)));
        }
        return switch (body ? target : "") {
            case COLOUR ->
                    operands.colour(to).map(operand -> new Effect.SetColour(subject, operand));
            case LOCATION ->
                    operands.numbers(to, 3, Effect.SetLocation.UNIT, real())
                            .map(operand -> new Effect.SetLocation(subject, operand));
            case ORIENTATION ->
                    operands.numbers(to, 4, Unit.ONE, real())
                            .map(operand -> new Effect.SetOrientation(subject, operand));
            default -> {
                problems.add(
                        what,
                        "set: found "
                                + what.describe()
                                + ", expected physics.PROPERTY"
                                + (body
                                        ? ", "
                                                + String.join(", ", LOCATION, ORIENTATION)
                                                + " or "
                                                + COLOUR
                                        : ""));
                yield Optional.empty();
            }
        };
    }

    private ScalarType real() {
        return physics.prototype().realType();
    }

    /** Returns a numeric property by name. Records a problem and returns empty if there is none. */
    private Optional<PropertyDescriptor> property(Node where, String name, Owner itemOwner) {
        return physics.find(where, name, itemOwner.kind())
                .filter(
                        property -> {
                            if (property.type() == ScalarType.REF) {
                                problems.add(
                                        where,
                                        where.label()
                                                + ": "
                                                + property.name()
                                                + " refers to an item, which an action cannot"
                                                + " change");
                            }
                            if (property.accumulated()) {
                                problems.add(
                                        where,
                                        where.label()
                                                + ": "
                                                + property.name()
                                                + " is the sum of what laws add in each step, so an"
                                                + " action cannot set it; set a property that a law"
                                                + " adds to it");
                            }
                            return property.type() != ScalarType.REF && !property.accumulated();
                        });
    }

    private Optional<Operand> numbers(Node node, PropertyDescriptor property) {
        return operands.numbers(node, property);
    }

    private boolean requirePhysics(Node node, Owner itemOwner) {
        String problem = "the item has no `physics`, so this action could never work";
        if (itemOwner.hasPhysics()) {
            return true;
        }
        if (physics.doubts() == Doubts.REFUSED) {
            problems.addAtKey(node, problem);
            return false;
        }
        physics.doubts().refuse(node, problem, problems); // it has lost its physics while it ran
        return true;
    }

    private boolean requireBody(Node node, Owner itemOwner) {
        boolean body = itemOwner.kind().equals(WorldPrototype.BODY);
        if (!body) {
            problems.addAtKey(
                    node, "only bodies are attached to each other, this is a " + itemOwner.kind());
        }
        return body;
    }

    private Optional<Effect> symbol(Node what, Node to, Subject subject, Owner itemOwner) {
        Optional<String> name = what.text();
        if (name.isEmpty() || !isSettable(what, name.get())) {
            return Optional.empty();
        }
        return operands.symbol(to, itemOwner.name(), name.get())
                .map(operand -> new Effect.SetSymbol(subject, name.get(), operand));
    }

    private boolean isSettable(Node node, String symbol) {
        boolean derived = StandardSymbols.DERIVED.contains(symbol);
        if (derived) {
            problems.add(
                    node,
                    node.label() + ": " + symbol + " is derived by the world and cannot be set");
        }
        return !derived;
    }

    private Optional<Effect> create(Node node, Node what) throws WorldFileException {
        Optional<ItemDefinition> definition = definitions.read(what);
        Map<String, Operand> with = new LinkedHashMap<>();
        for (Node value : node.get("with").map(Node::children).orElse(List.of())) {
            definition
                    .flatMap(item -> part(value, item))
                    .ifPresent(operand -> with.put(value.key(), operand));
        }
        return definition.map(item -> new Effect.Create(item, with));
    }

    /** Reads a value of a created item. This value replaces the value in the item's definition. */
    private Optional<Operand> part(Node value, ItemDefinition item) {
        var itemOwner = new Owner(item.name(), item.kind(), true);
        String name = value.key();
        if (name.startsWith(PHYSICS)) {
            return property(value, name.substring(PHYSICS.length()), itemOwner)
                    .flatMap(property -> numbers(value, property));
        }
        if (name.startsWith(SEMANTIC)) {
            String symbol = name.substring(SEMANTIC.length());
            return isSettable(value, symbol)
                    ? operands.symbol(value, item.name(), symbol)
                    : Optional.empty();
        }
        return switch (item.kind().equals(WorldPrototype.BODY) ? name : "") {
            case LOCATION -> operands.numbers(value, 3, Effect.SetLocation.UNIT, real());
            case ORIENTATION -> operands.numbers(value, 4, Unit.ONE, real());
            case COLOUR -> operands.colour(value);
            default -> {
                problems.addAtKey(
                        value,
                        "found `"
                                + Node.shorten(name)
                                + "`, expected "
                                + PHYSICS
                                + "PROPERTY, "
                                + SEMANTIC
                                + "SYMBOL, or of a body "
                                + PHYSICAL
                                + "location, orientation or colour");
                yield Optional.empty();
            }
        };
    }

    private Optional<Effect> raise(Node node, Node what) {
        Optional<String> event = what.text();
        if (event.filter(WorldEvent.OF_THE_SERVER::contains).isPresent()) {
            problems.add(
                    what,
                    "raise: the event "
                            + event.get()
                            + " is the server's own; choose a name other than "
                            + String.join(
                                    ", ",
                                    WorldEvent.OF_THE_SERVER.subList(
                                            0, WorldEvent.OF_THE_SERVER.size() - 1))
                            + " and "
                            + WorldEvent.OF_THE_SERVER.getLast());
            return Optional.empty();
        }
        Map<String, Operand> with = new LinkedHashMap<>();
        for (Node value : node.get("with").map(Node::children).orElse(List.of())) {
            if (OWN_FIELDS.contains(value.key())) {
                problems.addAtKey(value, "every event has the field " + value.key() + " already");
            } else {
                operands.field(value).ifPresent(operand -> with.put(value.key(), operand));
            }
        }
        return event.map(name -> new Effect.Raise(name, action, with));
    }
}
