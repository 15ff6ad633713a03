package reve.core.file;

import java.util.EnumSet;
import java.util.List;
import java.util.Locale;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.TreeSet;
import reve.core.unit.Unit;
import reve.core.world.Sensor;
import reve.core.world.Sensor.Aspect;

/** Reads the {@code sensors} of a body. */
final class SensorReader {
    private static final Unit METRE = Unit.parse("m");

    private final Problems problems;
    private final Quantities quantities;

    SensorReader(Problems problems) {
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /** One sensor; empty and a problem noted if it cannot be. */
    Optional<Sensor> read(Node node) {
        boolean touch = node.get("touch").flatMap(Node::truth).orElse(false);
        if (touch) {
            refuseForTouch(node, "fieldOfView");
            refuseForTouch(node, "lineOfSight");
        }
        Optional<Double> range = number(node, "range", METRE,
                touch ? Sensor.TOUCH_RANGE : Double.POSITIVE_INFINITY);
        Optional<Double> field = number(node, "fieldOfView", Unit.ONE, Sensor.ALL_ROUND);
        if (range.isEmpty() || field.isEmpty()) {
            return Optional.empty();
        }
        try {
            return Optional.of(new Sensor(node.key(), touch, range.get(), field.get(),
                    node.get("lineOfSight").flatMap(Node::truth).orElse(false),
                    node.get("every").flatMap(Node::number).map(Double::intValue).orElse(1),
                    node.get("symbols").map(SensorReader::names),
                    node.get("aspects").map(SensorReader::aspects)
                            .orElse(EnumSet.allOf(Aspect.class))));
        } catch (IllegalArgumentException refused) {
            problems.add(node, refused.getMessage());
            return Optional.empty();
        }
    }

    private void refuseForTouch(Node node, String key) {
        node.get(key).ifPresent(unused -> problems.addAtKey(unused,
                key + ": a sensor with `touch: true` does not look; leave it out"));
    }

    private Optional<Double> number(Node node, String key, Unit unit, double otherwise) {
        Optional<Node> given = node.get(key);
        return given.isEmpty() ? Optional.of(otherwise) : quantities.number(given.get(), unit);
    }

    private static SortedSet<String> names(Node list) {
        var names = new TreeSet<String>();
        list.children().forEach(name -> name.text().ifPresent(names::add));
        return names;
    }

    private static Set<Aspect> aspects(Node list) {
        var aspects = EnumSet.noneOf(Aspect.class);
        for (String name : List.copyOf(names(list))) {
            for (Aspect aspect : Aspect.values()) {
                if (aspect.name().toLowerCase(Locale.ROOT).equals(name)) {
                    aspects.add(aspect);
                }
            }
        }
        return aspects;
    }
}
