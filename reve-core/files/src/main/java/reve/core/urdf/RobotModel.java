// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.world.Pose;

import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * A robot as a file describes it: a tree of links (rigid bodies) and joints. Axes are those of the
 * file, usually with +Z up.
 *
 * @param links by name, in the order of the file
 * @param root name of the link that is the child of no joint
 * @param scene what a file of MJCF states about the world around the robot
 * @param ignored what the file contains and this reader does not read, a line for each kind
 */
record RobotModel(
        String name,
        Map<String, Link> links,
        List<Joint> joints,
        String root,
        Optional<Scene> scene,
        List<String> ignored) {

    /**
     * The world around a robot.
     *
     * @param gravity (3) [m/s^2]
     * @param step duration of a physics step [s]
     * @param scenery immovable shapes that collide
     */
    record Scene(double[] gravity, double step, List<Scenery> scenery) {
        /** Returns the coefficient of friction of the scenery; without scenery 1, as in MJCF. */
        double friction() {
            return scenery.isEmpty() ? 1 : scenery.getFirst().surface().friction();
        }
    }

    /** An immovable shape that collides, with its pose in the frame of the root link. */
    record Scenery(String name, Geometry geometry, Surface surface) {}

    /**
     * How the shapes of a link collide: two shapes collide if the type of one has a bit of the
     * affinity of the other.
     *
     * @param friction coefficient of sliding [1]
     */
    record Surface(int type, int affinity, double friction) {
        boolean touches(Surface other) {
            return (type & other.affinity) != 0 || (other.type & affinity) != 0;
        }
    }

    /**
     * A rigid body and its shapes, which have poses in the frame of the link.
     *
     * @param surface of the shapes that collide, if the file states one
     */
    record Link(
            String name,
            String place,
            Optional<Inertial> inertial,
            List<Geometry> looks,
            List<Geometry> collisions,
            Optional<Surface> surface) {}

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
         * A cylinder along Z with half balls at both ends.
         *
         * @param length of the whole [m]
         */
        record Capsule(double radius, double length) implements Form {}

        /** A rectangle whose normal is +Z, with edges along X and Y [m]. */
        record Plane(double x, double y) implements Form {}

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
        PLANAR,
        BALL
    }

    /** What an action sets. */
    enum DriveKind {
        /** The speed of the joint, which a motor reaches. */
        SPEED,
        /** The torque or force that acts on the joint. */
        LOAD,
        /** The angle or travel, which a motor approaches. */
        PLACE
    }

    /**
     * An action that drives a joint.
     *
     * @param range least and greatest value of what the action sets, infinite without a bound
     * @param most largest torque or force [N*m or N], 0 without a bound
     * @param rate share of the way to a place that the motor moves per second [1/s]
     * @param actuator name in the file, empty if the drive is the joint's own
     */
    record Drive(DriveKind kind, double[] range, double most, double rate, String actuator) {
        /** Returns a drive with a speed of at most {@code speed}, or of any speed if that is 0. */
        static Drive ofSpeed(double speed, double most) {
            double bound = speed > 0 ? speed : Double.POSITIVE_INFINITY;
            return new Drive(DriveKind.SPEED, new double[] {-bound, bound}, most, 0, "");
        }
    }

    /**
     * What acts along the axis of a hinge or slider; a ball has only damping.
     *
     * @param damping torque or force per speed [N*m*s or N*s/m]
     * @param friction dry friction [N*m or N]
     * @param stiffness of the spring [N*m or N/m]
     * @param rest angle or travel at which the spring exerts nothing [1 or m]
     * @param rotor inertia that the joint adds [kg*m^2 or kg]
     */
    record Loads(double damping, double friction, double stiffness, double rest, double rotor) {
        static final Loads NONE = new Loads(0, 0, 0, 0, 0);
    }

    /**
     * @param pose of the joint, and of the child at the angle 0, in the frame of the parent
     * @param anchor point that parent and child share, in the frame of the joint (3) [m]
     * @param axis unit vector in the frame of the joint
     * @param limits least and greatest angle or travel [1 or m], if there are any
     * @param effort largest torque or force that can hold the joint [N*m or N], 0 if the file
     *     states none
     * @param loads what acts along the axis besides the drives
     * @param drives the actions of the joint
     */
    record Joint(
            String name,
            String place,
            JointType type,
            String parent,
            String child,
            Pose pose,
            double[] anchor,
            double[] axis,
            Optional<double[]> limits,
            double effort,
            Loads loads,
            List<Drive> drives) {
        /** Returns whether the child cannot move. */
        boolean isRigid() {
            return type == JointType.FIXED
                    || limits.isPresent() && limits.get()[0] == limits.get()[1];
        }
    }
}
