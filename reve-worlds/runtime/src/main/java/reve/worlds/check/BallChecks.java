// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.WorldDescription;
import reve.core.text.Rounded;
import reve.core.world.Mesh;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.LawParameter;
import reve.pe.PhysicsLaw;

import java.util.Comparator;
import java.util.List;
import java.util.Locale;
import java.util.Optional;

/**
 * The checks for laws that compute contacts of bodies as balls. Such a law reads the radius under
 * {@code physics}, and no shapes.
 */
final class BallChecks {
    /** Ratio of two lengths above which they look different. */
    private static final double DIFFERENT = 1.5;

    /** Depth to which a ball may sink into its support, as a fraction of its radius. */
    private static final double DEEP = 0.5;

    /** Depth for which a warning suggests a stiffness, as a fraction of the radius. */
    private static final double SHALLOW = 0.02;

    /** Distance from a floor below which a ball begins on it, as a fraction of its radius. */
    private static final double ON_FLOOR = 0.1;

    private static final double LOWEST_FLOOR = -1e8;
    private static final String SIZE = "size";
    private static final String INERTIA = "inertia";

    private final WorldDescription world;
    private final LawFacts laws;
    private final ItemFacts items;
    private final Findings findings;

    BallChecks(WorldDescription world, LawFacts laws, ItemFacts items, Findings findings) {
        this.world = world;
        this.laws = laws;
        this.items = items;
        this.findings = findings;
    }

    void run() {
        if (items.isSetByActions(LawFacts.RADIUS)) {
            return;
        }
        laws.all().stream().filter(laws::touchesBalls).findFirst().ifPresent(this::checkRadii);
        for (PhysicsLaw law : laws.all()) {
            if (laws.touchesBalls(law) && laws.isShipped(law)) {
                Optional<PhysicsLaw> other =
                        laws.all().stream()
                                .filter(one -> laws.isShipped(one) && laws.touchesShapes(one))
                                .findFirst();
                if (other.isPresent()) {
                    checkBoth(law, other.get());
                } else {
                    checkShapes(law);
                    checkSizes(law);
                }
                checkInertias(law);
                checkSliding(law);
                checkWeights(law);
            }
        }
    }

    /** Returns whether an item is drawn as a ball, but has no radius for laws. */
    static boolean isDrawnBall(ItemFacts.Entry item) {
        return item.isBody()
                && item.item().hasPhysics()
                && item.item().shape() instanceof Shape.Sphere
                && !item.has(LawFacts.RADIUS);
    }

    private List<ItemFacts.Entry> balls() {
        return items.all().stream()
                .filter(body -> body.isBody() && body.has(LawFacts.RADIUS))
                .filter(body -> body.item().parent().isEmpty())
                .toList();
    }

    private List<ItemFacts.Entry> movable() {
        return balls().stream().filter(ItemFacts.Entry::isMovable).toList();
    }

    /** Warns of balls whose radius no law reads, so that it only affects pictures. */
    private void checkRadii(PhysicsLaw law) {
        findings.items(
                items.all().stream().filter(BallChecks::isDrawnBall).toList(),
                "physical.radius",
                ball ->
                        "radius: "
                                + law.name()
                                + " reads `physics.radius`, which "
                                + ball.name()
                                + " does not set, so nothing touches it; add radius: "
                                + Rounded.of(((Shape.Sphere) ball.item().shape()).radius())
                                + " m under `physics`");
    }

    /** Warns of bodies on which two laws exert the forces of the same contacts. */
    private void checkBoth(PhysicsLaw law, PhysicsLaw other) {
        findings.items(
                movable().stream().filter(body -> body.item().shape() != Shape.none()).toList(),
                "physics.radius",
                body ->
                        "radius: "
                                + law.name()
                                + " and "
                                + other.name()
                                + " both compute the contacts of "
                                + body.name()
                                + "; remove "
                                + law.name()
                                + " from `laws`, or remove the radius under `physics`");
    }

