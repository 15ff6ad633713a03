// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Mesh;
import reve.core.world.Shape;

import java.nio.FloatBuffer;
import java.nio.IntBuffer;

/**
 * Mass, centre of mass and inertia of a solid body of uniform density.
 *
 * @param volume [m^3]
 * @param mass [kg]
 * @param centre centre of mass in the axes of the shape (3) [m]
 * @param moments moments of inertia xx yy zz about axes through the centre of mass, parallel to the
 *     axes of the shape (3) [kg*m^2]
 * @param products products of inertia yz zx xy about the same axes (3) [kg*m^2]; all 0 for
 *     principal axes
 */
public record MassProperties(
        double volume, double mass, double[] centre, double[] moments, double[] products) {

    /**
     * Computes the properties of a solid with the given shape.
     *
     * @param density [kg/m^3], positive
     * @throws IllegalArgumentException if the shape encloses no volume. Such shapes are a plane, a
     *     mesh with an open edge (the message names the edge), and a mesh whose triangles do not
     *     all face outward
     */
    public static MassProperties of(Shape shape, double density) {
        return switch (shape) {
            case Shape.None none ->
                    throw new IllegalArgumentException("without a shape it has no volume");
            case Shape.Plane plane -> throw new IllegalArgumentException("a plane has no volume");
            case Shape.Sphere sphere -> sphere(sphere.radius(), density);
            case Shape.Box box -> box(box.x(), box.y(), box.z(), density);
            case Shape.Capsule round -> capsule(round.radius(), round.height(), density);
            case Shape.Cylinder round -> cylinder(round.radius(), round.height(), density);
            case Shape.Ellipsoid round -> ellipsoid(round.x(), round.y(), round.z(), density);
            case Mesh mesh -> mesh(mesh, density);
        };
    }

    private static MassProperties sphere(double radius, double density) {
        double volume = 4 * Math.PI / 3 * radius * radius * radius;
        double moment = 0.4 * volume * density * radius * radius;
        return new MassProperties(
                volume,
                volume * density,
                new double[3],
                new double[] {moment, moment, moment},
                new double[3]);
    }

    private static MassProperties box(double x, double y, double z, double density) {
        double mass = x * y * z * density;
        return new MassProperties(
                x * y * z,
                mass,
                new double[3],
                new double[] {
                    mass / 12 * (y * y + z * z),
                    mass / 12 * (z * z + x * x),
                    mass / 12 * (x * x + y * y)
                },
                new double[3]);
    }

    private static MassProperties ellipsoid(double x, double y, double z, double density) {
        double volume = Math.PI / 6 * x * y * z;
        double mass = volume * density;
        return new MassProperties(
                volume,
                mass,
                new double[3],
                new double[] {
                    mass / 20 * (y * y + z * z),
                    mass / 20 * (z * z + x * x),
                    mass / 20 * (x * x + y * y)
                },
                new double[3]);
    }

    private static MassProperties cylinder(double radius, double height, double density) {
        double volume = Math.PI * radius * radius * height;
        double mass = volume * density;
        double across = mass / 12 * (3 * radius * radius + height * height);
        return symmetric(volume, mass, across, mass / 2 * radius * radius);
    }

    /**
     * Adds up a cylinder and two hemispheres. The centres of mass of the hemispheres are 3/8 of the
     * radius beyond the ends of the cylinder.
     */
    private static MassProperties capsule(double radius, double height, double density) {
        double middle = height - 2 * radius;
        double ball = 4 * Math.PI / 3 * radius * radius * radius;
        double rod = Math.PI * radius * radius * middle;
        double square = radius * radius;
        double across =
                rod * (square / 4 + middle * middle / 12)
                        + ball * (0.4 * square + middle * middle / 4 + 3 * middle * radius / 8);
        double along = rod * square / 2 + ball * 0.4 * square;
        return symmetric(ball + rod, (ball + rod) * density, across * density, along * density);
    }

    /**
     * Returns the properties of a solid of revolution about the Y axis.
     *
     * @param across moment of inertia about X and Z [kg*m^2]
     * @param along moment of inertia about Y [kg*m^2]
     */
    private static MassProperties symmetric(
            double volume, double mass, double across, double along) {
        return new MassProperties(
                volume, mass, new double[3], new double[] {across, along, across}, new double[3]);
    }

    /**
     * Adds up the tetrahedra between one inner point and each triangle. A tetrahedron counts as
     * negative if the outer side of its triangle faces the point. The result is exact for
     * polyhedra. Source: F. Tonon, Explicit exact formulas for the 3-D tetrahedron inertia tensor,
     * J. Math. Stat. 1 (2005), 8-11.
     */
    private static MassProperties mesh(Mesh mesh, double density) {
        ClosedSurface.require(mesh);
        double[] inner = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            inner[axis] = 0.5 * (mesh.min(axis) + mesh.max(axis));
        }
        FloatBuffer vertices = mesh.vertices();
        IntBuffer triangles = mesh.triangles();
        double sixVolumes = 0;
        // The array {@code first} contains sums of the determinant times a coordinate. The next
        // array contains sums of the determinant times a product of two coordinates: xx yy zz yz zx
        // xy.
        double[] first = new double[3];
        double[] second = new double[6];
        double[][] corners = new double[3][3];
        while (triangles.hasRemaining()) {
            for (double[] corner : corners) {
                int at = 3 * triangles.get();
                for (int axis = 0; axis < 3; axis++) {
                    corner[axis] = vertices.get(at + axis) - inner[axis];
                }
            }
            double determinant = determinant(corners);
            sixVolumes += determinant;
            for (int axis = 0; axis < 3; axis++) {
                first[axis] += determinant * sum(corners, axis);
                int next = (axis + 1) % 3;
                int last = (axis + 2) % 3;
                second[axis] +=
                        determinant
                                * (product(corners, axis, axis)
                                        + sum(corners, axis) * sum(corners, axis));
                second[3 + axis] +=
                        determinant
                                * (product(corners, next, last)
                                        + sum(corners, next) * sum(corners, last));
            }
        }
        if (!(sixVolumes > 0)) {
            throw new IllegalArgumentException(
                    "the triangles of the mesh face inward, or enclose "
                            + "nothing; expected corners counter-clockwise seen from outside");
        }
        return aboutCentre(sixVolumes / 6, density, inner, first, second);
    }

    private static MassProperties aboutCentre(
            double volume, double density, double[] inner, double[] first, double[] second) {
        double[] centre = new double[3];
        // The array {@code spread} contains the mean products of two coordinates relative to the
        // centre of mass: xx yy zz yz zx xy.
        double[] spread = new double[6];
        for (int axis = 0; axis < 3; axis++) {
            centre[axis] = first[axis] / (24 * volume);
        }
        for (int axis = 0; axis < 3; axis++) {
            int next = (axis + 1) % 3;
            int last = (axis + 2) % 3;
            spread[axis] = second[axis] / (120 * volume) - centre[axis] * centre[axis];
            spread[3 + axis] = second[3 + axis] / (120 * volume) - centre[next] * centre[last];
        }
        double mass = volume * density;
        double[] moments = new double[3];
        double[] products = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            moments[axis] = mass * (spread[(axis + 1) % 3] + spread[(axis + 2) % 3]);
            products[axis] = -mass * spread[3 + axis];
        }
        for (int axis = 0; axis < 3; axis++) {
            centre[axis] += inner[axis];
        }
        return new MassProperties(volume, mass, centre, moments, products);
    }

    private static double determinant(double[][] m) {
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                + m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    }

    private static double sum(double[][] corners, int axis) {
        return corners[0][axis] + corners[1][axis] + corners[2][axis];
    }

    private static double product(double[][] corners, int i, int j) {
        return corners[0][i] * corners[0][j]
                + corners[1][i] * corners[1][j]
                + corners[2][i] * corners[2][j];
    }
}
