// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.WorldDescription;
import reve.core.text.Suggestion;
import reve.core.world.PropertyDescriptor;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyUse;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** The checks for laws without rows to act on, and for values that no law reads. */
final class RowChecks {
    /**
     * Laws of this release by the name of a property that they read. A warning about a value that
     * no law reads names the law as a remedy.
     */
    private static final Map<String, String> READERS =
            Map.of(
                    "spring", "hooke_spring",
                    "surface", "surface_contact",
                    "charge", "coulomb or lorentz_field",
                    "dragCoefficient", "drag",
                    "linearDragCoefficient", "drag",
                    "gravity", "gravity_field",
                    "gravitationalConstant", "newton_gravitation",
                    "coulombConstant", "coulomb",
                    "electricField", "lorentz_field",
                    "magneticField", "lorentz_field");

    private static final List<String> EFFECTIVE =
            List.of("charge", "dragCoefficient", "linearDragCoefficient");

    /** Properties of contacts that rigid_contact reads. */
    private static final List<String> CONTACT =
            List.of(
                    "friction",
                    "restitution",
                    "rollingFriction",
                    "spinFriction",
                    "touchLayer",
                    "passesLayers",
                    "touchSensor",
                    "partOfBody");

    private final WorldDescription world;
    private final LawFacts laws;
    private final ItemFacts items;
    private final Findings findings;

    RowChecks(WorldDescription world, LawFacts laws, ItemFacts items, Findings findings) {
        this.world = world;
        this.laws = laws;
        this.items = items;
        this.findings = findings;
    }

    void run(boolean complete) {
        for (PhysicsLaw law : laws.all()) {
            Optional<String> missing = missingKind(law);
            if (missing.isPresent()) {
                findings.law(
                        laws.reference(law),
                        "does nothing, because the world has no item of kind "
                                + missing.get()
                                + "; add one, or remove the law");
            } else {
                checkConstants(law);
                checkStrengths(law);
            }
        }
        laws.readerOfUnknownField()
                .ifPresent(
                        law ->
                                findings.law(
                                        laws.reference(law),
                                        "rests, because no law of this world provides the field"
                                                + " that it reads; add a law library that provides"
                                                + " the field, or remove the law"));
        checkSprings();
        if (complete) {
            checkUnread();
            checkContact();
            laws.all().forEach(this::checkOwn);
        }
    }

    private Optional<String> missingKind(PhysicsLaw law) {
        return laws.ownKinds(law).stream().filter(kind -> !items.mayExist(kind)).findFirst();
    }

    private void checkConstants(PhysicsLaw law) {
        List<PropertyUse> needed = new ArrayList<>();
        List<PropertyUse> possible = new ArrayList<>();
        laws.strengths(law)
                .filter(use -> use.kind().equals(WorldPrototype.WORLD))
                .forEach(use -> (use.optional() ? possible : needed).add(use));
        for (PropertyUse use : needed) {
            if (!isGiven(use)) {
                findings.law(
                        laws.reference(law),
                        (laws.isShipped(law)
                                        ? "exerts no force, because `constants` does not set "
                                                + use.name()
                                        : "reads "
                                                + use.name()
                                                + ", which is 0, because `constants` does not set"
                                                + " it")
                                + "; set it"
                                + example(use.name()));
            }
        }
        if (needed.isEmpty()
                && !possible.isEmpty()
                && possible.stream().noneMatch(this::isGiven)
                && law.parameters().isEmpty()
                && laws.ownKinds(law).isEmpty()) {
            findings.law(
                    laws.reference(law),
                    "exerts no force, because `constants` sets none of "
                            + String.join(", ", possible.stream().map(PropertyUse::name).toList())
                            + "; set at least one of them");
        }
    }

    private boolean isGiven(PropertyUse use) {
        return world.constants().containsKey(use.name()) || items.isSetByActions(use.name());
    }

    private static String example(String constant) {
        return switch (constant) {
            case "gravity" -> ", for example gravity: [0, -9.81, 0]";
            case "gravitationalConstant" ->
                    ", for example gravitationalConstant: 6.6743e-11, or 1 in the model's own"
                            + " units";
            case "coulombConstant" -> ", for example coulombConstant: 8.9875517923e9";
            default -> "";
        };
    }

