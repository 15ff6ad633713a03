// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.LawReference;
import reve.core.file.WorldDescription;
import reve.core.text.Rounded;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.LawParameter;
import reve.pe.Phase;
import reve.pe.PhysicsLaw;

import java.util.Comparator;
import java.util.List;
import java.util.Optional;

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
