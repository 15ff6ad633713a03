// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.WorldDescription;
import reve.core.text.Rounded;
import reve.core.world.WorldPrototype;

import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.stream.Collectors;

/** The checks for joints, motors, ropes and gears that have no effect or not the expected one. */
final class JointChecks {
    /** Values of the property {@code jointType}. */
    private static final int HINGE = 3;

    private static final int SLIDER = 4;
    private static final int DISTANCE = 5;
    private static final int ROPE = 6;
    private static final int SIX_AXIS = 7;

    private static final double TURN = 2 * Math.PI;

    /** Rounding of an angle that is exactly one turn, as a fraction. */
    private static final double ROUNDING = 1e-6;

    private final WorldDescription world;
    private final LawFacts laws;
    private final ItemFacts items;
    private final Findings findings;

    JointChecks(WorldDescription world, LawFacts laws, ItemFacts items, Findings findings) {
        this.world = world;
        this.laws = laws;
        this.items = items;
        this.findings = findings;
    }

    /**
     * @param complete whether all laws of the world are loaded
     */
    void run(boolean complete) {
        if (world.prototype()
                .find(WorldPrototype.JOINT, "joined")
                .filter(world.prototype()::isOfJoints)
                .isEmpty()) {
            return; // the world has no joints, or a designer has declared the kind
        }
        for (String kind : List.of(WorldPrototype.JOINT, WorldPrototype.GEAR)) {
            if (complete && !laws.isUsed(kind)) {
                findings.items(
                        ofKind(kind),
                        "",
                        one ->
                                kind
                                        + " "
                                        + one.name()
                                        + " does nothing, because no law of this world reads items"
                                        + " of kind "
                                        + kind
                                        + "; add rigid_contact to `laws`");
            }
        }
        if (!items.isSetByActions("jointType")) {
            checkRopes();
            checkRods();
            checkAxes();
            checkAngles();
            checkMotors();
            checkGears();
        }
    }

    private List<ItemFacts.Entry> ofKind(String kind) {
        return items.all().stream().filter(entry -> entry.item().kind().equals(kind)).toList();
    }

    private void checkRopes() {
        if (items.isSetByActions("ropeLength")) {
            return;
        }
        findings.items(
                joints(ROPE).stream().filter(joint -> !joint.has("ropeLength")).toList(),
                "physics.jointType",
                joint ->
                        "jointType: rope "
                                + joint.name()
                                + " has the length 0, which pulls its two anchors together; set"
                                + " ropeLength");
    }

    private List<ItemFacts.Entry> joints(int type) {
        return ofKind(WorldPrototype.JOINT).stream()
                .filter(joint -> joint.number("jointType") == type)
                .toList();
    }

    private void checkRods() {
        if (items.isSetByActions("travelLimits")) {
            return;
        }
        findings.items(
                joints(DISTANCE).stream().filter(joint -> !joint.has("travelLimits")).toList(),
                "physics.jointType",
                joint ->
                        "jointType: joint "
                                + joint.name()
                                + " of type distance has the length 0, which pulls its two anchors"
                                + " together; set travelLimits, for example travelLimits: 1 1 m for"
                                + " a rod of 1 m");
    }

    private void checkAxes() {
        if (items.isSetByActions("axis")) {
            return;
        }
        findings.items(
                ofKind(WorldPrototype.JOINT).stream()
                        .filter(joint -> isHinge(joint) || isSlider(joint))
                        .filter(joint -> !joint.has("axis"))
                        .toList(),
                "physics.jointType",
                joint ->
                        "jointType: "
                                + (isHinge(joint) ? "hinge " : "slider ")
                                + joint.name()
                                + " holds its two bodies like a weld, because it has no axis; set"
                                + " axis, for example axis: [0, 1, 0]");
    }

    private static boolean isHinge(ItemFacts.Entry joint) {
        return joint.number("jointType") == HINGE;
    }

    private static boolean isSlider(ItemFacts.Entry joint) {
        return joint.number("jointType") == SLIDER;
    }

    /** Warns of angles beyond a full turn, which joints do not reach. */
    private void checkAngles() {
        for (String property : List.of("angleLimits", "motorAngle", "restAngle")) {
            checkAngles(property, joints(HINGE));
        }
        for (String property : List.of("turnLeast", "turnGreatest")) {
            checkAngles(property, joints(SIX_AXIS));
        }
    }

