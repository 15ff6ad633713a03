// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.LawReference;
import reve.core.file.WorldDescription;
import reve.core.text.Rounded;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.LawParameter;
import reve.pe.Phase;
import reve.pe.PhysicsLaw;

import java.util.Comparator;
import java.util.List;
import java.util.Optional;
import java.util.OptionalDouble;

/**
 * The checks for steps that are too long for the forces of laws. The checks use the stiffness k,
 * the mass m and the length of a step dt.
 *
 * <p>An oscillation has the angular frequency ω and is damped at the rate γ. It is stable if (ω
 * dt)² + 2 γ dt is at most 4 for integrators with one stage, and about 8 for integrators with four
 * stages.
 */
final class StepChecks {
    private static final double LIMIT = 4;
    private static final double LIMIT_OF_FOUR_STAGES = 8;

    /** Minimum number of steps during a contact of two balls. */
    private static final double STEPS_PER_CONTACT = 5;

    /** Longest flight of a body that counts as straight [s]. */
    private static final double FLIGHT = 0.5;

    private final WorldDescription world;
    private final LawFacts laws;
    private final ItemFacts items;
    private final Findings findings;
    private final double dt;
    private final double limit;

    StepChecks(WorldDescription world, LawFacts laws, ItemFacts items, Findings findings) {
        this.world = world;
        this.laws = laws;
        this.items = items;
        this.findings = findings;
        dt = world.timing().dtSeconds();
        limit = laws.mover().map(PhysicsLaw::stages).orElse(1) >= 4 ? LIMIT_OF_FOUR_STAGES : LIMIT;
    }

    void run() {
        if (laws.mover().isEmpty()) {
            return;
        }
        laws.all().forEach(this::checkMemory);
        if (laws.isRead("spring", "springConstant")) {
            checkSprings();
        }
        for (PhysicsLaw law : laws.all()) {
            if (laws.touchesBalls(law)) {
                checkBalls(law);
            }
            if (laws.touchesSurfaces(law)) {
                checkSurfaces(law);
            }
        }
        if (laws.isRead(WorldPrototype.BODY, "linearDragCoefficient")) {
            checkDrag();
        }
        if (laws.all().stream().anyMatch(law -> laws.isShipped(law) && laws.touchesShapes(law))) {
            checkWalls();
        }
    }

    /** Warns of bodies that fly towards an immovable box and jump over it in one step. */
    private void checkWalls() {
        List<ItemFacts.Entry> walls =
                items.all().stream()
                        .filter(item -> item.isBody() && !item.isMovable())
                        .filter(item -> item.item().parent().isEmpty())
                        .filter(item -> item.item().shape() instanceof Shape.Box)
                        .toList();
        for (ItemFacts.Entry body : items.movable()) {
            double jump = speed(body) * dt;
            if (body.item().shape() == Shape.none() || jump == 0 || items.isReferredTo(body)) {
                continue;
            }
            Optional<ItemFacts.Entry> wall =
                    walls.stream()
                            .filter(one -> jump > chord(body, one).orElse(jump) + extent(body))
                            .findFirst();
            if (wall.isPresent()) {
                findings.items(
                        List.of(body),
                        "physics.velocity",
                        one ->
                                "velocity: "
                                        + one.name()
                                        + " moves by "
                                        + Rounded.of(jump)
                                        + " m in a step of "
                                        + Rounded.of(dt)
                                        + " s and may pass through "
                                        + wall.get().name()
                                        + ", which is thinner"
                                        + remedy(
                                                chord(one, wall.get()).orElseThrow()
                                                        / speed(one)
                                                        / 2));
                return;
            }
        }
    }

    private static double extent(ItemFacts.Entry body) {
        Shape shape = body.item().shape();
        return Math.max(shape.size(0), Math.max(shape.size(1), shape.size(2)));
    }

