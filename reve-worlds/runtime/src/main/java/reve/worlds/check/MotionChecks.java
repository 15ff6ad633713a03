// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.WorldDescription;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsLaw;

import java.util.List;
import java.util.Optional;

/**
 * The checks for bodies that do not move or turn although the world file gives them a reason to.
 */
final class MotionChecks {
    private static final String SPIN = "angularVelocity";
    private static final String INERTIA = "inertia";
    private static final String ACCELERATION = "acceleration";
    private static final String INTEGRATOR =
            "; add a law that moves bodies to `laws`, for example newton_motion";

    private final WorldDescription world;
    private final LawFacts laws;
    private final ItemFacts items;
    private final Findings findings;

    MotionChecks(WorldDescription world, LawFacts laws, ItemFacts items, Findings findings) {
        this.world = world;
        this.laws = laws;
        this.items = items;
        this.findings = findings;
    }

    void run(boolean complete) {
        Optional<PhysicsLaw> mover = laws.mover();
        if (mover.isPresent()) {
            checkMoved(mover.get(), complete);
        } else if (complete) {
            checkUnmoved();
        }
        checkTurns(complete);
        checkImmovable();
        if (world.age() == 0) {
            checkSums();
        }
    }

    /**
     * Warns of values that each step replaces. A saved world (with an age) contains the values of
     * its last step.
     */
    private void checkSums() {
        checkSum(
                LawFacts.FORCE,
                "because each step replaces it by the sum of the forces of laws; set `appliedForce`"
                        + " instead");
        checkSum(
                LawFacts.TORQUE,
                "because each step replaces it by the sum of the torques of laws; set"
                        + " `angularVelocity`, or add a law that exerts the torque, for example as"
                        + " text");
        checkSum(
                ACCELERATION,
                "because laws compute it from the forces; set `appliedForce` to the mass times the"
                        + " acceleration");
    }

    private void checkSum(String property, String reason) {
        boolean isInput =
                laws.isRead(WorldPrototype.BODY, property)
                        && property.equals(ACCELERATION)
                        && !laws.isWritten(WorldPrototype.BODY, property);
        if (isInput || items.isReadByExpressions(property) || items.isSetByActions(property)) {
            return;
        }
        findings.items(
                items.all().stream().filter(body -> body.isBody() && body.has(property)).toList(),
                "physics." + property,
                body -> property + ": the value of " + body.name() + " has no effect, " + reason);
    }

    /** Warns if no law of the world moves bodies. */
    private void checkUnmoved() {
        if (laws.pusher().isPresent() && items.mayMove()) {
            PhysicsLaw pusher = laws.pusher().get();
            findings.law(
                    laws.reference(pusher),
                    "exerts forces, but nothing moves, because no law of this world moves bodies"
                            + INTEGRATOR);
            return;
        }
        List<ItemFacts.Entry> fast =
                items.movable().stream().filter(body -> body.has(LawFacts.VELOCITY)).toList();
        findings.items(
                fast,
                "physics.velocity",
                body ->
                        "velocity: "
                                + body.name()
                                + " does not move, because no law of this world moves bodies"
                                + INTEGRATOR);
        if (fast.isEmpty() && items.isPushed() && items.mayMove()) {
            findings.items(
                    items.movable().stream().limit(1).toList(),
                    "physics.mass",
                    body ->
                            "actions push items, but nothing moves, because no law of this world"
                                    + " moves bodies"
                                    + INTEGRATOR);
        }
    }

    /** Adds the warnings for a world in which a law moves bodies. */
    private void checkMoved(PhysicsLaw mover, boolean complete) {
        if (!items.mayMove() && laws.uses(mover, WorldPrototype.BODY, "mass")) {
            findings.law(
                    laws.reference(mover),
                    "moves nothing, because no body of the world has a mass above 0; set `mass` or"
                            + " `density` under `physics`");
        } else if (complete
                && laws.integrates(mover)
                && laws.pusher().isEmpty()
                && laws.turner().isEmpty()
                && !items.isPushed()
                && world.forces().isEmpty()
                && world.agents().template().isEmpty()
                && !items.mayDiffer(
                        WorldPrototype.BODY, List.of(LawFacts.VELOCITY, "appliedForce"))) {
            findings.law(
                    laws.reference(mover),
                    "moves nothing, because all bodies are at rest and no law or action exerts a"
                            + " force; add one, for example gravity_field with"
                            + " constants: {gravity: [0, -9.81, 0]}, or set a velocity");
        }
    }

    private void checkTurns(boolean complete) {
        if (laws.turner().isEmpty()) {
            if (complete) {
                findings.items(
                        spinning(),
                        "physics." + SPIN,
                        body ->
                                SPIN
                                        + ": "
                                        + body.name()
                                        + " does not turn, because no law of this world turns"
                                        + " bodies; add such a law, for example angular_motion");
            }
        } else if (laws.uses(laws.turner().get(), WorldPrototype.BODY, INERTIA)
                && !items.isSetByActions(INERTIA)) {
            findings.items(
                    spinning().stream().filter(body -> !body.has(INERTIA)).toList(),
                    "physics." + SPIN,
                    body ->
                            SPIN
                                    + ": "
                                    + body.name()
                                    + " does not turn, because its inertia is 0; set `inertia`, or"
                                    + " give it a shape and `density` instead of `mass`");
        }
    }

    private List<ItemFacts.Entry> spinning() {
        return items.all().stream().filter(body -> body.isBody() && body.has(SPIN)).toList();
    }

    /** Warns of bodies with a velocity that no law moves. */
    private void checkImmovable() {
        if (laws.mover().isEmpty()
                || !laws.uses(laws.mover().get(), WorldPrototype.BODY, "mass")
                || items.isSetByActions("mass")) {
            return;
        }
        List<ItemFacts.Entry> still =
                items.all().stream()
                        .filter(body -> body.isBody() && body.has(LawFacts.VELOCITY))
                        .filter(body -> !body.isMovable())
                        .toList();
        findings.items(
                still,
                "physics.velocity",
                body ->
                        "velocity: "
                                + body.name()
                                + (body.item().parent().isPresent()
                                        ? " is attached to "
                                                + body.item().parent().get()
                                                + " and moves with it only; remove the velocity or"
                                                + " the `parent`"
                                        : body.item().physics("mass").isPresent()
                                                ? " has mass 0, which makes it immovable; give it a"
                                                        + " mass, or remove the velocity"
                                                : " has no mass, so no law moves it; set `mass` or"
                                                        + " `density` beside the velocity"));
    }
}
