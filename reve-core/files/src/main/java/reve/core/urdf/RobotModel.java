// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.world.Pose;

import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * A robot as a file describes it: a tree of links (rigid bodies) and joints. The axes are those of
 * the file, usually with +Z up.
 *
 * @param links links by name, in the order of the file
 * @param root name of the link that is the child of no joint
 * @param couplings couplings of two joints, in the order of the file
 * @param scene the world around the robot, which only an MJCF file describes
 * @param ignored one line for each kind of element or attribute that the reader ignores
 */
record RobotModel(
        String name,
        Map<String, Link> links,
        List<Joint> joints,
        String root,
        List<Coupling> couplings,
        Optional<Scene> scene,
        List<String> ignored) {

    /**
     * A coupling of two joints: the angle or travel of the first one is {@code ratio} times that of
     * the second one, plus {@code offset}.
     *
     * @param first name of the joint that follows
     * @param second name of the joint that it follows
     * @param offset [unit of the first joint: 1 or m]
     */
    record Coupling(String first, String second, double ratio, double offset) {}

    /**
     * The world around a robot.
     *
     * @param gravity (3) [m/s^2]
     * @param step duration of a physics step [s]
     * @param scenery immovable shapes that collide
     */
    record Scene(double[] gravity, double step, List<Scenery> scenery) {
        /**
         * Returns the contact properties of the scenery. They are the defaults of MJCF if there is
         * no scenery.
         */
        Surface surface() {
            return scenery.isEmpty() ? Surface.DEFAULT : scenery.getFirst().surface();
        }
    }

    /** An immovable shape that collides. Its pose is in the frame of the root link. */
    record Scenery(String name, Geometry geometry, Surface surface) {}

    /**
     * Properties that determine how shapes collide. Two shapes collide if the type of one shape and
     * the affinity of the other have a common bit.
     *
     * @param friction coefficient of sliding friction [1]
     * @param spinning lever arm of the torque against spin about the contact normal [m]
     * @param rolling lever arm of the torque against rolling [m]
     */
    record Surface(int type, int affinity, double friction, double spinning, double rolling) {
        /** The values of a geom of MJCF that states none. */
        static final Surface DEFAULT = new Surface(1, 1, 1, 0, 0);

        boolean touches(Surface other) {
            return (type & other.affinity) != 0 || (other.type & affinity) != 0;
        }
    }

    /**
     * A rigid body and its shapes. The poses of the shapes are in the frame of the link.
     *
     * @param surface properties of the shapes that collide, if the file states them
     */
    record Link(
            String name,
            String place,
            Optional<Inertial> inertial,
            List<Geometry> looks,
            List<Geometry> collisions,
            Optional<Surface> surface) {}

    /**
     * Mass and inertia of a link.
     *
     * @param pose centre of mass and axes of the inertia
     * @param mass [kg]
     * @param inertia xx yy zz yz zx xy about these axes [kg*m^2]
     */
    record Inertial(Pose pose, double mass, double[] inertia) {}

    /**
     * A shape of a link.
     *
     * @param colour colour as #rrggbb or #rrggbbaa
     */
    record Geometry(String place, Pose pose, Form form, Optional<String> colour) {}

    /** A shape about the origin of its geometry. */
    sealed interface Form {
        /**
         * A box.
         *
         * @param size lengths of the edges (3) [m]
         */
        record Box(double[] size) implements Form {}

        /**
         * A ball.
         *
         * @param radius [m]
         */
        record Sphere(double radius) implements Form {}

        /**
         * An ellipsoid.
         *
         * @param size extents along its principal axes (3) [m]
         */
        record Ellipsoid(double[] size) implements Form {}

        /**
         * A cylinder along Z.
         *
         * @param radius [m]
         * @param length [m]
         */
        record Cylinder(double radius, double length) implements Form {}

        /**
         * A cylinder along Z with a hemisphere at both ends.
         *
         * @param radius [m]
         * @param length total length [m]
         */
        record Capsule(double radius, double length) implements Form {}

        /**
         * A rectangle whose normal is +Z.
         *
         * @param x length of the edges along X [m]
         * @param y length of the edges along Y [m]
         */
        record Plane(double x, double y) implements Form {}

        /**
         * A terrain in the X-Y plane, which faces +Z.
         *
         * @param name name of the file that the terrain gets, without a folder and an ending
         * @param x extent along X [m]
         * @param y extent along Y [m]
         * @param rows heights [m]; the first row is at the edge +Y, and begins at -X
         */
        record Terrain(String name, double x, double y, float[][] rows) implements Form {}

        /**
         * A mesh in a file.
         *
         * @param name name of the file, in the form that the robot's file contains
         * @param scale factors of the three axes
         */
        record MeshFile(String name, double[] scale) implements Form {}
    }

    /** The motion of a joint's child relative to the parent. */
    enum JointType {
        REVOLUTE,
        CONTINUOUS,
        PRISMATIC,
        FIXED,
        FLOATING,
        PLANAR,
        BALL
    }

    /** The quantity that an action of a joint sets. */
    enum DriveKind {
        /** The speed of the joint. A motor accelerates the joint to this speed. */
        SPEED,
        /** The torque or force that acts on the joint. */
        LOAD,
        /** The angle or travel of the joint. A servo moves the joint to this place. */
        PLACE
    }

    /**
     * An action that drives a joint.
     *
     * @param range minimum and maximum of the quantity that the action sets; infinite without a
     *     limit
     * @param most maximum torque or force [N*m or N]; 0 without a limit
     * @param stiffness stiffness of a servo [N*m or N/m]; 0 for other kinds
     * @param damping damping of a servo, or torque or force per difference of the speed from the
     *     speed that the action sets [N*m*s or N*s/m]; 0 without damping
     * @param actuator name of the actuator in the file; empty if the action belongs to the joint
     *     itself
     */
    record Drive(
            DriveKind kind,
            double[] range,
            double most,
            double stiffness,
            double damping,
            String actuator) {
        /**
         * Returns a drive that sets a speed.
         *
         * @param speed maximum speed; 0 for any speed
         */
        static Drive ofSpeed(double speed, double most) {
            double bound = speed > 0 ? speed : Double.POSITIVE_INFINITY;
            return new Drive(DriveKind.SPEED, new double[] {-bound, bound}, most, 0, 0, "");
        }
    }

    /**
     * The loads that act along the axis of a hinge or slider. A ball joint has only damping.
     *
     * @param damping torque or force per speed [N*m*s or N*s/m]
     * @param friction dry friction [N*m or N]
     * @param stiffness stiffness of the spring [N*m or N/m]
     * @param rest angle or travel at which the spring exerts no torque or force [1 or m]
     * @param rotor inertia that the joint adds [kg*m^2 or kg]
     */
    record Loads(double damping, double friction, double stiffness, double rest, double rotor) {
        static final Loads NONE = new Loads(0, 0, 0, 0, 0);
    }

    /**
     * A joint between two links.
     *
     * @param pose pose of the joint in the frame of the parent; also the pose of the child at the
     *     angle 0
     * @param anchor point that parent and child share, in the frame of the joint (3) [m]
     * @param axis unit vector in the frame of the joint
     * @param limits minimum and maximum of angle or travel [1 or m], if there are any
     * @param effort maximum torque or force that can hold the joint [N*m or N]; 0 if the file
     *     states none
     * @param loads loads that act along the axis in addition to the drives
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
        /** Returns whether the child cannot move relative to the parent. */
        boolean isRigid() {
            return type == JointType.FIXED
                    || limits.isPresent() && limits.get()[0] == limits.get()[1];
        }
    }
}
