// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.MassProperties;
import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.PropertyDescriptor;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;

import java.util.Arrays;
import java.util.List;
import java.util.Locale;

/**
 * Reader of the density of a body, from the key {@code density} or from its substance. From density
 * and shape, it computes the mass and inertia of a body, and the property {@code radius} of a
 * sphere.
 */
final class DensityReader {
    private static final Unit DENSITY = Unit.parse("kg/m^3");

    /**
     * Tolerance of the check of the centre of mass and of the principal axes. The centre of mass
     * may differ from the origin by this fraction of the extent. Products of inertia may be this
     * fraction of the moments.
     */
    private static final double TOLERANCE = 1e-3;

    private final WorldPrototype prototype;
    private final PhysicsReader physics;
    private final Problems problems;

    DensityReader(WorldPrototype prototype, PhysicsReader physics, Problems problems) {
        this.prototype = prototype;
        this.physics = physics;
        this.problems = problems;
    }

    /**
     * Reads a density.
     *
     * @param item definition with the shape; receives the computed properties
     */
    void read(Node density, Node aspect, ItemDefinition.Builder item) {
        for (String given : List.of("mass", "inertia")) {
            if (aspect.get(given).isPresent()) {
                problems.addAtKey(
                        density,
                        "density: `"
                                + given
                                + "` is given too, which follows "
                                + "from density and shape; say one of them");
                return;
            }
        }
        new Quantities(problems)
                .number(density, DENSITY)
                .ifPresent(
                        value -> {
                            try {
                                requirePositive(value);
                                compute(density, value, aspect, item);
                            } catch (IllegalArgumentException refused) {
                                problems.add(density, "density: " + refused.getMessage());
                            }
                        });
    }

    /**
     * Computes mass and inertia from the density of a substance. The aspect may state the inertia.
     * A plane or terrain gets the mass 0, because it has no volume, and is therefore immovable.
     *
     * @param name node with the name of the substance
     * @param item like in {@link #read}
     */
    void read(Node name, Substances.Substance substance, Node aspect, ItemDefinition.Builder item) {
        if (isSurface(item.build().shape())) {
            return; // the mass is 0, as in each new row
        }
        if (substance.density().isEmpty()) {
            problems.add(
                    name,
                    name.label()
                            + ": the substance `"
                            + substance.name()
                            + "` has no density; state it under `substances`, or state the"
                            + " `mass` of this item");
            return;
        }
        try {
            compute(name, substance.density().getAsDouble(), aspect, item);
        } catch (IllegalArgumentException refused) {
            problems.add(
                    name,
                    name.label()
                            + ": no mass follows from the density of "
                            + substance.name()
                            + ": "
                            + refused.getMessage()
                            + "; or state the `mass`, which is 0 for an immovable body");
        }
    }

    private static boolean isSurface(Shape shape) {
        return shape instanceof Shape.Plane
                || shape instanceof Mesh mesh && mesh.relief().isPresent();
    }

    private void compute(Node node, double density, Node aspect, ItemDefinition.Builder item) {
        Shape shape = item.build().shape();
        MassProperties solid = MassProperties.of(shape, density);
        requireOwnAxes(shape, solid);
        set(node, item, "mass", solid.mass());
        if (aspect.get("inertia").isEmpty()) {
            set(node, item, "inertia", solid.moments());
        }
        if (shape instanceof Shape.Sphere sphere && aspect.get("radius").isEmpty()) {
            set(node, item, "radius", sphere.radius());
        }
    }

    private void set(Node node, ItemDefinition.Builder item, String name, double... values) {
        PropertyDescriptor property = prototype.find(WorldPrototype.BODY, name).orElseThrow();
        if (physics.fits(node, property, values)) {
            item.physics(name, values);
        }
    }

    private static void requirePositive(double density) {
        if (!(density > 0)) {
            throw new IllegalArgumentException(density + ", expected a positive one");
        }
    }

    /**
     * Refuses a shape whose centre of mass is not its origin, or whose principal axes are not its
     * own axes. The reason is that laws read only three moments of inertia, about the shape's own
     * axes.
     */
    private static void requireOwnAxes(Shape shape, MassProperties solid) {
        double extent = Math.max(shape.size(0), Math.max(shape.size(1), shape.size(2)));
        double moment = Arrays.stream(solid.moments()).max().orElseThrow();
        for (int axis = 0; axis < 3; axis++) {
            if (Math.abs(solid.centre()[axis]) > TOLERANCE * extent) {
                throw new IllegalArgumentException(
                        "the centre of mass is at "
                                + text(solid.centre())
                                + " m, expected the item's origin; move the "
                                + "mesh in its file by the opposite of that");
            }
            if (Math.abs(solid.products()[axis]) > TOLERANCE * moment) {
                throw new IllegalArgumentException(
                        "the products of inertia yz zx xy are "
                                + text(solid.products())
                                + " kg*m^2 beside moments of "
                                + text(solid.moments())
                                + ", expected 0; turn the mesh in its file until "
                                + "its principal axes are x, y and z");
            }
        }
    }

    private static String text(double[] values) {
        return String.format(Locale.ROOT, "(%.4g %.4g %.4g)", values[0], values[1], values[2]);
    }
}