    /**
     * Reports a law whose strength is 0 for every row. A shipped law acts only if all properties
     * that it needs are set. Other laws may add terms with different properties, so only a law
     * without any of them is reported.
     */
    private void checkStrengths(PhysicsLaw law) {
        List<PropertyUse> own =
                laws.strengths(law)
                        .filter(use -> !use.kind().equals(WorldPrototype.WORLD))
                        .toList();
        boolean optionalActs = own.stream().filter(PropertyUse::optional).anyMatch(this::mayDiffer);
        List<PropertyUse> needed = own.stream().filter(use -> !use.optional()).toList();
        if (!laws.isShipped(law) && needed.stream().anyMatch(this::mayDiffer)) {
            return;
        }
        for (PropertyUse use : needed) {
            if (!mayDiffer(use) && !optionalActs) {
                findings.law(
                        laws.reference(law),
                        "does nothing, because "
                                + LawFacts.columns(use).getFirst()
                                + " is 0 or not set for every "
                                + use.kind()
                                + "; set it under `physics`"
                                + (use.name().equals(LawFacts.RADIUS)
                                        ? " (the radius of a shape under `physical` is only"
                                                + " drawn)"
                                        : ""));
                return;
            }
        }
        if (needed.isEmpty() && !own.isEmpty() && !optionalActs && laws.pushes(law)) {
            findings.law(
                    laws.reference(law),
                    "does nothing, because no "
                            + own.getFirst().kind()
                            + " sets "
                            + String.join(
                                    " or ",
                                    own.stream()
                                            .map(use -> LawFacts.columns(use).getFirst())
                                            .toList())
                            + "; set it under `physics`");
        }
    }

    private boolean mayDiffer(PropertyUse use) {
        return items.mayDiffer(use.kind(), LawFacts.columns(use));
    }

    /** Warns of springs that exert no force, or that are attached to no movable body. */
    private void checkSprings() {
        if (!laws.isUsed("spring")) {
            return;
        }
        List<ItemFacts.Entry> weak = new ArrayList<>();
        List<ItemFacts.Entry> fixed = new ArrayList<>();
        int springs = 0;
        List<ItemFacts.Entry> collapsed = new ArrayList<>();
        for (ItemFacts.Entry spring : items.all()) {
            if (!spring.item().kind().equals("spring")) {
                continue;
            }
            springs++;
            Optional<ItemFacts.Entry> one = end(spring, "end1");
            Optional<ItemFacts.Entry> other = end(spring, "end2");
            if (!spring.has("springConstant") && !spring.has("dampingConstant")) {
                weak.add(spring);
            } else if (one.isPresent() && other.isPresent()) {
                if (!one.get().isMovable() && !other.get().isMovable()) {
                    fixed.add(spring);
                } else if (spring.has("length") && isAtSamePlace(one.get(), other.get())) {
                    collapsed.add(spring);
                }
            }
        }
        boolean pulls =
                laws.isRead("spring", "springConstant") || laws.isRead("spring", "dampingConstant");
        if (pulls && !items.isSetByActions("springConstant")) {
            findings.items(
                    weak,
                    "physics.springConstant",
                    spring ->
                            "springConstant: spring "
                                    + spring.name()
                                    + " exerts no force, because neither springConstant nor"
                                    + " dampingConstant is set; set one, for example"
                                    + " springConstant: 100 N/m");
        }
        if (fixed.size() == springs && !items.isSetByActions("mass")) {
            findings.items(
                    fixed,
                    "physics.end1",
                    spring ->
                            "spring "
                                    + spring.name()
                                    + " moves nothing, because neither of its ends has a mass;"
                                    + " give one of them a mass");
        }
        findings.items(
                collapsed,
                "physics.end1",
                spring ->
                        "spring "
                                + spring.name()
                                + " exerts no force, because its ends are at the same place, where"
                                + " it has no direction; move one of them");
    }

    private Optional<ItemFacts.Entry> end(ItemFacts.Entry spring, String reference) {
        return Optional.ofNullable(spring.item().references().get(reference))
                .map(List::getFirst)
                .flatMap(items::find);
    }

