// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import reve.core.world.Column;
import reve.core.world.FrameControl;
import reve.core.world.Instrument;
import reve.core.world.ItemId;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.SortedSet;
import java.util.function.Supplier;

/**
 * Computes the columns {@link WorldPrototype#SPECIFIC_FORCE} and {@link
 * WorldPrototype#ANGULAR_RATE} of bodies with an {@link Instrument.Imu}. The specific force is the
 * change of velocity during the phase PHYSICS divided by the length of the frame, minus the mean of
 * the gravitational acceleration before and after the phase. The specific force is given in the
 * axes that the body has in the middle of the frame. Velocities that acts and edits set do not
 * count as acceleration.
 *
 * <p>A body that is attached to other bodies moves rigidly with the outermost of them.
 *
 * <p>The cost is proportional to the number of bodies with an IMU. Laws of gravitation between
 * bodies increase the cost: it is then proportional to this number times the number of all bodies.
 * For the world's thread only.
 */
public final class InertialMeasurements {

    /**
     * The gravity that laws exert.
     *
     * @param uniform true for the world's constant {@code gravity}
     * @param mutual true for gravitation between bodies, with the constants {@code
     *     gravitationalConstant} and {@code softening}
     */
    public record Gravity(boolean uniform, boolean mutual) {
        private static final Gravity NONE = new Gravity(false, false);
    }

    /**
     * Maximum number of pairs of a sensor and a body for which gravitation between bodies is
     * computed, before and after the phase. The computation takes about 10 ms.
     */
    static final int MOST_PAIRS = 500_000;

    /** Numbers of each body in {@link #before}: velocity, gravity, orientation. */
    private static final int NUMBERS = 10;

    private final Supplier<Gravity> acting;
    private final double[] velocity = new double[3];
    private final double[] turning = new double[3];
    private final double[] gravity = new double[3];
    private double[] before = {};
    private int count;
    private boolean reported;

    /**
     * @param acting returns the gravity that the loaded laws exert now
     */
    public InertialMeasurements(Supplier<Gravity> acting) {
        this.acting = acting;
    }

    /** Makes the next frame with too many sensors report them. Called after a restore. */
    public void forget() {
        reported = false;
    }

    /** Records velocities and orientations before the laws of a frame act. */
    public void begin(World world) {
        SortedSet<ItemId> items = FrameControl.of(world).withImu();
        count = items.size();
        if (count == 0) {
            return;
        }
        if (before.length < NUMBERS * count) {
            before = new double[2 * NUMBERS * count];
        }
        Gravity gravities = acting.get();
        Table bodies = world.table(WorldPrototype.BODY);
        Column orientation = bodies.column("orientation");
        int end = NUMBERS * most(bodies, gravities);
        int at = 0;
        for (ItemId item : items) {
            if (at >= end) {
                return;
            }
            int row = bodies.rowOf(item);
            int carrier = carrier(world, bodies, item);
            readMotion(bodies, row, carrier);
            readGravity(world, bodies, row, carrier, gravities);
            System.arraycopy(velocity, 0, before, at, 3);
            System.arraycopy(gravity, 0, before, at + 3, 3);
            for (int i = 0; i < 4; i++) {
                before[at + 6 + i] = orientation.getDouble(row, i);
            }
            at += NUMBERS;
        }
    }

    /**
     * Computes the columns after the laws have acted and the places of attached items are known.
     * Does nothing if no laws have acted since the last call, for example after a rewind. If there
     * are too many sensors for the gravitation between the bodies, the specific force of those with
     * the greatest ids is 0, and a fault is raised once.
     *
     * @param seconds length of the frame [s]
     */
    public void derive(World world, long frame, double seconds) {
        if (count == 0) {
            return;
        }
        FrameControl control = FrameControl.of(world);
        Gravity gravities = acting.get();
        Table bodies = world.table(WorldPrototype.BODY);
        Column orientation = bodies.column("orientation");
        double[] now = new double[4];
        double[] middle = new double[4];
        int end = NUMBERS * most(bodies, gravities);
        int at = 0;
        for (ItemId item : control.withImu()) {
            int row = bodies.rowOf(item);
            int carrier = carrier(world, bodies, item);
            readMotion(bodies, row, carrier);
            for (int i = 0; i < 4; i++) {
                now[i] = orientation.getDouble(row, i);
            }
            if (at >= end) {
                turnBack(now, turning);
                control.derive(WorldPrototype.SPECIFIC_FORCE, row, 0, 0, 0);
                control.derive(
                        WorldPrototype.ANGULAR_RATE, row, turning[0], turning[1], turning[2]);
                continue;
            }
            readGravity(world, bodies, row, carrier, gravities);
            putBetween(before, at + 6, now, middle);
            for (int i = 0; i < 3; i++) {
                velocity[i] =
                        (velocity[i] - before[at + i]) / seconds
                                - 0.5 * (gravity[i] + before[at + 3 + i]);
            }
            turnBack(middle, velocity);
            turnBack(now, turning);
            control.derive(
                    WorldPrototype.SPECIFIC_FORCE, row, velocity[0], velocity[1], velocity[2]);
            control.derive(WorldPrototype.ANGULAR_RATE, row, turning[0], turning[1], turning[2]);
            at += NUMBERS;
        }
        if (at < NUMBERS * count && !reported) {
            reported = true;
            report(world, frame, at / NUMBERS, bodies.physicsRowCount());
        }
        count = 0;
    }

    /** Returns for how many sensors the specific force is computed. */
    private int most(Table bodies, Gravity gravities) {
        return gravities.mutual
                ? Math.min(count, Math.max(1, MOST_PAIRS / Math.max(1, bodies.physicsRowCount())))
                : count;
    }