    private void checkAngles(String property, List<ItemFacts.Entry> joints) {
        findings.items(
                joints.stream().filter(joint -> farthest(joint, property).isPresent()).toList(),
                "physics." + property,
                joint -> {
                    double radians = farthest(joint, property).orElseThrow();
                    return property
                            + ": joint "
                            + joint.name()
                            + " never reaches "
                            + Rounded.of(radians)
                            + " rad, which are "
                            + Rounded.of(Math.abs(radians) / TURN)
                            + " turns, because a number without a unit is in radians; write `"
                            + degrees(joint, property)
                            + " deg` if you mean degrees";
                });
    }

    /** Returns the first of a joint's angles that is beyond a full turn [rad]. */
    private static OptionalDouble farthest(ItemFacts.Entry joint, String property) {
        return Arrays.stream(joint.item().physics(property).orElse(new double[0]))
                .filter(angle -> Math.abs(angle) > TURN * (1 + ROUNDING))
                .findFirst();
    }

    private static String degrees(ItemFacts.Entry joint, String property) {
        return Arrays.stream(joint.item().physics(property).orElseThrow())
                .mapToObj(Rounded::of)
                .collect(Collectors.joining(" "));
    }

    private void checkMotors() {
        checkMotors(
                HINGE,
                List.of("motorSpeed", "motorAngle", "motorStiffness"),
                "motorTorque",
                "the motor of hinge ");
        checkMotors(
                SLIDER,
                List.of("driveSpeed", "driveTravel", "driveStiffness"),
                "driveForce",
                "the drive of slider ");
        checkOthers(SLIDER, "motorSpeed", "slider ", "driveSpeed and driveForce");
        checkOthers(HINGE, "driveSpeed", "hinge ", "motorSpeed and motorTorque");
    }

    /** Warns of motors and drives without the torque or force that limits them. */
    private void checkMotors(int type, List<String> keys, String strength, String subject) {
        if (items.isSetByActions(strength)) {
            return;
        }
        for (int i = 0; i < keys.size(); i++) {
            String key = keys.get(i);
            List<String> reported = keys.subList(0, i);
            findings.items(
                    joints(type).stream()
                            .filter(joint -> joint.has(key) && !joint.has(strength))
                            .filter(joint -> reported.stream().noneMatch(joint::has))
                            .toList(),
                    "physics." + key,
                    joint ->
                            key
                                    + ": "
                                    + subject
                                    + joint.name()
                                    + " moves nothing, because its "
                                    + strength
                                    + " is 0; set "
                                    + strength);
        }
    }

    /** Warns of joints with the speed of a motor that joints of their type do not have. */
    private void checkOthers(int type, String key, String subject, String instead) {
        findings.items(
                joints(type).stream().filter(joint -> joint.has(key)).toList(),
                "physics." + key,
                joint ->
                        key
                                + ": "
                                + subject
                                + joint.name()
                                + " does not use it; set "
                                + instead
                                + " instead");
    }

    private void checkGears() {
        findings.items(
                ofKind(WorldPrototype.GEAR).stream()
                        .filter(gear -> wrongJoint(gear).isPresent())
                        .toList(),
                "physics.geared",
                gear ->
                        "geared: gear "
                                + gear.name()
                                + " has no effect, because "
                                + wrongJoint(gear).orElseThrow()
                                + " is neither a hinge nor a slider; name other joints");
        if (!items.isSetByActions("gearRatio")) {
            findings.items(
                    ofKind(WorldPrototype.GEAR).stream()
                            .filter(gear -> !gear.has("gearRatio"))
                            .toList(),
                    "physics.geared",
                    gear ->
                            "gearRatio: gear "
                                    + gear.name()
                                    + " has the ratio 0, so it only holds its first joint in place;"
                                    + " set gearRatio");
        }
    }

    /** Returns the name of the first joint of a gear that is neither a hinge nor a slider. */
    private Optional<String> wrongJoint(ItemFacts.Entry gear) {
        return gear.item().references().getOrDefault("geared", List.of()).stream()
                .map(items::find)
                .flatMap(Optional::stream)
                .filter(joint -> !isHinge(joint) && !isSlider(joint))
                .map(ItemFacts.Entry::name)
                .findFirst();
    }
}
