// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;
import reve.core.world.Instrument;
import reve.core.world.Instrument.Errors;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.function.Supplier;

/** Reader of the keys of a sensor that measures numbers. */
final class InstrumentReader {
    static final String IMU = "imu";
    static final String LIDAR = "lidar";
    static final String CONTACT_FORCE = "contactForce";
    static final String OWN_AXES = "body";
    private static final List<String> KEYS =
            List.of(IMU, LIDAR, CONTACT_FORCE, ProviderReader.JAVA);

    private static final Unit ACCELERATION = Unit.parse("m/s^2");
    private static final Unit METRE = Unit.parse("m");
    private static final Unit ANGULAR_VELOCITY = Unit.parse("rad/s");
    private static final Instrument PLAIN_IMU = new Instrument.Imu(Errors.NONE, Errors.NONE, 0);

    private final Problems problems;
    private final Quantities quantities;
    private final ProviderReader providers;

    InstrumentReader(Problems problems, Quantities quantities) {
        this.problems = problems;
        this.quantities = quantities;
        this.providers = new ProviderReader(problems);
    }

    /** Returns the key of a sensor's instrument; empty if the sensor has no instrument. */
    static Optional<String> key(Node sensor) {
        return KEYS.stream().filter(key -> sensor.get(key).isPresent()).findFirst();
    }

    /** Returns the properties of bodies into which the world writes what a sensor measures. */
    static List<String> measured(Node sensor) {
        if (!sensor.isMapping()) {
            return List.of();
        }
        List<String> properties = new ArrayList<>();
        if (sensor.get(IMU).isPresent()) {
            properties.addAll(WorldPrototype.measuredBy(PLAIN_IMU));
        }
        if (sensor.get(CONTACT_FORCE).isPresent()) {
            properties.addAll(WorldPrototype.measuredBy(new Instrument.ContactForce(false)));
        }
        return properties;
    }

    /** Reads an instrument. Records a problem and returns empty if it is invalid. */
    Optional<Instrument> read(Node node) {
        return switch (node.key()) {
            case LIDAR -> readLidar(node);
            case CONTACT_FORCE -> Optional.of(new Instrument.ContactForce(isOwn(node)));
            case ProviderReader.JAVA ->
                    providers
                            .sensor(node)
                            .flatMap(
                                    provider ->
                                            checked(node, () -> Instrument.Provided.by(provider)));
            default -> readImu(node);
        };
    }

    private static boolean isOwn(Node contact) {
        return contact.get("axes").flatMap(Node::text).equals(Optional.of(OWN_AXES));
    }

    private Optional<Instrument> readImu(Node node) {
        Optional<Errors> force = errors(node, "specificForce", ACCELERATION);
        Optional<Errors> turning = errors(node, "angularVelocity", ANGULAR_VELOCITY);
        return force.isEmpty() || turning.isEmpty()
                ? Optional.empty()
                : checked(node, () -> new Instrument.Imu(force.get(), turning.get(), seed(node)));
    }

    private Optional<Instrument> readLidar(Node node) {
        Optional<Double> angle = number(node, "angle", Unit.ONE);
        Optional<Double> rowAngle = number(node, "rowAngle", Unit.ONE);
        Optional<Double> range =
                node.get("range").flatMap(given -> quantities.number(given, METRE));
        Optional<Double> noise = number(node, "noise", METRE);
        if (angle.isEmpty() || rowAngle.isEmpty() || range.isEmpty() || noise.isEmpty()) {
            return Optional.empty();
        }
        return checked(
                node,
                () ->
                        new Instrument.Lidar(
                                count(node, "rays"),
                                count(node, "rows"),
                                angle.get(),
                                rowAngle.get(),
                                range.get(),
                                noise.get(),
                                seed(node)));
    }

    private Optional<Double> number(Node instrument, String key, Unit unit) {
        Optional<Node> given = instrument.get(key);
        return given.isEmpty() ? Optional.of(0.0) : quantities.number(given.get(), unit);
    }

    /**
     * Returns the whole number under a key; 1 if the number is missing or wrong. The schema check
     * has already reported a wrong number.
     */
    private static int count(Node instrument, String key) {
        return instrument.get(key).flatMap(Node::number).map(Double::intValue).orElse(1);
    }

    private static long seed(Node node) {
        return node.get("seed").flatMap(Node::number).map(Double::longValue).orElse(0L);
    }

    private Optional<Errors> errors(Node instrument, String quantity, Unit unit) {
        Optional<Node> node = instrument.get(quantity);
        if (node.isEmpty()) {
            return Optional.of(Errors.NONE);
        }
        Optional<Node> noise = node.get().get("noise");
        Optional<Node> bias = node.get().get("bias");
        Optional<Double> deviation =
                noise.isEmpty() ? Optional.of(0.0) : quantities.number(noise.get(), unit);
        Optional<double[]> constant =
                bias.isEmpty()
                        ? Optional.of(new double[3])
                        : quantities.numbers(bias.get(), 3, unit);
        if (deviation.isEmpty() || constant.isEmpty()) {
            return Optional.empty();
        }
        double[] error = constant.get();
        return checked(node.get(), () -> new Errors(deviation.get(), error[0], error[1], error[2]));
    }

    /**
     * Returns the created value. Records the reason and returns empty if its creation is refused.
     * The problem has the position of the key with which the message begins, or of the node.
     */
    private <T> Optional<T> checked(Node node, Supplier<? extends T> made) {
        try {
            return Optional.of(made.get());
        } catch (IllegalArgumentException refused) {
            String subject = refused.getMessage().split(":", 2)[0];
            problems.add(node.get(subject).orElse(node), refused.getMessage());
            return Optional.empty();
        }
    }
}
