// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** The shape of a body around its origin, with lengths along its own axes [m]. Immutable. */
public sealed interface Shape
        permits Shape.None,
                Shape.Sphere,
                Shape.Box,
                Shape.Plane,
                Shape.Capsule,
                Shape.Cylinder,
                Shape.Ellipsoid,
                Mesh {

    /** Code of {@link None}. */
    int NONE = 0;

    /** Code of {@link Sphere}. */
    int SPHERE = 1;

    /** Code of {@link Box}. */
    int BOX = 2;

    /** Code of {@link Plane}. */
    int PLANE = 3;

    /** Code of {@link Mesh}. */
    int MESH = 4;

    /** Code of {@link Capsule}. */
    int CAPSULE = 5;

    /** Code of {@link Cylinder}. */
    int CYLINDER = 6;

    /** Code of {@link Ellipsoid}. */
    int ELLIPSOID = 7;

    /** Returns the value for the column {@code shape}. The codes never change their meaning. */
    int code();

    /** Returns the extent along an axis of the shape (0, 1, 2) [m]. */
    double size(int axis);

    /** Returns {@link None}, for a body without a shape. */
    static Shape none() {
        return None.INSTANCE;
    }

    /** Returns a sphere with this radius [m]. */
    static Shape sphere(double radius) {
        return new Sphere(radius);
    }

    /** Returns a box with these edges [m]. */
    static Shape box(double x, double y, double z) {
        return new Box(x, y, z);
    }

    /** Returns a rectangle in the plane of the x and z axes with these edges [m]. */
    static Shape plane(double x, double z) {
        return new Plane(x, z);
    }

    /** Returns a capsule with this radius and height [m]. */
    static Shape capsule(double radius, double height) {
        return new Capsule(radius, height);
    }

    /** Returns a cylinder with this radius and height [m]. */
    static Shape cylinder(double radius, double height) {
        return new Cylinder(radius, height);
    }

    /** Returns an ellipsoid with these extents [m]. */
    static Shape ellipsoid(double x, double y, double z) {
        return new Ellipsoid(x, y, z);
    }

    /** Returns a mesh, see {@link Mesh#Mesh}. */
    static Shape mesh(float[] vertices, int[] triangles) {
        return new Mesh(vertices, triangles);
    }

    /** A body without a shape. It is not drawn. */
    enum None implements Shape {
        /** The only instance. */
        INSTANCE;

        @Override
        public int code() {
            return NONE;
        }

        @Override
        public double size(int axis) {
            return 0;
        }
    }

    /**
     * A sphere centred on the origin.
     *
     * @param radius [m]
     */
    record Sphere(double radius) implements Shape {
        /** Checks the radius. */
        public Sphere {
            requireLength("radius of sphere", radius);
        }

        @Override
        public int code() {
            return SPHERE;
        }

        @Override
        public double size(int axis) {
            return 2 * radius;
        }
    }

    /** A box centred on the origin. */
    record Box(double x, double y, double z) implements Shape {
        /** Checks the edges. */
        public Box {
            requireLength("x size of box", x);
            requireLength("y size of box", y);
            requireLength("z size of box", z);
        }

        @Override
        public int code() {
            return BOX;
        }

        @Override
        public double size(int axis) {
            return axis == 0 ? x : axis == 1 ? y : z;
        }
    }

    /** A flat rectangle centred on the origin. Its normal is its own +Y axis. */
    record Plane(double x, double z) implements Shape {
        /** Checks the edges. */
        public Plane {
            requireLength("x size of plane", x);
            requireLength("z size of plane", z);
        }

        @Override
        public int code() {
            return PLANE;
        }

        @Override
        public double size(int axis) {
            return axis == 0 ? x : axis == 1 ? 0 : z;
        }
    }

    /**
     * A cylinder with a hemisphere at both ends, along its own Y axis and centred on the origin.
     *
     * @param radius [m]
     * @param height total height, at least twice the radius [m]
     */
    record Capsule(double radius, double height) implements Shape {
        /** Checks the lengths. */
        public Capsule {
            requireLength("radius of capsule", radius);
            requireLength("height of capsule", height);
            if (height < 2 * radius) {
                throw new IllegalArgumentException(
                        "height of capsule is "
                                + height
                                + ", expected at least twice the radius, "
                                + 2 * radius
                                + " m, because it includes both ends");
            }
        }

        @Override
        public int code() {
            return CAPSULE;
        }

        @Override
        public double size(int axis) {
            return axis == 1 ? height : 2 * radius;
        }
    }

    /**
     * A cylinder along its own Y axis, centred on the origin.
     *
     * @param radius [m]
     * @param height [m]
     */
    record Cylinder(double radius, double height) implements Shape {
        /** Checks the lengths. */
        public Cylinder {
            requireLength("radius of cylinder", radius);
            requireLength("height of cylinder", height);
        }

        @Override
        public int code() {
            return CYLINDER;
        }

        @Override
        public double size(int axis) {
            return axis == 1 ? height : 2 * radius;
        }
    }

    /** An ellipsoid centred on the origin, with its principal axes along its own axes. */
    record Ellipsoid(double x, double y, double z) implements Shape {
        /** Checks the extents. */
        public Ellipsoid {
            requireLength("x size of ellipsoid", x);
            requireLength("y size of ellipsoid", y);
            requireLength("z size of ellipsoid", z);
        }

        @Override
        public int code() {
            return ELLIPSOID;
        }

        @Override
        public double size(int axis) {
            return axis == 0 ? x : axis == 1 ? y : z;
        }
    }

    private static void requireLength(String what, double metres) {
        if (!(metres > 0 && metres <= 1e12)) {
            throw new IllegalArgumentException(
                    what + " is " + metres + ", expected a positive length of at most 1e12 m");
        }
    }
}
