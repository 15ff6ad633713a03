// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;
import reve.core.world.ItemClass;
import reve.core.world.PropertyDescriptor;
import reve.core.world.StandardSymbols;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/** Reader of the key {@code classes}, which declares the classes of items. */
final class ClassReader {
    /** Maximum number of classes of one world. */
    static final int MAX_CLASSES = 1000;

    /** Maximum number of classes of which each is directly above the one before. */
    static final int MAX_CHAIN = 32;

    private static final Pattern NAME = Pattern.compile("[A-Za-z][A-Za-z0-9 _-]{0,63}");
    private static final Unit DENSITY = Unit.parse("kg/m^3");

    private final WorldPrototype prototype;
    private final PhysicsReader physics;
    private final Problems problems;
    private final Map<String, Node> nodes = new LinkedHashMap<>();

    /** The parents of the classes; contains no class whose parent is wrong. */
    private final Map<String, String> parents = new LinkedHashMap<>();

    /**
     * @param prototype the prototype without classes
     * @param physics a reader for this prototype
     */
    ClassReader(WorldPrototype prototype, PhysicsReader physics, Problems problems) {
        this.prototype = prototype;
        this.physics = physics;
        this.problems = problems;
    }

    /** Returns the prototype with the classes. Classes with problems are omitted. */
    WorldPrototype read(List<Node> declared) throws WorldFileException {
        problems.requireAtMost(MAX_CLASSES, declared, "classes");
        for (Node node : declared) {
            if (!NAME.matcher(node.key()).matches()) {
                continue; // the schema check has reported it
            }
            Node before = nodes.putIfAbsent(node.key(), node);
            if (before != null) {
                problems.addAtKey(
                        node,
                        "duplicate class `"
                                + Node.shorten(node.key())
                                + "`, first "
                                + Problems.place(before, node));
            }
        }
        nodes.values().forEach(this::readParent);
        refuseCircles();
        List<ItemClass> classes = new ArrayList<>();
        for (Node node : nodes.values()) {
            Optional<String> kind = kind(node.key());
            if (kind.isPresent()) {
                classes.add(
                        new ItemClass(
                                node.key(),
                                parents.get(node.key()),
                                node.get("doc").flatMap(Node::text).orElse(""),
                                symbols(node),
                                properties(node, kind.get())));
            }
        }
        if (!classes.isEmpty() && prototype.symbol(StandardSymbols.CLASSES).isPresent()) {
            problems.addAtKey(
                    declared.getFirst(),
                    "a world with classes derives the symbol `classes`, which this world declares"
                            + " under `symbols`; expected another name of that symbol");
            return prototype;
        }
        return prototype.withClasses(classes);
    }

    /** Returns the codes of the substances that the classes name. */
    Set<Integer> usedSubstances() {
        return physics.usedSubstances();
    }

    /** Returns the parent that a class states. */
    static Optional<String> parent(Node itemClass) {
        return is(itemClass).flatMap(Node::text);
    }

    private static Optional<Node> is(Node itemClass) {
        return itemClass.isMapping() ? itemClass.get("is") : Optional.of(itemClass);
    }

    private void readParent(Node node) {
        if (prototype.hasKind(node.key())) {
            problems.addAtKey(
                    node,
                    "`"
                            + Node.shorten(node.key())
                            + "` is a kind; expected another name of a class");
            return;
        }
        Optional<Node> is = is(node);
        String parent = is.flatMap(Node::text).orElse(WorldPrototype.BODY);
        if (parent.equals(WorldPrototype.WORLD)) {
            problems.add(
                    is.orElseThrow(),
                    is.orElseThrow().label() + ": there is only one world, which has no class");
        } else if (nodes.containsKey(parent) || prototype.hasKind(parent)) {
            parents.put(node.key(), parent);
        } else {
            List<String> known =
                    Stream.concat(nodes.keySet().stream(), prototype.kinds().stream())
                            .filter(name -> !name.equals(WorldPrototype.WORLD))
                            .toList();
            problems.add(
                    is.orElseThrow(),
                    is.orElseThrow().label()
                            + ": there is no class or kind `"
                            + Node.shorten(parent)
                            + "`"
                            + problems.suggestion(parent, known));
        }
    }

