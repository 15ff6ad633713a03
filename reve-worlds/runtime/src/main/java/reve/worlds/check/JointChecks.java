// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.WorldDescription;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Optional;

/** The checks for joints, ropes and gears that have no effect. */
final class JointChecks {
    /** Values of the property {@code jointType}. */
    private static final int HINGE = 3;

    private static final int SLIDER = 4;
    private static final int ROPE = 6;

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
                ofKind(WorldPrototype.JOINT).stream()
                        .filter(joint -> joint.number("jointType") == ROPE)
                        .filter(joint -> !joint.has("ropeLength"))
                        .toList(),
                "physics.jointType",
                joint ->
                        "jointType: rope "
                                + joint.name()
                                + " has the length 0, which pulls its two anchors together; set"
                                + " ropeLength");
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
                .filter(joint -> joint.number("jointType") != HINGE)
                .filter(joint -> joint.number("jointType") != SLIDER)
                .map(ItemFacts.Entry::name)
                .findFirst();
    }
}
