// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.world.Pose;

import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * A robot as a URDF file describes it: a tree of links (rigid bodies) and joints. Axes are those of
 * the file, usually with +Z up.
 *
 * @param links by name, in the order of the file
 * @param root name of the link that is the child of no joint
 * @param ignored what the file contains and this reader does not read, a line for each kind
 */
record RobotModel(
        String name,
        Map<String, Link> links,
        List<Joint> joints,
        String root,
        List<String> ignored) {

    /** A rigid body and its shapes, which have poses in the frame of the link. */
    record Link(
            String name,
            String place,
            Optional<Inertial> inertial,
            List<Geometry> looks,
            List<Geometry> collisions) {}

    /**
     * @param pose centre of mass, and the axes of the inertia
     * @param mass [kg]
     * @param inertia xx yy zz yz zx xy about these axes [kg*m^2]
     */
    record Inertial(Pose pose, double mass, double[] inertia) {}

    /**
     * @param colour as #rrggbb or #rrggbbaa
     */
    record Geometry(String place, Pose pose, Form form, Optional<String> colour) {}

    /** A shape about the origin of its geometry. */
    sealed interface Form {
        /** The lengths of the edges (3) [m]. */
        record Box(double[] size) implements Form {}

        /** A ball. */
        record Sphere(double radius) implements Form {}

        /** A cylinder along Z. */
        record Cylinder(double radius, double length) implements Form {}

        /**
         * @param name as the file names it
         * @param scale of its three axes
         */
        record MeshFile(String name, double[] scale) implements Form {}
    }

    /** What the child of a joint may do relative to the parent. */
    enum JointType {
        REVOLUTE,
        CONTINUOUS,
        PRISMATIC,
        FIXED,
        FLOATING,
        PLANAR
    }

    /**
     * @param pose of the joint, and of the child at the angle 0, in the frame of the parent
     * @param axis unit vector in the frame of the joint
     * @param limits least and greatest angle or travel [1 or m], if there are any
     * @param effort largest torque or force [N*m or N], 0 if the file states none
     * @param speed largest speed [rad/s or m/s], 0 if the file states none
     * @param friction dry friction [N*m or N]
     */
    record Joint(
            String name,
            String place,
            JointType type,
            String parent,
            String child,
            Pose pose,
            double[] axis,
            Optional<double[]> limits,
            double effort,
            double speed,
            double friction) {
        /** Returns whether the child cannot move. */
        boolean isRigid() {
            return type == JointType.FIXED
                    || limits.isPresent() && limits.get()[0] == limits.get()[1];
        }
    }
}