    private static boolean isAtSamePlace(ItemFacts.Entry one, ItemFacts.Entry other) {
        return one.item().parent().isEmpty()
                && other.item().parent().isEmpty()
                && Arrays.equals(one.item().location(), other.item().location());
    }

    /** Warns of items and values that no law reads. */
    private void checkUnread() {
        Set<String> standard =
                Set.copyOf(WorldPrototype.standard(world.prototype().name()).kinds());
        for (String kind : world.prototype().kinds()) {
            if (standard.contains(kind)
                    && !kind.equals(WorldPrototype.BODY)
                    && !kind.equals(WorldPrototype.WORLD)
                    && !laws.isUsed(kind)) {
                findings.items(
                        items.all().stream()
                                .filter(entry -> entry.item().kind().equals(kind))
                                .toList(),
                        "",
                        entry ->
                                kind
                                        + " "
                                        + entry.name()
                                        + " does nothing, because no law of this world reads items"
                                        + " of kind "
                                        + kind
                                        + reader(kind));
            }
        }
        for (String property : EFFECTIVE) {
            if (!laws.isRead(WorldPrototype.BODY, property)
                    && !items.isReadByExpressions(property)) {
                findings.items(
                        items.all().stream()
                                .filter(entry -> entry.isBody() && entry.has(property))
                                .toList(),
                        "physics." + property,
                        entry ->
                                property
                                        + ": no law of this world reads the "
                                        + property
                                        + " of "
                                        + entry.name()
                                        + reader(property));
            }
        }
        if (laws.pusher().isEmpty()) {
            for (String constant : world.constants().keySet()) {
                if (READERS.containsKey(constant)
                        && !laws.isRead(WorldPrototype.WORLD, constant)
                        && !items.isReadByExpressions(constant)
                        && !(constant.equals(LawFacts.GRAVITY) && items.isWeighed())) {
                    findings.constant(
                            constant,
                            constant
                                    + " has no effect, because no law of this world reads it"
                                    + reader(constant));
                }
            }
        }
    }

    /** Warns of properties of contacts in a world whose laws of contact do not read them. */
    private void checkContact() {
        if (laws.mover().isEmpty() || laws.rigidContact().isEmpty()) {
            return;
        }
        for (String property : CONTACT) {
            if (laws.isRead(WorldPrototype.BODY, property) || items.isReadByExpressions(property)) {
                continue;
            }
            findings.items(
                    items.all().stream()
                            .filter(entry -> entry.isBody())
                            .filter(entry -> entry.item().physics(property).isPresent())
                            .toList(),
                    "physics." + property,
                    entry ->
                            property
                                    + ": no law of this world reads the "
                                    + property
                                    + " of "
                                    + entry.name()
                                    + "; "
                                    + laws.withParameter(property)
                                            .map(
                                                    law ->
                                                            "set the parameter "
                                                                    + property
                                                                    + " of "
                                                                    + law.name()
                                                                    + " for all bodies, or ")
                                            .orElse("")
                                    + laws.rigidContact().orElseThrow()
                                    + ", which reads it");
        }
    }

    /**
     * Warns of a property that a law declares for itself, if the world has a property of nearly the
     * same name that no law uses.
     */
    private void checkOwn(PhysicsLaw law) {
        for (PropertyUse use : law.uses()) {
            if (!use.access().contains(Access.SCRATCH) || !laws.isText(law)) {
                continue;
            }
            List<String> unused =
                    world.prototype().properties().stream()
                            .filter(own -> own.kind().equals(use.kind()))
                            .map(PropertyDescriptor::name)
                            .filter(own -> !world.prototype().isStandard(use.kind(), own))
                            .filter(own -> !laws.isRead(use.kind(), own))
                            .filter(own -> !laws.isWritten(use.kind(), own))
                            .filter(own -> !items.isReadByExpressions(own))
                            .toList();
            String similar = Suggestion.of(use.name(), unused);
            if (!similar.isEmpty()) {
                findings.law(
                        laws.reference(law),
                        "has a property "
                                + use.name()
                                + " of its own, which is 0 at first, and no law reads the property"
                                + " of the world with a similar name"
                                + similar);
            }
        }
    }

    private static String reader(String what) {
        String law = READERS.get(what);
        return law == null ? "; add such a law to `laws`" : "; add " + law + " to `laws`";
    }
}