    /** Warns of bodies whose drawn shape is not the ball that the law touches. */
    private void checkShapes(PhysicsLaw law) {
        findings.items(
                balls().stream().filter(body -> isDrawnDifferently(body)).toList(),
                "physics.radius",
                body ->
                        "radius: "
                                + body.name()
                                + " touches others as a ball with the radius "
                                + Rounded.of(body.number(LawFacts.RADIUS))
                                + " m, because "
                                + law.name()
                                + " knows bodies as balls only, but it is drawn as a "
                                + drawn(body.item().shape())
                                + "; draw a sphere of the same radius"
                                + (body.item().shape() instanceof Shape.Sphere
                                        ? ""
                                        : laws.rigidContact()
                                                .map(advice -> ", or " + advice)
                                                .orElse("")));
    }

    private static boolean isDrawnDifferently(ItemFacts.Entry body) {
        Shape shape = body.item().shape();
        if (shape == Shape.none()) {
            return false;
        }
        if (!(shape instanceof Shape.Sphere
                || shape instanceof Shape.Ellipsoid
                || shape instanceof Mesh)) {
            return true;
        }
        double diameter = 2 * body.number(LawFacts.RADIUS);
        for (int axis = 0; axis < 3; axis++) {
            double size = shape.size(axis);
            if (size > diameter * DIFFERENT || size < diameter / DIFFERENT) {
                return true;
            }
        }
        return false;
    }

    private static String drawn(Shape shape) {
        return shape instanceof Shape.Sphere sphere
                ? "sphere with the radius " + Rounded.of(sphere.radius()) + " m"
                : shape.getClass().getSimpleName().toLowerCase(Locale.ROOT);
    }

    /** Warns of a law that changes the sizes of balls, but not their radii. */
    private void checkSizes(PhysicsLaw law) {
        if (laws.isWritten(WorldPrototype.BODY, LawFacts.RADIUS)) {
            return;
        }
        Optional<ItemFacts.Entry> ball =
                movable().stream()
                        .filter(body -> body.item().shape() instanceof Shape.Sphere)
                        .findFirst();
        laws.all().stream()
                .filter(
                        one ->
                                one.uses().stream()
                                        .filter(use -> use.access().contains(Access.WRITE))
                                        .anyMatch(
                                                use ->
                                                        use.kind().equals(WorldPrototype.BODY)
                                                                && use.name().equals(SIZE)))
                .filter(_ -> ball.isPresent())
                .forEach(
                        one ->
                                findings.law(
                                        laws.reference(one),
                                        "changes the sizes of bodies, but "
                                                + law.name()
                                                + " touches "
                                                + ball.orElseThrow().name()
                                                + " with its `physics.radius`, which stays; change"
                                                + " the radius in the same law"
                                                + laws.rigidContact()
                                                        .map(advice -> ", or " + advice)
                                                        .orElse("")));
    }

    /** Warns of balls without inertia in a world where other balls turn. */
    private void checkInertias(PhysicsLaw law) {
        if (laws.turner().isEmpty()
                || !laws.uses(laws.turner().get(), WorldPrototype.BODY, INERTIA)
                || laws.touchesShapes(laws.turner().get())
                || !laws.uses(law, WorldPrototype.BODY, LawFacts.TORQUE)
                || items.isSetByActions(INERTIA)
                || movable().stream().noneMatch(ball -> ball.has(INERTIA))) {
            return;
        }
        findings.items(
                movable().stream()
                        .filter(ball -> !ball.has(INERTIA) && !items.isReferredTo(ball))
                        .toList(),
                "physics.radius",
                ball ->
                        "inertia: "
                                + ball.name()
                                + " slides instead of rolling, because its inertia is 0; add "
                                + inertia(ball)
                                + " under `physics`, or `density` instead of `mass`");
    }

