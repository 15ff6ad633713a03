// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** The shape of a body around its origin, in metres along its own axes. Immutable. */
public sealed interface Shape permits Shape.None, Shape.Sphere, Shape.Box, Shape.Plane, Mesh {

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

    /** Returns the value in the column {@code shape}; the codes never change their meaning. */
    int code();

    /** Returns the extent along an own axis (0, 1, 2) [m]. */
    double size(int axis);

    /** Returns the shape of a body without one. */
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

    /** Returns a rectangle in x and z with these edges [m]. */
    static Shape plane(double x, double z) {
        return new Plane(x, z);
    }

    /** See {@link Mesh#Mesh}. */
    static Shape mesh(float[] vertices, int[] triangles) {
        return new Mesh(vertices, triangles);
    }

    /** A body without a shape; it is not drawn. */
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

    /** A flat rectangle centred on the origin; its normal is its own +Y axis. */
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

    private static void requireLength(String what, double metres) {
        if (!(metres > 0 && metres <= 1e12)) {
            throw new IllegalArgumentException(
                    what + " is " + metres + ", expected a positive length of at most 1e12 m");
        }
    }
}
