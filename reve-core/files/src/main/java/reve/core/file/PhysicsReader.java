// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;

/** Reader of physics aspects. The prototype defines the properties with their types and units. */
final class PhysicsReader {
    /**
     * The words for the types of joints. The column stores the position of a word in this list,
     * from 1.
     */
    private static final List<String> JOINT_TYPES =
            List.of("fixed", "ball", "hinge", "slider", "distance", "rope", "six-axis");

    /** The highest number of a contact layer. A column has one bit for each layer. */
    private static final int MAX_LAYER = 31;

    private final WorldPrototype prototype;
    private final Set<String> misdeclared;
    private final Doubts doubts;
    private final Problems problems;
    private final Quantities quantities;
    private final Substances substances;
    private final Set<Integer> usedSubstances = new TreeSet<>();
    private final boolean hasSubstances;

    /** Creates a reader that knows the shipped substances only. */
    PhysicsReader(
            WorldPrototype prototype, Set<String> misdeclared, Doubts doubts, Problems problems) {
        this(prototype, misdeclared, Substances.shipped(), doubts, problems);
    }

    /**
     * @param misdeclared names of properties whose declaration was refused. Later uses of these
     *     properties cause no further problems
     */
    PhysicsReader(
            WorldPrototype prototype,
            Set<String> misdeclared,
            Substances substances,
            Doubts doubts,
            Problems problems) {
        this.substances = substances;
        this.hasSubstances = prototype.hasSubstances();
        this.doubts = doubts;
        this.prototype = prototype;
        this.misdeclared = misdeclared;
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /** Returns how questionable values are treated. */
    Doubts doubts() {
        return doubts;
    }

    WorldPrototype prototype() {
        return prototype;
    }

    /** A receiver of the values of a physics aspect, in the order of the file. */
    interface Sink {
        void numbers(String property, double[] values);

        /**
         * Receives the references of a property.
         *
         * @param targets nodes with the names of items, as many as the property has components
         */
        void references(PropertyDescriptor property, List<Node> targets);
    }

    void read(Node aspect, String kind, Sink sink) {
        for (Node value : aspect.isMapping() ? aspect.children() : List.<Node>of()) {
            if (problems.full()) {
                return;
            }
            if (!isDensity(value, kind)) {
                readProperty(value, kind, sink);
            }
        }
    }

    /** Reads a value whose key is the name of a property, and passes it to the sink. */
    void readProperty(Node value, String kind, Sink sink) {
        find(value, value.key(), kind)
                .ifPresent(
                        property -> {
                            if (property.type() == ScalarType.REF) {
                                references(value, property)
                                        .ifPresent(targets -> sink.references(property, targets));
                            } else {
                                numbers(value, property)
                                        .filter(numbers -> mayBegin(value, property, numbers))
                                        .ifPresent(
                                                numbers -> sink.numbers(property.name(), numbers));
                            }
                        });
    }

    /**
     * Returns the value of the key `density`, from which mass and inertia are computed. Returns
     * empty if the world declares a property of this name.
     */
    Optional<Node> density(Node aspect, String kind) {
        return aspect.get("density").filter(value -> isDensity(value, kind));
    }

    /**
     * Returns the name of the substance of a body, from whose density the mass follows. Returns
     * empty if the aspect states the mass or a density.
     */
    Optional<Node> massySubstance(Node aspect, String kind) {
        return kind.equals(WorldPrototype.BODY) && hasSubstances
                ? aspect.get(WorldPrototype.SUBSTANCE)
                        .filter(value -> value.text().isPresent())
                        .filter(_ -> aspect.get("mass").isEmpty())
                        .filter(_ -> density(aspect, kind).isEmpty())
                : Optional.empty();
    }

    /** Returns whether the mass that follows from an aspect depends on the shape of the item. */
    boolean needsShape(Node aspect, String kind) {
        return density(aspect, kind).isPresent() || massySubstance(aspect, kind).isPresent();
    }

    /** Returns the substance of a name; empty if there is none. */
    Optional<Substances.Substance> substance(Node name) {
        return name.text().flatMap(substances::find);
    }

    /** Returns the codes of the substances that the read items name, in ascending order. */
    Set<Integer> usedSubstances() {
        return usedSubstances;
    }

    private boolean isDensity(Node value, String kind) {
        return value.key().equals("density")
                && kind.equals(WorldPrototype.BODY)
                && prototype.find(kind, "density").isEmpty();
    }

    /**
     * Returns the constants of the world by name. A constant may be set only once in all files
     * together.
     */
    Map<String, List<Double>> constants(List<Node> aspects) {
        Map<String, List<Double>> values = new LinkedHashMap<>();
        Map<String, Node> given = new HashMap<>();
        for (Node aspect : aspects) {
            for (Node value : aspect.children()) {
                Node first = given.putIfAbsent(value.key(), value);
                if (first != null) {
                    problems.addAtKey(
                            value,
                            "duplicate constant `"
                                    + Node.shorten(value.key())
                                    + "`, first "
                                    + Problems.place(first, value));
                }
            }
            readConstants(aspect, values);
        }
        return values;
    }

    private void readConstants(Node aspect, Map<String, List<Double>> values) {
        read(
                aspect,
                WorldPrototype.WORLD,
                new Sink() {
                    @Override
                    public void numbers(String property, double[] numbers) {
                        values.put(property, Arrays.stream(numbers).boxed().toList());
                    }

                    @Override
                    public void references(PropertyDescriptor property, List<Node> targets) {
                        throw new IllegalStateException(
                                "kind world has no references: " + property);
                    }
                });
    }

    /**
     * Returns the property of a kind and name. Records a problem and returns empty if it is
     * unknown.
     *
     * @param where node whose key or value contains the name, for messages
     */
    Optional<PropertyDescriptor> find(Node where, String name, String kind) {
        Optional<PropertyDescriptor> property = prototype.find(kind, name);
        if (property.isEmpty() && !misdeclared.contains(name)) {
            String message =
                    "unknown physics property `"
                            + Node.shorten(name)
                            + "` of kind "
                            + kind
                            + hint(name, kind);
            if (where.key().equals(name)) {
                problems.addAtKey(where, message);
            } else {
                problems.add(where, message);
            }
        }
        return property;
    }

    /**
     * Reads the value of a numeric property in its unit. Records a problem and returns empty if the
     * value does not fit.
     */
    Optional<double[]> numbers(Node node, PropertyDescriptor property) {
        if (isJointType(property) && node.text().isPresent()) {
            return jointType(node);
        }
        if (property.name().equals("passesLayers") && node.isList()) {
            return layers(node, property);
        }
        if (isSubstance(property) && node.text().isPresent()) {
            return substanceCode(node);
        }
        Optional<double[]> numbers =
                quantities
                        .numbers(node, property.components(), property.unit())
                        .filter(values -> fits(node, property, values));
        return isOwnContact(property) && doubts == Doubts.REFUSED
                ? numbers.map(values -> new double[] {Substances.stated(values[0])})
                : numbers;
    }

    private boolean isSubstance(PropertyDescriptor property) {
        return property.kind().equals(WorldPrototype.BODY)
                && property.name().equals(WorldPrototype.SUBSTANCE)
                && hasSubstances;
    }

    /** Returns whether the value 0 of this property means that the value is not set. */
    private boolean isOwnContact(PropertyDescriptor property) {
        return hasSubstances
                && property.kind().equals(WorldPrototype.BODY)
                && property.components() == 1
                && switch (property.name()) {
                    case "friction", "restitution" -> true;
                    case "rollingFriction" -> isOfPairs(WorldPrototype.PAIR_ROLLING_FRICTION);
                    case "spinFriction" -> isOfPairs(WorldPrototype.PAIR_SPIN_FRICTION);
                    default -> false;
                };
    }

    private boolean isOfPairs(String property) {
        return prototype.find(WorldPrototype.SUBSTANCE_PAIR, property).isPresent();
    }

    /** Reads the name of a substance, and returns its code. */
    private Optional<double[]> substanceCode(Node node) {
        Optional<Substances.Substance> found = substance(node);
        if (found.isEmpty()) {
            List<String> known = substances.all().stream().map(Substances.Substance::name).toList();
            String suggestion = problems.suggestion(node.text().orElseThrow(), known);
            problems.add(
                    node,
                    node.label()
                            + ": there is no substance `"
                            + Node.shorten(node.text().orElseThrow())
                            + "`"
                            + (suggestion.isEmpty()
                                    ? "; known are "
                                            + Node.list(known)
                                            + "; others are described under `substances`"
                                    : suggestion));
            return Optional.empty();
        }
        usedSubstances.add(found.get().code());
        return Optional.of(new double[] {found.get().code()});
    }

    /** Reads a list of layer numbers. The result has one bit for each layer. */
    private Optional<double[]> layers(Node node, PropertyDescriptor property) {
        int bits = 0;
        for (Node layer : node.children()) {
            Optional<Double> number = quantities.number(layer, property.unit());
            if (number.isEmpty()) {
                return Optional.empty();
            }
            int index = number.get().intValue();
            if (index != number.get() || index < 0 || index > MAX_LAYER) {
                problems.add(
                        layer,
                        node.label()
                                + ": found "
                                + layer.describe()
                                + ", expected numbers of layers from 0 to "
                                + MAX_LAYER);
                return Optional.empty();
            }
            bits |= 1 << index;
        }
        return Optional.of(new double[] {bits});
    }

    private static boolean isJointType(PropertyDescriptor property) {
        return property.kind().equals(WorldPrototype.JOINT) && property.name().equals("jointType");
    }

    /** Reads the word for a type of joint, and returns its code. */
    private Optional<double[]> jointType(Node node) {
        int code = JOINT_TYPES.indexOf(node.text().orElseThrow());
        if (code < 0) {
            problems.add(
                    node,
                    node.label()
                            + ": found "
                            + node.describe()
                            + ", expected one of "
                            + String.join(", ", JOINT_TYPES));
            return Optional.empty();
        }
        return Optional.of(new double[] {code + 1});
    }

    /**
     * Returns whether an item may begin with these numbers. Records a problem if a designer sets a
     * sum of what laws add. A saved world contains the sums of its last step.
     */
    private boolean mayBegin(Node node, PropertyDescriptor property, double[] values) {
        boolean refused =
                property.accumulated()
                        && doubts == Doubts.REFUSED
                        && Arrays.stream(values).anyMatch(value -> value != 0);
        if (refused) {
            problems.add(
                    node,
                    node.label()
                            + ": found "
                            + node.describe()
                            + ", expected no value, because it is the sum of what laws add in each"
                            + " step; set a property that a law adds to it");
        }
        return !refused;
    }

    /**
     * Returns whether the values are in the range of the property. Records a problem if they are
     * not.
     */
    boolean fits(Node node, PropertyDescriptor property, double[] values) {
        for (double value : values) {
            if (value < property.minimum()) {
                problems.add(
                        node,
                        node.label() + ": found " + value + ", expected " + property.allowed());
                return false;
            }
        }
        return fits(node, property.type(), values);
    }

    /**
     * Returns whether a column of this type can represent the values. Records a problem if it
     * cannot.
     */
    boolean fits(Node node, ScalarType type, double[] values) {
        for (double value : values) {
            if (!type.holds(value)) {
                problems.add(
                        node,
                        node.label()
                                + ": "
                                + value
                                + " is not "
                                + switch (type) {
                                    case I32 -> "a whole number from -2147483648 to 2147483647";
                                    case U32 -> "a whole number from 0 to 4294967295";
                                    case F32, F64, REF ->
                                            "within the range of a 32-bit real; use prototype"
                                                    + " si-f64";
                                });
                return false;
            }
            if (type == ScalarType.F32 && value != 0 && (float) value == 0) {
                problems.add(
                        node,
                        node.label()
                                + ": "
                                + value
                                + " would become 0 as a 32-bit real; use prototype si-f64");
                return false;
            }
        }
        return type != ScalarType.F64 || isWorkable(node, values);
    }

    /**
     * Returns whether laws can compute with the numbers. Records a problem if the numbers are too
     * large.
     */
    boolean isWorkable(Node node, double... values) {
        for (double value : values) {
            if (Math.abs(value) > ScalarType.MAX_F64) {
                doubts.refuse(
                        node,
                        node.label()
                                + ": "
                                + value
                                + " is beyond 1e100; its powers "
                                + "would be no numbers, so expected a smaller one",
                        problems);
                return doubts != Doubts.REFUSED;
            }
            if (value != 0 && Math.abs(value) < ScalarType.MIN_F64 && doubts == Doubts.REFUSED) {
                problems.add(
                        node,
                        node.label()
                                + ": "
                                + value
                                + " is nearer to 0 than 1e-100; "
                                + "its powers would be 0, so expected 0 or a larger one");
                return false;
            }
        }
        return true;
    }

    private String hint(String name, String kind) {
        for (PropertyDescriptor property : prototype.properties()) {
            if (property.name().equals(name)) {
                return "; it is a property of kind " + property.kind();
            }
        }
        List<String> known = new ArrayList<>();
        for (PropertyDescriptor property : prototype.properties()) {
            if (property.kind().equals(kind)) {
                known.add(property.name());
            }
        }
        String suggestion = problems.suggestion(name, known);
        return suggestion.isEmpty()
                ? "; known are " + Node.list(known) + "; others are declared under `properties`"
                : suggestion;
    }

    private Optional<List<Node>> references(Node node, PropertyDescriptor property) {
        String expected =
                property.components() == 1
                        ? "the name of a " + property.refersTo().orElseThrow()
                        : "a list of "
                                + property.components()
                                + " names of items of kind "
                                + property.refersTo().orElseThrow();
        List<Node> targets =
                property.components() == 1
                        ? List.of(node)
                        : node.isList() ? List.copyOf(node.children()) : List.of();
        if (targets.size() != property.components()
                || targets.stream().anyMatch(target -> target.text().isEmpty())) {
            problems.add(
                    node, node.label() + ": found " + node.describe() + ", expected " + expected);
            return Optional.empty();
        }
        return Optional.of(targets);
    }
}
