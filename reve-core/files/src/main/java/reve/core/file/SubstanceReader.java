// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.file.Substances.Contact;
import reve.core.file.Substances.Pair;
import reve.core.file.Substances.Substance;
import reve.core.unit.Unit;

import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.TreeMap;

/** Reader of the key {@code substances}, which describes substances and pairs of substances. */
final class SubstanceReader {
    private static final Unit DENSITY = Unit.parse("kg/m^3");
    private static final Unit LENGTH = Unit.parse("m");
    private static final double MAX_FRICTION = 100;

    /** Largest lever arm of a torque against rolling or spinning [m]. */
    private static final double MAX_LEVER_ARM = 1000;

    private final Problems problems;
    private final Quantities quantities;

    SubstanceReader(Problems problems) {
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /**
     * Returns the shipped substances and those of the files. A substance with the name of a shipped
     * one has the values of the shipped one that the file does not state.
     *
     * @param nodes the substances of all files
     */
    Substances read(List<Node> nodes) {
        if (nodes.isEmpty()) {
            return Substances.shipped();
        }
        Map<String, Substance> all = new LinkedHashMap<>();
        Substances.shipped().all().forEach(each -> all.put(each.name(), each));
        Map<String, Node> first = new HashMap<>();
        int code = Substances.FIRST_OWN_CODE;
        for (Node node : nodes) {
            Node earlier = first.putIfAbsent(node.key(), node);
            if (earlier != null) {
                problems.addAtKey(
                        node,
                        "duplicate substance `"
                                + Node.shorten(node.key())
                                + "`, first "
                                + Problems.place(earlier, node));
                continue;
            }
            Optional<Substance> shipped = Substances.shipped().find(node.key());
            int own = shipped.isPresent() ? shipped.get().code() : code++;
            all.put(node.key(), substance(node, own, shipped));
        }
        Map<Pair, Contact> pairs = new TreeMap<>(Substances.shipped().pairs());
        Map<Pair, Node> stated = new TreeMap<>();
        for (Node node : first.values().stream().sorted(SubstanceReader::inOrder).toList()) {
            for (Node other : node.get("with").map(Node::children).orElse(List.of())) {
                readPair(node, other, all, stated, pairs);
            }
        }
        return new Substances(all, pairs);
    }

    private static int inOrder(Node one, Node other) {
        return one.key().compareTo(other.key());
    }

    private Substance substance(Node node, int code, Optional<Substance> shipped) {
        OptionalDouble density = number(node, "density", DENSITY);
        if (density.isPresent() && !(density.getAsDouble() > 0)) {
            Node value = node.get("density").orElseThrow();
            problems.add(
                    value, "density: found " + density.getAsDouble() + ", expected more than 0");
        }
        return new Substance(
                node.key(),
                code,
                orElse(density, shipped.map(Substance::density)),
                contact(node).or(shipped.map(Substance::contact).orElse(Contact.UNKNOWN)));
    }

    private static OptionalDouble orElse(OptionalDouble value, Optional<OptionalDouble> other) {
        return value.isPresent() ? value : other.orElse(OptionalDouble.empty());
    }

    private void readPair(
            Node node,
            Node other,
            Map<String, Substance> all,
            Map<Pair, Node> stated,
            Map<Pair, Contact> pairs) {
        Substance one = all.get(node.key());
        Substance partner = all.get(other.key());
        if (partner == null) {
            problems.addAtKey(
                    other,
                    "with: there is no substance `"
                            + Node.shorten(other.key())
                            + "`"
                            + problems.suggestion(other.key(), all.keySet()));
            return;
        }
        Pair pair = Pair.of(one.code(), partner.code());
        Node earlier = stated.putIfAbsent(pair, other);
        if (earlier != null) {
            problems.addAtKey(
                    other,
                    "with: the pair of `"
                            + one.name()
                            + "` and `"
                            + partner.name()
                            + "` has its values already "
                            + Problems.place(earlier, other));
            return;
        }
        pairs.put(pair, contact(other).or(pairs.getOrDefault(pair, Contact.UNKNOWN)));
    }

    private Contact contact(Node node) {
        return new Contact(
                inRange(node, "friction", Unit.ONE, MAX_FRICTION),
                inRange(node, "restitution", Unit.ONE, 1),
                inRange(node, "rollingFriction", LENGTH, MAX_LEVER_ARM),
                inRange(node, "spinFriction", LENGTH, MAX_LEVER_ARM));
    }

    private OptionalDouble inRange(Node node, String key, Unit unit, double most) {
        OptionalDouble value = number(node, key, unit);
        if (value.isPresent() && !(value.getAsDouble() >= 0 && value.getAsDouble() <= most)) {
            problems.add(
                    node.get(key).orElseThrow(),
                    key + ": found " + value.getAsDouble() + ", expected 0 to " + most);
        }
        return value;
    }

    private OptionalDouble number(Node node, String key, Unit unit) {
        Optional<Double> number = node.get(key).flatMap(value -> quantities.number(value, unit));
        return number.isPresent() ? OptionalDouble.of(number.get()) : OptionalDouble.empty();
    }
}
