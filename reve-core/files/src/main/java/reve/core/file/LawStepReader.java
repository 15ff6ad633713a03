// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;

import java.util.ArrayList;
import java.util.Collection;
import java.util.Comparator;
import java.util.List;
import java.util.Locale;
import java.util.Optional;
import java.util.Set;

/** Reader of the schedule of an experiment: the changes of laws in one run. */
final class LawStepReader {
    private static final Unit SECOND = Unit.parse("s");
    private static final List<String> CHANGES = List.of("load", "unload", "set", "text");

    /**
     * Fraction of a frame by which a time may exceed the beginning of a frame. A larger excess is
     * not a rounding error.
     */
    private static final double ROUNDING = 1e-6;

    private final WorldDescription world;
    private final long frames;
    private final Problems problems;
    private final Quantities quantities;
    private final PhysicsReader physics;

    /**
     * @param frames number of frames of the run
     */
    LawStepReader(WorldDescription world, long frames, Problems problems) {
        this.world = world;
        this.frames = frames;
        this.problems = problems;
        this.quantities = new Quantities(problems);
        this.physics = new PhysicsReader(world.prototype(), Set.of(), Doubts.REFUSED, problems);
    }

    /**
     * Returns the changes in the order of their frames. The changes of one frame have the order of
     * the file.
     */
    List<LawStep> readAll(Iterable<Node> nodes) {
        List<LawStep> steps = new ArrayList<>();
        for (Node node : nodes) {
            Optional<String> change = one(node, CHANGES);
            Optional<Long> frame = one(node, List.of("at", "frame")).flatMap(key -> frame(node));
            if (change.isPresent()) {
                Optional<LawReference> law = law(node, change.get());
                if (frame.isPresent() && law.isPresent()) {
                    steps.add(
                            new LawStep(
                                    frame.get(),
                                    LawStep.Change.valueOf(change.get().toUpperCase(Locale.ROOT)),
                                    law.get()));
                }
            }
        }
        steps.sort(Comparator.comparingLong(LawStep::frame));
        return steps;
    }

    private Optional<String> one(Node node, List<String> keys) {
        List<String> found = keys.stream().filter(key -> node.get(key).isPresent()).toList();
        if (found.size() == 1) {
            return Optional.of(found.getFirst());
        }
        problems.add(
                node,
                node.label()
                        + ": found "
                        + (found.isEmpty() ? "none" : String.join(" and ", found))
                        + ", expected one of "
                        + String.join(", ", keys));
        return Optional.empty();
    }

    private Optional<Long> frame(Node node) {
        Node given = node.get("at").or(() -> node.get("frame")).orElseThrow();
        Optional<Double> frame =
                node.get("at").isEmpty()
                        ? given.number()
                        : quantities.number(given, SECOND).map(this::firstFrameAt);
        if (frame.isPresent() && !(frame.get() >= 1 && frame.get() <= frames)) {
            problems.add(
                    given,
                    given.label()
                            + ": is in frame "
                            + Math.round(frame.get())
                            + ", and the run has frames 1 to "
                            + frames);
            return Optional.empty();
        }
        return frame.map(Double::longValue);
    }

    /** Returns the number of the first frame that begins at this time [s] or later. */
    private double firstFrameAt(double seconds) {
        return Math.ceil(seconds * world.timing().framesPerSecond() - ROUNDING) + 1;
    }

    private Optional<LawReference> law(Node node, String change) {
        Optional<String> text = node.get("text").flatMap(Node::text);
        Optional<String> name =
                text.isPresent()
                        ? text.map(WorldReader::nameInText)
                        : node.get(change).flatMap(Node::text);
        Optional<Node> parameters = node.get("parameters");
        if (change.equals("unload") && parameters.isPresent()) {
            problems.add(parameters.get(), "parameters: do not go with `unload`");
        }
        if (change.equals("set") && parameters.isEmpty()) {
            problems.add(node, node.label() + ": `parameters` are missing, which `set` changes");
        }
        return name.map(
                law ->
                        ParameterFile.reference(
                                law,
                                text,
                                parameters.<Collection<Node>>map(Node::children).orElse(List.of()),
                                Problems.place(node),
                                quantities,
                                physics,
                                problems));
    }
}
