// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * The motion of several bodies as a whole: mass, centre of mass, momentum, angular momentum and
 * kinetic energy. Immutable.
 */
public final class Motion {

    /** Moments of inertia below this fraction of the largest one count as 0. */
    private static final double NO_MOMENT = 1e-12;

    private final double mass;
    private final double[] centre;
    private final double[] momentum;
    private final double[] angularMomentum;
    private final double[] angularVelocity;
    private final double energy;
    private final double rigidEnergy;

    private Motion(List<Body> bodies) {
        double sum = 0;
        double[] first = new double[3];
        double[] total = new double[3];
        for (Body body : bodies) {
            sum += body.mass;
            for (int i = 0; i < 3; i++) {
                first[i] += body.mass * body.location[i];
                total[i] += body.mass * body.velocity[i];
            }
        }
        mass = sum;
        centre = scaled(first, 1 / sum);
        momentum = total;
        double[] velocity = velocity();
        double[] spin = new double[3];
        double[] inertia = new double[9];
        double kinetic = 0;
        for (Body body : bodies) {
            double[] arm = difference(body.location, centre);
            double[] own = body.momentOf(body.spin);
            add(spin, cross(arm, scaled(difference(body.velocity, velocity), body.mass)));
            add(spin, own);
            body.addInertia(arm, inertia);
            kinetic += (body.mass * dot(body.velocity, body.velocity) + dot(body.spin, own)) / 2;
        }
        angularMomentum = spin;
        angularVelocity = solve(inertia, spin);
        energy = kinetic;
        rigidEnergy = (sum * dot(velocity, velocity) + dot(spin, angularVelocity)) / 2;
    }

    /**
     * Returns the motion of those items that are bodies with a mass.
     *
     * @throws IllegalArgumentException if no item has a mass
     */
    public static Motion of(List<Item> items) {
        return ofBodies(items.stream().filter(Motion::isMovable).map(Body::of).toList());
    }

    /** Returns the motion of items that are not in the world yet. */
    static Motion ofDefinitions(List<ItemDefinition> items) {
        return ofBodies(
                items.stream().filter(item -> Level.massOf(item) > 0).map(Body::of).toList());
    }

    private static Motion ofBodies(List<Body> bodies) {
        if (bodies.isEmpty()) {
            throw new IllegalArgumentException("found no body with a mass, expected at least one");
        }
        return new Motion(bodies);
    }

    /** Returns whether an item is a body with a mass. */
    static boolean isMovable(Item item) {
        return item.kind().equals(WorldPrototype.BODY)
                && !item.physics().isEmpty()
                && item.physics().scalar(WorldPrototype.MASS) > 0;
    }

    /** Returns the mass [kg]. */
    public double mass() {
        return mass;
    }

    /** Returns the centre of mass (3) [m]. */
    public double[] centre() {
        return centre.clone();
    }

    /** Returns the momentum (3) [kg*m/s]. */
    public double[] momentum() {
        return momentum.clone();
    }

    /** Returns the velocity of the centre of mass (3) [m/s]. */
    public double[] velocity() {
        return scaled(momentum, 1 / mass);
    }

    /** Returns the angular momentum about the centre of mass (3) [kg*m^2/s]. */
    public double[] angularMomentum() {
        return angularMomentum.clone();
    }

    /**
     * Returns the angular velocity (3) [rad/s] of a rigid body with the same mass distribution and
     * angular momentum. It is 0 about an axis without a moment of inertia.
     */
    public double[] angularVelocity() {
        return angularVelocity.clone();
    }

    /** Returns the kinetic energy of all bodies [J]. */
    public double energy() {
        return energy;
    }

    /**
     * Returns the kinetic energy [J] that a rigid body with the same mass distribution, momentum
     * and angular momentum does not have.
     */
    public double vibration() {
        return Math.max(0, energy - rigidEnergy);
    }

