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

/** Reader of physics aspects. The prototype defines the properties with their types and units. */
final class PhysicsReader {
    /**
     * The words for the types of joints. The column stores the position of a word in this list,
     * from 1.
     */
    private static final List<String> JOINT_TYPES =
            List.of("fixed", "ball", "hinge", "slider", "distance");

    /** The highest number of a contact layer. A column has one bit for each layer. */
    private static final int MAX_LAYER = 31;

    private final WorldPrototype prototype;
    private final Set<String> misdeclared;
    private final Doubts doubts;
    private final Problems problems;
    private final Quantities quantities;

    /**
     * @param misdeclared names of properties whose declaration was refused. Later uses of these
     *     properties cause no further problems
     */
    PhysicsReader(
            WorldPrototype prototype, Set<String> misdeclared, Doubts doubts, Problems problems) {
        this.doubts = doubts;
        this.prototype = prototype;
        this.misdeclared = misdeclared;
        this.problems = problems;
        this.quantities = new Quantities(problems);
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
     * Returns the property of a kind and name. If it is unknown, records a problem and returns
     * empty.
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
     * Reads the value of a numeric property in its unit. If the value does not fit, records a
     * problem and returns empty.
     */
    Optional<double[]> numbers(Node node, PropertyDescriptor property) {
        if (isJointType(property) && node.text().isPresent()) {
            return jointType(node);
        }
        if (property.name().equals("passesLayers") && node.isList()) {
            return layers(node, property);
        }
        return quantities
                .numbers(node, property.components(), property.unit())
                .filter(values -> fits(node, property, values));
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
