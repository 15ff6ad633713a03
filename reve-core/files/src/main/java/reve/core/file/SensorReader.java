// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;
import reve.core.world.Sensor;
import reve.core.world.Sensor.Aspect;
import reve.core.world.Sensor.Camera;
import reve.core.world.Sensor.Layer;
import reve.core.world.Voice;

import java.util.EnumSet;
import java.util.List;
import java.util.Locale;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.TreeSet;
import java.util.function.Supplier;

/** Reader of the {@code sensors} and the {@code voice} of a body. */
final class SensorReader {
    private static final String TOUCHES = "a sensor with `touch: true` does not look";
    private static final double CAMERA_FIELD_OF_VIEW = Math.toRadians(60);
    private static final Unit METRE = Unit.parse("m");

    private final Problems problems;
    private final Quantities quantities;
    private final InstrumentReader instruments;

    SensorReader(Problems problems) {
        this.problems = problems;
        this.quantities = new Quantities(problems);
        this.instruments = new InstrumentReader(problems, quantities);
    }

    /** Reads one sensor. Records a problem and returns empty if it is invalid. */
    Optional<Sensor> read(Node node) {
        Optional<String> instrument = InstrumentReader.key(node);
        if (instrument.isPresent()) {
            return readInstrument(node, instrument.get());
        }
        if (node.get("hearing").flatMap(Node::truth).orElse(false)) {
            return readHearing(node);
        }
        Optional<Node> camera = node.get("camera");
        return camera.isPresent() ? readCamera(node, camera.get()) : readSense(node);
    }

    private Optional<Sensor> readInstrument(Node node, String instrument) {
        for (Node other : node.children()) {
            if (!other.key().equals(instrument) && !other.key().equals("every")) {
                refuse(node, other.key(), "a sensor with `" + instrument + "` only measures");
            }
        }
        return instruments
                .read(node.get(instrument).orElseThrow())
                .flatMap(
                        made ->
                                checked(
                                        node,
                                        () ->
                                                Sensor.measuring(node.key(), made)
                                                        .withEvery(every(node))));
    }

    /** Reads a voice. Records a problem and returns empty if it is invalid. */
    Optional<Voice> readVoice(Node node) {
        Optional<Double> range = number(node, "range", METRE, Double.POSITIVE_INFINITY);
        Optional<Double> fading = number(node, "fading", METRE, Double.POSITIVE_INFINITY);
        if (range.isEmpty() || fading.isEmpty()) {
            return Optional.empty();
        }
        return checked(node, () -> new Voice(range.get(), fading.get()));
    }

    private Optional<Sensor> readHearing(Node node) {
        for (String key :
                List.of(
                        "touch",
                        "fieldOfView",
                        "lineOfSight",
                        "camera",
                        "every",
                        "symbols",
                        "aspects")) {
            refuse(node, key, "a sensor with `hearing: true` hears voices and senses no items");
        }
        return number(node, "range", METRE, Double.POSITIVE_INFINITY)
                .flatMap(range -> checked(node, () -> Sensor.hearing(node.key(), range)));
    }

    private Optional<Sensor> readCamera(Node node, Node camera) {
        for (String key : List.of("touch", "lineOfSight", "symbols", "aspects")) {
            refuse(node, key, "a camera sends pictures and senses no items");
        }
        Optional<double[]> size =
                camera.get("size").flatMap(pixels -> quantities.numbers(pixels, 2, Unit.ONE));
        Optional<Double> range = number(node, "range", METRE, Double.POSITIVE_INFINITY);
        Optional<Double> field = number(node, "fieldOfView", Unit.ONE, CAMERA_FIELD_OF_VIEW);
        if (size.isEmpty() || range.isEmpty() || field.isEmpty()) {
            return Optional.empty();
        }
        return checked(
                node,
                () ->
                        Sensor.camera(
                                        node.key(),
                                        field.get(),
                                        new Camera(
                                                whole(size.get()[0]),
                                                whole(size.get()[1]),
                                                camera.get("layers")
                                                        .map(SensorReader::layers)
                                                        .orElse(EnumSet.of(Layer.COLOUR))))
                                .withRange(range.get())
                                .withEvery(every(node)));
    }

    private static int whole(double pixels) {
        if (pixels != Math.rint(pixels)) {
            throw new IllegalArgumentException("camera: " + pixels + " is no number of pixels");
        }
        return (int) pixels;
    }

    private Optional<Sensor> readSense(Node node) {
        boolean touch = node.get("touch").flatMap(Node::truth).orElse(false);
        if (touch) {
            refuse(node, "fieldOfView", TOUCHES);
            refuse(node, "lineOfSight", TOUCHES);
        }
        Optional<Double> range =
                number(node, "range", METRE, touch ? Sensor.TOUCH_RANGE : Double.POSITIVE_INFINITY);
        Optional<Double> field = number(node, "fieldOfView", Unit.ONE, Sensor.ALL_ROUND);
        if (range.isEmpty() || field.isEmpty()) {
            return Optional.empty();
        }
        return checked(
                node,
                () ->
                        new Sensor(
                                node.key(),
                                touch,
                                range.get(),
                                field.get(),
                                node.get("lineOfSight").flatMap(Node::truth).orElse(false),
                                every(node),
                                node.get("symbols").map(SensorReader::names),
                                node.get("aspects")
                                        .map(SensorReader::aspects)
                                        .orElse(EnumSet.allOf(Aspect.class)),
                                Optional.empty(),
                                Optional.empty()));
    }

    private <T> Optional<T> checked(Node node, Supplier<T> value) {
        try {
            return Optional.of(value.get());
        } catch (IllegalArgumentException refused) {
            String subject = refused.getMessage().split(":", 2)[0];
            problems.add(node.get(subject).orElse(node), refused.getMessage());
            return Optional.empty();
        }
    }

    private static int every(Node node) {
        return node.get("every").flatMap(Node::number).map(Double::intValue).orElse(1);
    }

    private void refuse(Node node, String key, String why) {
        node.get(key)
                .ifPresent(
                        unused -> problems.addAtKey(unused, key + ": " + why + "; leave it out"));
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

    private static Set<Layer> layers(Node list) {
        var layers = EnumSet.noneOf(Layer.class);
        Set<String> names = names(list);
        for (Layer layer : Layer.values()) {
            if (names.contains(layer.name().toLowerCase(Locale.ROOT))) {
                layers.add(layer);
            }
        }
        return layers;
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