    /**
     * Returns the velocity (3) [m/s] of a point of a rigid body with this motion.
     *
     * @param point location of the point (3) [m]
     */
    double[] velocityAt(double[] point, double[] spin) {
        double[] velocity = velocity();
        add(velocity, cross(spin, difference(point, centre)));
        return velocity;
    }

    /**
     * Returns the angular velocity that gives these bodies, as a rigid whole, an angular momentum.
     */
    static double[] spinFor(List<ItemDefinition> items, double[] angularMomentum) {
        double[] inertia = new double[9];
        Motion rest = ofDefinitions(items);
        for (ItemDefinition item : items) {
            if (Level.massOf(item) > 0) {
                Body body = Body.of(item);
                body.addInertia(difference(body.location, rest.centre), inertia);
            }
        }
        return solve(inertia, angularMomentum);
    }

    /**
     * Returns the rotation (unit quaternion xyzw) from a rigid arrangement of bodies to their
     * present one that minimises the mean square distance of all mass points. This is the method of
     * B. K. P. Horn, J. Opt. Soc. Am. A 4, 629 (1987), in which each body counts with its second
     * moments.
     *
     * @param rest the rigid arrangement; the bodies with a mass are in the order of {@code now}
     * @param now items whose order agrees with that of {@code rest}
     */
    static double[] rotation(List<ItemDefinition> rest, List<Item> now) {
        Motion before = ofDefinitions(rest);
        Motion after = of(now);
        double[] s = new double[9];
        for (int i = 0; i < rest.size(); i++) {
            if (!(Level.massOf(rest.get(i)) > 0)) {
                continue;
            }
            Body from = Body.of(rest.get(i));
            Body to = Body.of(now.get(i));
            double[] a = difference(from.location, before.centre);
            double[] b = difference(to.location, after.centre);
            double[] second = to.secondMoments();
            for (int row = 0; row < 3; row++) {
                for (int column = 0; column < 3; column++) {
                    double own = 0;
                    for (int k = 0; k < 3; k++) {
                        own += from.axes[3 * row + k] * second[k] * to.axes[3 * column + k];
                    }
                    s[3 * row + column] += to.mass * a[row] * b[column] + own;
                }
            }
        }
        double[] n = {
            s[0] + s[4] + s[8],
            s[5] - s[7],
            s[6] - s[2],
            s[1] - s[3],
            s[5] - s[7],
            s[0] - s[4] - s[8],
            s[1] + s[3],
            s[6] + s[2],
            s[6] - s[2],
            s[1] + s[3],
            s[4] - s[0] - s[8],
            s[5] + s[7],
            s[1] - s[3],
            s[6] + s[2],
            s[5] + s[7],
            s[8] - s[0] - s[4]
        };
        double[] vectors = SymmetricEigen.diagonalise(n, 4);
        int best = 0;
        for (int k = 1; k < 4; k++) {
            if (n[5 * k] > n[5 * best]) {
                best = k;
            }
        }
        double sign = vectors[best] < 0 ? -1 : 1;
        return new double[] {
            sign * vectors[4 + best],
            sign * vectors[8 + best],
            sign * vectors[12 + best],
            sign * vectors[best]
        };
    }

    /**
     * Returns the angular velocity of a body with this angular momentum.
     *
     * @param inertia principal moments (3) [kg*m^2]
     * @param orientation unit quaternion xyzw (4)
     */
    static double[] spinOf(double[] inertia, double[] orientation, double[] angularMomentum) {
        double[] axes = axes(orientation);
        double[] spin = new double[3];
        for (int k = 0; k < 3; k++) {
            double along = 0;
            for (int i = 0; i < 3; i++) {
                along += axes[3 * i + k] * angularMomentum[i];
            }
            for (int i = 0; i < 3 && inertia[k] > 0; i++) {
                spin[i] += axes[3 * i + k] * along / inertia[k];
            }
        }
        return spin;
    }