    /**
     * Returns the length of the part of a body's straight path that is inside a box [m]. Empty if
     * the path misses the box, or if the body needs more than {@link #FLIGHT} to it.
     */
    private static OptionalDouble chord(ItemFacts.Entry body, ItemFacts.Entry box) {
        double[] q = box.item().orientation();
        double[] from = body.item().location();
        double[] to = box.item().location();
        double[] v = body.item().physics(LawFacts.VELOCITY).orElseThrow();
        double enter = 0;
        double leave = FLIGHT;
        for (int axis = 0; axis < 3; axis++) {
            double[] along = new double[3];
            along[axis] = 1;
            along = turned(q, along);
            double place = 0;
            double speed = 0;
            for (int i = 0; i < 3; i++) {
                place += (from[i] - to[i]) * along[i];
                speed += v[i] * along[i];
            }
            double half = box.item().shape().size(axis) / 2;
            if (speed == 0) {
                if (Math.abs(place) > half) {
                    return OptionalDouble.empty();
                }
                continue;
            }
            double one = (-half - place) / speed;
            double other = (half - place) / speed;
            enter = Math.max(enter, Math.min(one, other));
            leave = Math.min(leave, Math.max(one, other));
        }
        return enter > 0 && enter < leave
                ? OptionalDouble.of((leave - enter) * speed(body))
                : OptionalDouble.empty();
    }

    /** Returns a vector after the rotation by a unit quaternion. */
    private static double[] turned(double[] q, double[] v) {
        double x = 2 * (q[1] * v[2] - q[2] * v[1]);
        double y = 2 * (q[2] * v[0] - q[0] * v[2]);
        double z = 2 * (q[0] * v[1] - q[1] * v[0]);
        return new double[] {
            v[0] + q[3] * x + q[1] * z - q[2] * y,
            v[1] + q[3] * y + q[2] * x - q[0] * z,
            v[2] + q[3] * z + q[0] * y - q[1] * x
        };
    }

    /**
     * Warns of a text that keeps values in a property of its own, and that the law acts more than
     * once in a step. Compiled laws with such memory handle the stages themselves.
     */
    private void checkMemory(PhysicsLaw law) {
        int stages = laws.mover().map(PhysicsLaw::stages).orElse(1);
        LawReference reference = laws.reference(law);
        if (law.phase() != Phase.FORCE || stages < 2 || !laws.isText(law)) {
            return;
        }
        law.uses().stream()
                .filter(use -> use.access().contains(Access.SCRATCH))
                .findFirst()
                .ifPresent(
                        use ->
                                findings.law(
                                        reference,
                                        "changes its own property "
                                                + use.name()
                                                + " "
                                                + stages
                                                + " times in each step, because it adds forces and "
                                                + laws.mover().orElseThrow().name()
                                                + " needs the forces "
                                                + stages
                                                + " times; declare the property in the world and"
                                                + " change it in a law without forces, or use"
                                                + " velocity_verlet"));
    }

    private void checkSprings() {
        Optional<SpringNetwork.Stiffest> stiffest = SpringNetwork.stiffest(items, dt);
        if (stiffest.isEmpty() || stiffest.get().stiffness() <= limit) {
            return;
        }
        ItemFacts.Entry spring = stiffest.get().spring();
        findings.items(
                List.of(spring),
                spring.has("springConstant") ? "physics.springConstant" : "physics.dampingConstant",
                item ->
                        "spring "
                                + item.name()
                                + " is too stiff for a step of "
                                + Rounded.of(dt)
                                + " s: with springConstant "
                                + Rounded.of(item.number("springConstant"))
                                + " N/m, dampingConstant "
                                + Rounded.of(item.number("dampingConstant"))
                                + " N*s/m and the masses at its ends, the bodies gain energy until"
                                + " they are out of bounds"
                                + remedy(stiffest.get().seconds()));
    }