    private static String inertia(ItemFacts.Entry ball) {
        double radius = ball.number(LawFacts.RADIUS);
        String moment = Rounded.of(0.4 * ball.mass() * radius * radius);
        return "inertia: [" + moment + ", " + moment + ", " + moment + "]";
    }

    /** Warns of balls that begin to slide on the floor of a law, in a world where nothing turns. */
    private void checkSliding(PhysicsLaw law) {
        if (laws.turner().isPresent()
                || laws.isRead(WorldPrototype.BODY, LawFacts.TORQUE)
                || !laws.uses(law, WorldPrototype.BODY, LawFacts.TORQUE)
                || !(laws.parameter(law, "friction").orElse(0.0) > 0)
                || laws.shipped("angular_motion").isEmpty()) {
            return;
        }
        double floor = floor(law);
        findings.items(
                movable().stream()
                        .filter(ball -> ball.item().shape() instanceof Shape.Sphere)
                        .filter(ball -> isOn(floor, ball) && isPushedAlong(ball))
                        .toList(),
                "physics.velocity",
                ball ->
                        "velocity: "
                                + ball.name()
                                + " slides along the floor instead of rolling, because no law of"
                                + " this world turns bodies; add angular_motion to `laws`, and "
                                + inertia(ball)
                                + " under `physics`");
    }

    private double floor(PhysicsLaw law) {
        return laws.parameter(law, LawFacts.FLOOR).orElse(LOWEST_FLOOR);
    }

    private static boolean isOn(double floor, ItemFacts.Entry ball) {
        double radius = ball.number(LawFacts.RADIUS);
        return Math.abs(ball.item().location()[1] - radius - floor) < ON_FLOOR * radius;
    }

    private static boolean isPushedAlong(ItemFacts.Entry ball) {
        double[] v = ball.item().physics(LawFacts.VELOCITY).orElse(new double[3]);
        return v[0] != 0 || v[2] != 0;
    }

    /**
     * Warns of balls that sink into their support, because the law is too soft for their weight.
     */
    private void checkWeights(PhysicsLaw law) {
        String name = "stiffness";
        double stiffness =
                law.parameters().stream().map(LawParameter::name).anyMatch(name::equals)
                        ? laws.parameter(law, name).orElse(0.0)
                        : 0;
        List<Double> gravity = world.constants().getOrDefault(LawFacts.GRAVITY, List.of());
        double g = Math.sqrt(gravity.stream().mapToDouble(axis -> axis * axis).sum());
        boolean supported =
                floor(law) > LOWEST_FLOOR || balls().stream().anyMatch(ball -> ball.mass() == 0);
        if (!(stiffness > 0)
                || !supported
                || !laws.isRead(WorldPrototype.WORLD, LawFacts.GRAVITY)) {
            return;
        }
        movable().stream()
                .filter(ball -> ball.mass() * g / stiffness > DEEP * ball.number(LawFacts.RADIUS))
                .max(Comparator.comparingDouble(ball -> ball.mass() / ball.number(LawFacts.RADIUS)))
                .ifPresent(
                        heaviest ->
                                findings.items(
                                        List.of(heaviest),
                                        "physics.mass",
                                        ball -> tooHeavy(ball, law, stiffness, g)));
    }

    private static String tooHeavy(
            ItemFacts.Entry ball, PhysicsLaw law, double stiffness, double g) {
        double enough = ball.mass() * g / (SHALLOW * ball.number(LawFacts.RADIUS));
        double digit = Math.pow(10, Math.floor(Math.log10(enough)));
        return "mass: "
                + ball.name()
                + " of "
                + Rounded.of(ball.mass())
                + " kg sinks "
                + Rounded.of(ball.mass() * g / stiffness)
                + " m into what it rests on, because the stiffness "
                + Rounded.of(stiffness)
                + " N/m of "
                + law.name()
                + " is too small for its weight; set the parameter stiffness: "
                + Rounded.of(Math.ceil(enough / digit) * digit)
                + " N/m";
    }
}