    /** Solves inertia * spin = angular momentum. Axes without a moment of inertia get no spin. */
    private static double[] solve(double[] inertia, double[] angularMomentum) {
        double[] moments = inertia.clone();
        double[] vectors = SymmetricEigen.diagonalise(moments, 3);
        double largest = Math.max(moments[0], Math.max(moments[4], moments[8]));
        double[] spin = new double[3];
        for (int k = 0; k < 3; k++) {
            double moment = moments[4 * k];
            if (moment > NO_MOMENT * largest) {
                double along = 0;
                for (int i = 0; i < 3; i++) {
                    along += vectors[3 * i + k] * angularMomentum[i];
                }
                for (int i = 0; i < 3; i++) {
                    spin[i] += vectors[3 * i + k] * along / moment;
                }
            }
        }
        return spin;
    }

    /** The rotation matrix (3 x 3, row by row) of a unit quaternion xyzw. */
    private static double[] axes(double[] q) {
        double x = q[0];
        double y = q[1];
        double z = q[2];
        double w = q[3];
        return new double[] {
            1 - 2 * (y * y + z * z),
            2 * (x * y - w * z),
            2 * (x * z + w * y),
            2 * (x * y + w * z),
            1 - 2 * (x * x + z * z),
            2 * (y * z - w * x),
            2 * (x * z - w * y),
            2 * (y * z + w * x),
            1 - 2 * (x * x + y * y)
        };
    }

    /**
     * One body.
     *
     * @param axes rotation matrix (3 x 3, row by row) from the body's own axes
     * @param spin angular velocity (3) [rad/s]
     * @param inertia principal moments along the body's own axes (3) [kg*m^2]
     */
    private record Body(
            double mass,
            double[] location,
            double[] axes,
            double[] velocity,
            double[] spin,
            double[] inertia) {

        static Body of(Item item) {
            return new Body(
                    item.physics().scalar(WorldPrototype.MASS),
                    item.physical().location(),
                    Motion.axes(item.physical().orientation()),
                    item.physics().vector("velocity"),
                    item.physics().vector("angularVelocity"),
                    item.physics().vector("inertia"));
        }

        static Body of(ItemDefinition item) {
            return new Body(
                    Level.massOf(item),
                    item.location(),
                    Motion.axes(item.orientation()),
                    item.physics("velocity").orElseGet(() -> new double[3]),
                    item.physics("angularVelocity").orElseGet(() -> new double[3]),
                    item.physics("inertia").orElseGet(() -> new double[3]));
        }

        /** Returns the product of the inertia and a vector of the world's axes. */
        double[] momentOf(double[] vector) {
            double[] product = new double[3];
            for (int k = 0; k < 3; k++) {
                double along = 0;
                for (int i = 0; i < 3; i++) {
                    along += axes[3 * i + k] * vector[i];
                }
                for (int i = 0; i < 3; i++) {
                    product[i] += axes[3 * i + k] * along * inertia[k];
                }
            }
            return product;
        }

        /** Adds the inertia about a point to a matrix. */
        void addInertia(double[] arm, double[] matrix) {
            double square = dot(arm, arm);
            for (int i = 0; i < 3; i++) {
                for (int j = 0; j < 3; j++) {
                    double own = 0;
                    for (int k = 0; k < 3; k++) {
                        own += axes[3 * i + k] * inertia[k] * axes[3 * j + k];
                    }
                    matrix[3 * i + j] += own + mass * ((i == j ? square : 0) - arm[i] * arm[j]);
                }
            }
        }

        /** Returns the integrals of the squared coordinates over the mass (3) [kg*m^2]. */
        double[] secondMoments() {
            double half = (inertia[0] + inertia[1] + inertia[2]) / 2;
            return new double[] {half - inertia[0], half - inertia[1], half - inertia[2]};
        }
    }

    private static double dot(double[] a, double[] b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }

    private static double[] difference(double[] a, double[] b) {
        return new double[] {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    }

    private static double[] scaled(double[] vector, double factor) {
        return new double[] {vector[0] * factor, vector[1] * factor, vector[2] * factor};
    }

    private static void add(double[] sum, double[] more) {
        for (int i = 0; i < 3; i++) {
            sum[i] += more[i];
        }
    }
}