    private void checkBalls(PhysicsLaw law) {
        Optional<Double> stiffness =
                law.parameters().stream()
                        .map(LawParameter::name)
                        .filter("stiffness"::equals)
                        .findFirst()
                        .flatMap(name -> laws.parameter(law, name));
        List<ItemFacts.Entry> balls =
                items.movable().stream().filter(body -> body.has(LawFacts.RADIUS)).toList();
        Optional<ItemFacts.Entry> lightest =
                balls.stream().min(Comparator.comparingDouble(ItemFacts.Entry::mass));
        if (lightest.isPresent() && stiffness.isPresent() && stiffness.get() > 0) {
            double mass = lightest.get().mass() * (balls.size() > 1 ? 0.5 : 1);
            double contact = Math.PI * Math.sqrt(mass / stiffness.get());
            if (contact < dt * STEPS_PER_CONTACT / 2) {
                findings.items(
                        List.of(lightest.get()),
                        "physics.mass",
                        ball ->
                                ball.name()
                                        + " is too light for a step of "
                                        + Rounded.of(dt)
                                        + " s: with stiffness "
                                        + Rounded.of(stiffness.get())
                                        + " N/m of "
                                        + law.name()
                                        + ", a contact of its "
                                        + Rounded.of(ball.mass())
                                        + " kg lasts "
                                        + Rounded.of(contact)
                                        + " s"
                                        + remedy(contact / STEPS_PER_CONTACT)
                                        + ", or a smaller stiffness");
            }
        }
        findings.items(
                balls.stream().filter(this::isTooFast).toList(),
                "physics.velocity",
                ball ->
                        "velocity: "
                                + ball.name()
                                + " moves by more than its radius in a step of "
                                + Rounded.of(dt)
                                + " s and may pass through others"
                                + remedy(ball.number(LawFacts.RADIUS) / speed(ball) / 2));
    }

    private boolean isTooFast(ItemFacts.Entry ball) {
        return speed(ball) * dt > ball.number(LawFacts.RADIUS);
    }

    private void checkSurfaces(PhysicsLaw law) {
        Optional<ItemFacts.Entry> hardest =
                items.all().stream()
                        .filter(entry -> entry.item().kind().equals(LawFacts.SURFACE))
                        .max(Comparator.comparingDouble(this::hardness));
        Optional<ItemFacts.Entry> lightest =
                items.movable().stream().min(Comparator.comparingDouble(ItemFacts.Entry::mass));
        if (hardest.isEmpty() || lightest.isEmpty()) {
            return;
        }
        double mass = lightest.get().mass();
        double k = hardest.get().number("hardness") / mass;
        double c = hardest.get().number("surfaceDamping") / mass;
        if (k * dt * dt + 2 * c * dt > limit) {
            findings.items(
                    List.of(hardest.get()),
                    "physics.hardness",
                    surface ->
                            "surface "
                                    + surface.name()
                                    + " is too hard for a step of "
                                    + Rounded.of(dt)
                                    + " s: with hardness "
                                    + Rounded.of(surface.number("hardness"))
                                    + " N/m and surfaceDamping "
                                    + Rounded.of(surface.number("surfaceDamping"))
                                    + " N*s/m, "
                                    + law.name()
                                    + " throws "
                                    + lightest.get().name()
                                    + " of "
                                    + Rounded.of(mass)
                                    + " kg off"
                                    + remedy(
                                            Math.min(
                                                    1 / Math.sqrt(Math.max(k, Double.MIN_NORMAL)),
                                                    0.5 / Math.max(c, Double.MIN_NORMAL))));
        }
    }

    private double hardness(ItemFacts.Entry surface) {
        return surface.number("hardness") * dt + 2 * surface.number("surfaceDamping");
    }

    private void checkDrag() {
        findings.items(
                items.movable().stream().filter(body -> resistance(body) * dt >= 2).toList(),
                "physics.linearDragCoefficient",
                body ->
                        body.name()
                                + " is too light for its drag in a step of "
                                + Rounded.of(dt)
                                + " s: drag stops it in "
                                + Rounded.of(1 / resistance(body))
                                + " s, so each step reverses it and adds speed"
                                + remedy(0.5 / resistance(body)));
    }

    /** Returns the rate at which drag slows a body down at its initial speed [1/s]. */
    private static double resistance(ItemFacts.Entry body) {
        return (body.number("linearDragCoefficient") + body.number("dragCoefficient") * speed(body))
                / body.mass();
    }

    private static double speed(ItemFacts.Entry body) {
        double[] v = body.item().physics(LawFacts.VELOCITY).orElse(new double[3]);
        return Math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }

    /**
     * Returns the end of a message. It states the number of steps per frame with which no step is
     * longer than {@code seconds}.
     */
    private String remedy(double seconds) {
        double frame = 1.0 / world.timing().framesPerSecond();
        double steps = Math.ceil(frame / seconds - 1e-9);
        return "; a step of "
                + Rounded.of(frame / steps)
                + " s holds: write frame: {rate: "
                + world.timing().framesPerSecond()
                + ", steps: "
                + Rounded.of(steps)
                + "}";
    }
}
