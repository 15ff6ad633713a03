// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;

import reve.core.unit.Unit;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.stream.Stream;

/** Reader of the keys {@code camera} and {@code cameras}. */
final class CameraReader {
    private static final Unit METRE = Unit.parse("m");
    private static final Unit SECOND = Unit.parse("s");
    private static final double DEFAULT_FOV_RADIANS = Math.PI / 4;
    private static final double[] UP = {0, 1, 0};
    private static final double[] ITEM_ITSELF = {0, 0, 0};

    private final ItemMentions names;
    private final Quantities quantities;
    private final Problems problems;

    /**
     * @param names the items of the file
     */
    CameraReader(ItemMentions names, Problems problems) {
        this.names = names;
        this.quantities = new Quantities(problems);
        this.problems = problems;
    }

    /**
     * Returns the camera under the key {@code camera}. It is used for pictures for which no named
     * camera is selected.
     */
    Optional<CameraDescription> read(Node node) {
        return view(node, node, null, true, false);
    }

    /** Returns the valid cameras of a mapping, in the order of the file. */
    List<NamedCamera> readAll(Node cameras) {
        List<NamedCamera> all = new ArrayList<>();
        for (Node node : cameras.children()) {
            if (problems.full()) {
                break;
            }
            named(node).ifPresent(all::add);
        }
        return all;
    }

    private Optional<NamedCamera> named(Node node) {
        Optional<Node> follow = node.get("follow");
        Optional<Node> lookAt = node.get("lookAt");
        Optional<Node> turning = node.get("turning");
        Optional<String> followed = follow.flatMap(names::body);
        Optional<String> lookedAt = lookAt.flatMap(names::body);
        if (turning.isPresent() && follow.isEmpty()) {
            problems.add(
                    turning.get(),
                    "turning: the camera follows no item, expected `follow` beside it");
        }
        Optional<Node> frames = node.get("keyframes");
        if (lookAt.isPresent()) {
            Stream.concat(Stream.of(node), frames.stream().flatMap(all -> all.children().stream()))
                    .flatMap(each -> each.get("target").stream())
                    .forEach(
                            each ->
                                    problems.add(
                                            each,
                                            "target: found beside `lookAt`, expected one of them"));
        }
        boolean isFixed = follow.isEmpty() && lookAt.isEmpty();
        double @Nullable [] target = isFixed ? null : ITEM_ITSELF;
        List<NamedCamera.Key> keys = new ArrayList<>();
        if (frames.isEmpty()) {
            view(node, node, target, isFixed, true)
                    .ifPresent(view -> keys.add(new NamedCamera.Key(0, view)));
        } else {
            keyframes(frames.get(), node, target, isFixed, keys);
        }
        if (keys.isEmpty()
                || followed.isPresent() != follow.isPresent()
                || lookedAt.isPresent() != lookAt.isPresent()) {
            return Optional.empty();
        }
        return Optional.of(
                new NamedCamera(
                        node.key(),
                        followed,
                        turning.flatMap(Node::truth).orElse(false),
                        lookedAt,
                        keys));
    }

    private void keyframes(
            Node frames,
            Node camera,
            double @Nullable [] target,
            boolean isFixed,
            List<NamedCamera.Key> keys) {
        double last = Double.NEGATIVE_INFINITY;
        for (Node frame : frames.children()) {
            if (problems.full()) {
                return;
            }
            Optional<Double> time =
                    frame.get("time").flatMap(node -> quantities.number(node, SECOND));
            if (time.isPresent() && time.get() <= last) {
                problems.add(
                        frame.get("time").orElseThrow(),
                        "time: "
                                + time.get()
                                + " s is not after the keyframe before it, at "
                                + last
                                + " s");
            }
            last = time.orElse(last);
            Optional<CameraDescription> view = view(frame, camera, target, isFixed, true);
            if (time.isPresent() && view.isPresent()) {
                keys.add(new NamedCamera.Key(time.get(), view.get()));
            }
        }
    }

    /**
     * Returns a view.
     *
     * @param camera camera that provides the values that the node lacks
     * @param otherwise default of the target; null if the node must have a target
     * @param isFixed whether eye and target are places in the world, so that they can be compared
     * @param tell whether to report missing values; the schema check reports them for {@code
     *     camera}
     */
    private Optional<CameraDescription> view(
            Node node, Node camera, double @Nullable [] otherwise, boolean isFixed, boolean tell) {
        Optional<double[]> eye = vector(node, camera, "eye", METRE, null, tell);
        Optional<double[]> target = vector(node, camera, "target", METRE, otherwise, tell);
        Optional<double[]> up = vector(node, camera, "up", Unit.ONE, UP, tell);
        Optional<Node> angle = node.get("fov").or(() -> camera.get("fov"));
        Optional<Double> fov =
                angle.isEmpty() ? Optional.of(DEFAULT_FOV_RADIANS) : fov(angle.get());
        if (eye.isEmpty() || target.isEmpty() || up.isEmpty() || fov.isEmpty()) {
            return Optional.empty();
        }
        check(node, eye.get(), target.get(), up.get(), isFixed);
        return Optional.of(new CameraDescription(eye.get(), target.get(), up.get(), fov.get()));
    }

    private Optional<double[]> vector(
            Node node,
            Node camera,
            String key,
            Unit unit,
            double @Nullable [] otherwise,
            boolean tell) {
        Optional<Node> given = node.get(key).or(() -> camera.get(key));
        if (given.isEmpty() && otherwise == null && tell) {
            problems.add(node, node.label() + ": `" + key + "` is missing");
        }
        return given.isEmpty()
                ? Optional.ofNullable(otherwise)
                : quantities.numbers(given.get(), 3, unit);
    }

    private void check(Node node, double[] eye, double[] target, double[] up, boolean isFixed) {
        double[] sight = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            sight[axis] = target[axis] - eye[axis];
        }
        double farthest = Math.max(largest(eye), largest(target));
        if (farthest > CameraDescription.FARTHEST_METRES) {
            problems.add(
                    node,
                    "camera: found a coordinate of "
                            + farthest
                            + " m, pictures reach "
                            + CameraDescription.FARTHEST_METRES
                            + " m");
        } else if (!isFixed) {
            return; // only the running world knows where the item is
        } else if (length(sight) <= CameraDescription.NEAREST_TARGET * farthest) {
            problems.add(node.get("target").orElse(node), "target: is where the eye is");
        } else if (length(cross(sight, up))
                <= CameraDescription.SMALLEST_TILT * length(sight) * length(up)) {
            problems.add(
                    node.get("up").or(() -> node.get("target")).orElse(node),
                    "up: has no direction across the line of sight, expected another `up`");
        }
    }

    private Optional<Double> fov(Node node) {
        return quantities
                .number(node, Unit.ONE)
                .filter(
                        angle -> {
                            boolean possible =
                                    angle >= CameraDescription.NARROWEST_RADIANS
                                            && angle <= CameraDescription.WIDEST_RADIANS;
                            if (!possible) {
                                problems.add(
                                        node,
                                        "fov: "
                                                + angle
                                                + " rad is not between 0.1 and 175 deg; write "
                                                + "degrees as `45 deg`");
                            }
                            return possible;
                        });
    }

    private static double length(double[] v) {
        return Math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }

    private static double largest(double[] v) {
        return Math.max(Math.abs(v[0]), Math.max(Math.abs(v[1]), Math.abs(v[2])));
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }
}