    /** Refuses classes that are above themselves, and chains that are too long. */
    private void refuseCircles() {
        Set<String> refused = new HashSet<>();
        for (String name : List.copyOf(parents.keySet())) {
            Set<String> chain = new LinkedHashSet<>();
            String above = name;
            while (parents.containsKey(above) && chain.size() <= MAX_CHAIN && chain.add(above)) {
                above = parents.get(above);
            }
            boolean isCircle = chain.contains(above) && chain.size() <= MAX_CHAIN;
            if (isCircle && above.equals(name) && !refused.contains(name)) {
                refused.addAll(chain);
                problems.add(
                        is(name),
                        is(name).label()
                                + ": classes are above each other in a circle: "
                                + Node.list(List.copyOf(chain))
                                + ", "
                                + name);
            } else if (chain.size() > MAX_CHAIN) {
                refused.add(name);
                problems.add(
                        is(name),
                        is(name).label()
                                + ": more than "
                                + MAX_CHAIN
                                + " classes of which each is above the one before");
            }
        }
        refused.forEach(parents::remove);
    }

    private Node is(String name) {
        Node node = nodes.get(name);
        return node.get("is").orElse(node);
    }

    /** Returns the kind above a class; empty if the class or a class above it is wrong. */
    private Optional<String> kind(String name) {
        String above = name;
        for (int i = 0; i <= MAX_CHAIN && parents.containsKey(above); i++) {
            above = parents.get(above);
        }
        return Optional.of(above).filter(_ -> parents.containsKey(name)).filter(prototype::hasKind);
    }

    private Map<String, Object> symbols(Node node) {
        Map<String, Object> symbols = new LinkedHashMap<>();
        for (Node symbol : node.get("semantic").map(Node::children).orElse(List.of())) {
            ItemReader.symbolValue(symbol, prototype, problems)
                    .ifPresent(
                            value -> {
                                try {
                                    symbols.put(
                                            symbol.key(),
                                            prototype.requireInheritable(
                                                    node.key(), symbol.key(), value));
                                } catch (IllegalArgumentException refused) {
                                    problems.addAtKey(symbol, refused.getMessage());
                                }
                            });
        }
        return symbols;
    }

    private Map<String, List<Double>> properties(Node node, String kind) {
        Map<String, List<Double>> values = new LinkedHashMap<>();
        Optional<Node> aspect = node.get("physics").filter(Node::isMapping);
        if (aspect.isEmpty()) {
            return values;
        }
        physics.read(
                aspect.get(),
                kind,
                new PhysicsReader.Sink() {
                    @Override
                    public void numbers(String property, double[] numbers) {
                        values.put(property, Arrays.stream(numbers).boxed().toList());
                    }

                    @Override
                    public void references(PropertyDescriptor property, List<Node> targets) {
                        problems.addAtKey(
                                aspect.get().get(property.name()).orElseThrow(),
                                property.name()
                                        + ": refers to items, which a class cannot give to its"
                                        + " items");
                    }
                });
        physics.density(aspect.get(), kind)
                .flatMap(density -> density(density, aspect.get()))
                .or(() -> densityOfSubstance(aspect.get(), kind))
                .ifPresent(density -> values.put(ItemClass.DENSITY, List.of(density)));
        return values;
    }

    private Optional<Double> density(Node density, Node aspect) {
        if (aspect.get("mass").isPresent()) {
            problems.addAtKey(
                    density,
                    "density: `mass` is given too, which follows from density and shape; say one"
                            + " of them");
            return Optional.empty();
        }
        Optional<Double> value = new Quantities(problems).number(density, DENSITY);
        if (value.filter(each -> !(each > 0)).isPresent()) {
            problems.add(density, "density: " + value.get() + ", expected a positive one");
            return Optional.empty();
        }
        return value;
    }

    /**
     * Returns the density of the substance of a class, from which the mass of its items follows.
     */
    private Optional<Double> densityOfSubstance(Node aspect, String kind) {
        Optional<Node> name = physics.massySubstance(aspect, kind);
        Optional<Substances.Substance> substance = name.flatMap(physics::substance);
        if (substance.filter(found -> found.density().isEmpty()).isPresent()) {
            problems.add(
                    name.orElseThrow(),
                    "substance: "
                            + substance.get().name()
                            + " has no density; state it under `substances`, or state the `mass` or"
                            + " `density` of this class");
            return Optional.empty();
        }
        return substance.map(found -> found.density().getAsDouble());
    }
}
