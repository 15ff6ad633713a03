// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import org.jspecify.annotations.Nullable;

import reve.core.urdf.RobotModel.Inertial;
import reve.core.urdf.RobotModel.Joint;
import reve.core.urdf.RobotModel.Link;
import reve.core.world.Pose;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * The rigid bodies of a robot. Links that are connected by rigid joints form one body. A body
 * without mass becomes a part of the body above it.
 */
final class RigidTree {
    private final RobotModel model;
    private final List<String> notes;
    private final Set<String> rigid = new HashSet<>();
    private final Map<String, Pose> poses = new LinkedHashMap<>();
    private final Map<String, Body> bodies = new LinkedHashMap<>();

    /**
     * A rigid body.
     *
     * @param top the link of the body that is nearest to the root of the robot
     * @param links all links of the body
     */
    record Body(Link top, List<Link> links) {
        boolean hasMass() {
            return links.stream().anyMatch(link -> link.inertial().isPresent());
        }
    }

    /**
     * The mass properties of a body.
     *
     * @param pose centre of mass and principal axes, in the axes of the world
     * @param moments principal moments about these axes (3) [kg*m^2]
     */
    record Solid(double mass, Pose pose, double[] moments) {}

    /**
     * @param root pose of the root link in the world
     * @param notes receives one line for each difference from the file
     */
    RigidTree(RobotModel model, Pose root, List<String> notes) {
        this.model = model;
        this.notes = notes;
        for (Joint joint : model.joints()) {
            if (joint.isRigid()) {
                rigid.add(joint.name());
            }
        }
        poses.put(model.root(), root);
        while (poses.size() < model.links().size()) {
            for (Joint joint : model.joints()) {
                if (poses.containsKey(joint.parent())) {
                    poses.putIfAbsent(
                            joint.child(), joint.pose().within(poses.get(joint.parent())));
                }
            }
        }
        group();
        for (Joint joint = massless(); joint != null; joint = massless()) {
            notes.add(
                    "joint "
                            + joint.name()
                            + ": the link "
                            + joint.child()
                            + " has no mass, so it is a rigid part of "
                            + joint.parent());
            rigid.add(joint.name());
            group();
        }
    }

    private void group() {
        bodies.clear();
        Map<String, String> tops = new HashMap<>();
        Map<String, List<Link>> members = new LinkedHashMap<>();
        for (String name : poses.keySet()) { // parents precede their children
            String top = name;
            for (Joint joint : model.joints()) {
                if (joint.child().equals(name) && rigid.contains(joint.name())) {
                    top = tops.get(joint.parent());
                }
            }
            tops.put(name, top);
            members.computeIfAbsent(top, _ -> new ArrayList<>()).add(model.links().get(name));
        }
        members.forEach((top, links) -> bodies.put(top, new Body(links.getFirst(), links)));
    }

    /** Returns a movable joint whose child has no mass; null if there is none. */
    private @Nullable Joint massless() {
        for (Joint joint : model.joints()) {
            if (!rigid.contains(joint.name()) && !bodies.get(joint.child()).hasMass()) {
                return joint;
            }
        }
        return null;
    }

    List<Body> bodies() {
        return List.copyOf(bodies.values());
    }

    /** Returns the joints between different bodies. */
    List<Joint> joints() {
        return model.joints().stream().filter(joint -> !rigid.contains(joint.name())).toList();
    }

    Body bodyOf(String link) {
        for (Body body : bodies.values()) {
            if (body.links().stream().anyMatch(each -> each.name().equals(link))) {
                return body;
            }
        }
        throw new IllegalArgumentException("no link " + link);
    }

    /** Returns the pose of a link in the world, with all joints at 0. */
    Pose pose(String link) {
        return poses.get(link);
    }

    /**
     * Adds up the masses and the inertia of the links of a body. At least one link must have a
     * mass.
     */
    Solid solid(Body body) {
        double mass = 0;
        double[] centre = new double[3];
        for (Link link : body.links()) {
            if (link.inertial().isEmpty()) {
                continue;
            }
            Inertial inertial = link.inertial().get();
            double[] at = inertial.pose().within(pose(link.name())).location();
            mass += inertial.mass();
            for (int axis = 0; axis < 3; axis++) {
                centre[axis] += inertial.mass() * at[axis];
            }
        }
        for (int axis = 0; axis < 3; axis++) {
            centre[axis] /= mass;
        }
        SymmetricMatrix inertia = new SymmetricMatrix(new double[6]);
        for (Link link : body.links()) {
            if (link.inertial().isEmpty()) {
                continue;
            }
            Inertial inertial = link.inertial().get();
            Pose pose = inertial.pose().within(pose(link.name()));
            double[] from = pose.location();
            for (int axis = 0; axis < 3; axis++) {
                from[axis] -= centre[axis];
            }
            inertia =
                    inertia.plus(new SymmetricMatrix(inertial.inertia()).turned(pose))
                            .plus(SymmetricMatrix.ofPoint(inertial.mass(), from));
        }
        // The principal axes are computed relative to the top link, so that the axes of a body are
        // as close as possible to the axes of this link.
        Pose top = pose(body.top().name());
        Pose toTop =
                Pose.ORIGIN.relativeTo(new Pose(0, 0, 0, top.qx(), top.qy(), top.qz(), top.qw()));
        SymmetricMatrix.Principal principal = inertia.turned(toTop).principal();
        Pose axes =
                Pose.of(new double[3], principal.axes())
                        .within(new Pose(0, 0, 0, top.qx(), top.qy(), top.qz(), top.qw()));
        return new Solid(
                mass, Pose.of(centre, axes.orientation()), possible(body, principal.moments()));
    }

    /**
     * Returns moments that a real body can have. Replaces impossible moments by their mean and adds
     * a note.
     */
    private double[] possible(Body body, double[] moments) {
        double sum = moments[0] + moments[1] + moments[2];
        double largest = Math.max(moments[0], Math.max(moments[1], moments[2]));
        double least = Math.min(moments[0], Math.min(moments[1], moments[2]));
        if (least > 0 && 2 * largest <= sum) {
            return moments;
        }
        if (sum > 0 && least > 0 && 2 * largest <= sum * (1 + 1e-6)) {
            // The body is flat, and the file contains rounded moments. The largest moment is
            // reduced, so that a real body can have it.
            double[] flat = moments.clone();
            for (int axis = 0; axis < 3; axis++) {
                flat[axis] = Math.min(flat[axis], (sum - largest) * (1 - 1e-9));
            }
            return flat;
        }
        double mean = Math.max(sum / 3, 0);
        notes.add(
                "link "
                        + body.top().name()
                        + ": the principal moments "
                        + moments[0]
                        + ", "
                        + moments[1]
                        + ", "
                        + moments[2]
                        + " kg*m^2 are those of no real body; "
                        + (mean > 0
                                ? "their mean is used for all three"
                                : "those of its shapes are used"));
        return new double[] {mean, mean, mean};
    }
}