    private void report(World world, long frame, int measured, int bodies) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("phase", "DERIVE");
        fields.put("source", "inertial measurements");
        fields.put("error", "TooManySensors");
        fields.put(
                "message",
                String.format(
                        Locale.ROOT,
                        "%,d items have an `imu`, and a law of gravitation acts on %,d bodies:"
                                + " expected at most %,d sensors times bodies. The specific force"
                                + " of %,d items is measured, the others measure 0 (reported once)",
                        count,
                        bodies,
                        MOST_PAIRS,
                        measured));
        world.raise(new WorldEvent(frame, "fault", fields));
    }

    /**
     * Returns the row of the outermost body that carries an item. Returns the row of the item
     * itself if no body carries it.
     */
    private static int carrier(World world, Table bodies, ItemId item) {
        ItemId outermost = item;
        for (Optional<ItemId> parent = world.item(item).parent();
                parent.isPresent();
                parent = world.item(outermost).parent()) {
            outermost = parent.get();
        }
        return bodies.rowOf(outermost);
    }

    /** Reads the velocity [m/s] and angular velocity [rad/s] of a body, in the world's axes. */
    private void readMotion(Table bodies, int row, int carrier) {
        Arrays.fill(velocity, 0);
        Arrays.fill(turning, 0);
        if (carrier >= bodies.physicsRowCount()) {
            return; // scenery has no measurements
        }
        boolean movable = bodies.column("mass").getDouble(carrier, 0) > 0;
        if (movable) {
            read(bodies.column("velocity"), carrier, velocity);
        }
        if (movable || !isZero(bodies.column("inertia"), carrier)) {
            read(bodies.column("angularVelocity"), carrier, turning);
        }
        if (row != carrier) {
            Column position = bodies.column("position");
            double x = position.getDouble(row, 0) - position.getDouble(carrier, 0);
            double y = position.getDouble(row, 1) - position.getDouble(carrier, 1);
            double z = position.getDouble(row, 2) - position.getDouble(carrier, 2);
            velocity[0] += turning[1] * z - turning[2] * y;
            velocity[1] += turning[2] * x - turning[0] * z;
            velocity[2] += turning[0] * y - turning[1] * x;
        }
    }

    /** Computes the acceleration of gravity at a body [m/s²], in the world's axes. */
    private void readGravity(World world, Table bodies, int row, int carrier, Gravity gravities) {
        Arrays.fill(gravity, 0);
        if (gravities.equals(Gravity.NONE)) {
            return;
        }
        Table constants = world.table(WorldPrototype.WORLD);
        if (gravities.uniform) {
            read(constants.column("gravity"), 0, gravity);
        }
        if (gravities.mutual) {
            double constant = constants.column("gravitationalConstant").getDouble(0, 0);
            double softening = constants.column("softening").getDouble(0, 0);
            addGravitation(bodies, row, carrier, constant, softening * softening);
        }
    }

    /**
     * Adds the acceleration by gravitation between bodies, G Σ m r / (r² + ε²)^(3/2), where r is
     * the vector to the other body. A body does not attract the items that it carries.
     */
    private void addGravitation(
            Table bodies, int row, int carrier, double constant, double softeningSquared) {
        Column masses = bodies.column("mass");
        Column positions = bodies.column("position");
        double x = positions.getDouble(row, 0);
        double y = positions.getDouble(row, 1);
        double z = positions.getDouble(row, 2);
        for (int other = 0; other < bodies.physicsRowCount(); other++) {
            double mass = masses.getDouble(other, 0);
            if (other == carrier || other == row || mass == 0) {
                continue;
            }
            double dx = positions.getDouble(other, 0) - x;
            double dy = positions.getDouble(other, 1) - y;
            double dz = positions.getDouble(other, 2) - z;
            double squared = dx * dx + dy * dy + dz * dz;
            if (squared == 0) {
                continue;
            }
            double softened = squared + softeningSquared;
            double factor = constant * mass / (softened * Math.sqrt(softened));
            gravity[0] += factor * dx;
            gravity[1] += factor * dy;
            gravity[2] += factor * dz;
        }
    }

    private static void read(Column column, int row, double[] into) {
        for (int i = 0; i < into.length; i++) {
            into[i] = column.getDouble(row, i);
        }
    }

    private static boolean isZero(Column column, int row) {
        return column.getDouble(row, 0) == 0
                && column.getDouble(row, 1) == 0
                && column.getDouble(row, 2) == 0;
    }

    /** Computes the rotation half-way between two rotations, as a unit quaternion. */
    private static void putBetween(double[] from, int at, double[] to, double[] between) {
        double cosine = 0;
        for (int i = 0; i < 4; i++) {
            cosine += from[at + i] * to[i];
        }
        double length = 0;
        for (int i = 0; i < 4; i++) {
            between[i] = to[i] + (cosine < 0 ? -from[at + i] : from[at + i]);
            length += between[i] * between[i];
        }
        for (int i = 0; i < 4; i++) {
            between[i] /= Math.sqrt(length);
        }
    }

    /** Converts a vector from the world's axes to those of a body with this orientation. */
    private static void turnBack(double[] orientation, double[] vector) {
        double ux = -orientation[0];
        double uy = -orientation[1];
        double uz = -orientation[2];
        double w = orientation[3];
        double cx = 2 * (uy * vector[2] - uz * vector[1]);
        double cy = 2 * (uz * vector[0] - ux * vector[2]);
        double cz = 2 * (ux * vector[1] - uy * vector[0]);
        vector[0] += w * cx + (uy * cz - uz * cy);
        vector[1] += w * cy + (uz * cx - ux * cz);
        vector[2] += w * cz + (ux * cy - uy * cx);
    }
}
