// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.LawReference;
import reve.core.file.WorldDescription;
import reve.core.world.PropertyDescriptor;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.LawParameter;
import reve.pe.Phase;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyUse;
import reve.pe.ScalarType;
import reve.pe.adapter.PropertyNames;

import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.Predicate;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/** The effects of a world's laws, derived from the properties that the laws declare. */
final class LawFacts {
    static final String POSITION = "position";
    static final String VELOCITY = "velocity";
    static final String ORIENTATION = "orientation";
    static final String FORCE = "externalForce";
    static final String GRAVITY = "gravity";
    static final String TORQUE = "torque";
    static final String RADIUS = "radius";
    static final String SURFACE = "surface";
    static final String FLOOR = "floorHeight";

    /**
     * Properties of the state or the rest shape of a body. The value 0 is usual for these
     * properties and does not indicate a mistake.
     */
    private static final Set<String> STATE =
            Set.of(
                    POSITION,
                    VELOCITY,
                    "acceleration",
                    ORIENTATION,
                    "angularVelocity",
                    FORCE,
                    "appliedForce",
                    TORQUE,
                    WorldPrototype.SPECIFIC_FORCE,
                    WorldPrototype.ANGULAR_RATE,
                    WorldPrototype.CONTACT_FORCE,
                    WorldPrototype.REACTION_FORCE,
                    "length",
                    "softening");

    /**
     * Name of the kind that contains the rows of items without physics. Laws may use the shapes of
     * these items.
     */
    static final String SCENERY = "scenery";

    /**
     * Name of the kind that contains the rows of meshes. Laws may use the hulls and triangles of
     * the meshes.
     */
    static final String MESH = "meshForm";

    /** Pattern of the names of properties from which a law gets the shape of a body. */
    private static final Pattern EXTENT =
            Pattern.compile("(?i).*(shape|size|extent|dimension|hull|mesh).*");

    private final WorldPrototype prototype;
    private final List<PhysicsLaw> laws;
    private final List<LawReference> references;
    private final Set<Integer> texts;
    private final Set<String> shipped;

    LawFacts(
            WorldDescription world,
            List<PhysicsLaw> laws,
            Set<Integer> texts,
            Set<String> shipped) {
        this.prototype = world.prototype();
        this.laws = laws;
        this.texts = texts;
        this.references = world.laws();
        this.shipped = shipped;
    }

    List<PhysicsLaw> all() {
        return laws;
    }

    /** Returns whether a law is a law as text. */
    boolean isText(PhysicsLaw law) {
        return texts.contains(law.libraryId());
    }

    /** Returns the entry of the world file that loads a law. */
    LawReference reference(PhysicsLaw law) {
        return references.stream()
                .filter(reference -> reference.name().equals(law.library()))
                .findFirst()
                .orElseGet(() -> new LawReference(law.library(), Map.of(), ""));
    }

    /** Returns the value of a parameter; empty if the law declares no parameter of this name. */
    Optional<Double> parameter(PhysicsLaw law, String name) {
        return law.parameters().stream()
                .filter(parameter -> parameter.name().equals(name))
                .findFirst()
                .map(LawParameter::standard)
                .map(
                        standard -> {
                            var given = reference(law).parameters();
                            return given.getOrDefault(
                                    name, given.getOrDefault(law.name() + "." + name, standard));
                        });
    }

    /** Returns the first law of this release that has a parameter of this name. */
    Optional<PhysicsLaw> withParameter(String name) {
        return laws.stream()
                .filter(this::isShipped)
                .filter(
                        law ->
                                law.parameters().stream()
                                        .anyMatch(parameter -> parameter.name().equals(name)))
                .findFirst();
    }

    private Optional<PhysicsLaw> first(Predicate<PropertyUse> use) {
        return laws.stream().filter(law -> law.uses().stream().anyMatch(use)).findFirst();
    }

    /** Returns the first law that moves bodies. */
    Optional<PhysicsLaw> mover() {
        return first(use -> isBody(use, POSITION) && use.access().contains(Access.WRITE));
    }

    /**
     * Returns whether a law moves bodies according to their velocities. A law that moves bodies may
     * also ignore velocities and compute the places directly.
     */
    boolean integrates(PhysicsLaw mover) {
        return uses(mover, WorldPrototype.BODY, VELOCITY);
    }

    /** Returns the first law that turns bodies. */
    Optional<PhysicsLaw> turner() {
        return first(use -> isBody(use, ORIENTATION) && use.access().contains(Access.WRITE));
    }

    /** Returns the first law that exerts forces or changes velocities. */
    Optional<PhysicsLaw> pusher() {
        return laws.stream().filter(this::pushes).findFirst();
    }

    boolean pushes(PhysicsLaw law) {
        return law.uses().stream()
                        .anyMatch(
                                use ->
                                        use.kind().equals(WorldPrototype.BODY)
                                                && use.access().contains(Access.ACCUMULATE)
                                                && !isOwnSum(use))
                || law.uses().stream()
                                .anyMatch(
                                        use ->
                                                isBody(use, VELOCITY)
                                                        && use.access().contains(Access.WRITE))
                        && law.uses().stream().noneMatch(use -> isBody(use, FORCE));
    }

    /** Returns whether a property is a sum that the world file declares, which moves nothing. */
    private boolean isOwnSum(PropertyUse use) {
        return prototype
                .find(use.kind(), use.name())
                .filter(PropertyDescriptor::accumulated)
                .isPresent();
    }

    /** Returns whether any law reads a property. The property is given by its name in the world. */
    boolean isRead(String kind, String property) {
        return laws.stream()
                .flatMap(law -> law.uses().stream())
                .anyMatch(
                        use ->
                                use.kind().equals(kind)
                                        && reads(use)
                                        && columns(use).contains(property));
    }

    boolean isWritten(String kind, String engineName) {
        return laws.stream()
                .flatMap(law -> law.uses().stream())
                .anyMatch(
                        use ->
                                use.kind().equals(kind)
                                        && use.name().equals(engineName)
                                        && (use.access().contains(Access.WRITE)
                                                || use.access().contains(Access.ACCUMULATE)));
    }

    boolean isUsed(String kind) {
        return laws.stream()
                .flatMap(law -> law.uses().stream())
                .anyMatch(use -> use.kind().equals(kind));
    }

    boolean uses(PhysicsLaw law, String kind, String engineName) {
        return law.uses().stream()
                .anyMatch(use -> use.kind().equals(kind) && use.name().equals(engineName));
    }

    /** Returns the kinds of items whose rows a law needs, except body and world. */
    List<String> ownKinds(PhysicsLaw law) {
        return law.uses().stream()
                .filter(use -> !use.optional())
                .map(PropertyUse::kind)
                .filter(
                        kind ->
                                !kind.equals(WorldPrototype.BODY)
                                        && !kind.equals(WorldPrototype.WORLD))
                .distinct()
                .toList();
    }

    /**
     * Returns the properties whose values decide how strongly a law acts. The law reads these
     * properties, no law writes them, and they are neither state nor references.
     */
    Stream<PropertyUse> strengths(PhysicsLaw law) {
        return law.uses().stream()
                .filter(
                        use ->
                                reads(use)
                                        && !use.access().contains(Access.SCRATCH)
                                        && (use.type() == ScalarType.F32
                                                || use.type() == ScalarType.F64)
                                        && !STATE.contains(use.name())
                                        && !EXTENT.matcher(use.name()).matches()
                                        && !isWritten(use.kind(), use.name()));
    }

    /**
     * Returns the first law that reads a field (a function of position) that no library provides.
     */
    Optional<PhysicsLaw> readerOfUnknownField() {
        return laws.stream().allMatch(law -> shipped.contains(law.library()))
                ? first(use -> use.type() == ScalarType.FIELD && !use.optional())
                : Optional.empty();
    }

    /** Returns whether a law computes contacts of bodies as balls. */
    boolean touchesBalls(PhysicsLaw law) {
        return pushes(law) && law.uses().stream().anyMatch(use -> isBody(use, RADIUS));
    }

    /** Returns whether a law computes contacts of bodies with triangles. */
    boolean touchesSurfaces(PhysicsLaw law) {
        return pushes(law) && law.uses().stream().anyMatch(use -> use.kind().equals(SURFACE));
    }

    /**
     * Returns whether a law computes contacts of bodies by their shapes. A law that writes an
     * extent changes shapes.
     */
    boolean touchesShapes(PhysicsLaw law) {
        return law.uses().stream()
                .anyMatch(
                        use ->
                                use.kind().equals(WorldPrototype.BODY)
                                        && !use.access().contains(Access.WRITE)
                                        && EXTENT.matcher(use.name()).matches());
    }

    /**
     * Returns whether a law may keep bodies above a floor without their shapes and radii. The law
     * reads the positions of bodies, and moves bodies or exerts forces on them. The checks know the
     * contacts of the laws of this release only.
     */
    boolean mayHold(PhysicsLaw law) {
        return !isShipped(law)
                && law.uses().stream().anyMatch(use -> isBody(use, POSITION) && reads(use))
                && law.uses().stream()
                        .anyMatch(
                                use ->
                                        isBody(use, FORCE)
                                                        && use.access().contains(Access.ACCUMULATE)
                                                || (isBody(use, POSITION) || isBody(use, VELOCITY))
                                                        && use.access().contains(Access.WRITE));
    }

    /**
     * Returns the advice to use rigid_contact, and the laws of this world that it replaces. Empty
     * if this release does not contain rigid_contact.
     */
    Optional<String> rigidContact() {
        if (shipped("rigid_contact").isEmpty()) {
            return Optional.empty();
        }
        List<String> replaced =
                laws.stream()
                        .filter(
                                law ->
                                        law.phase() == Phase.INTEGRATE
                                                || isShipped(law) && touchesBalls(law))
                        .map(PhysicsLaw::name)
                        .distinct()
                        .toList();
        return Optional.of(
                "use rigid_contact"
                        + (replaced.isEmpty()
                                ? ""
                                : " instead of " + String.join(" and ", replaced))
                        + " in `laws`");
    }

    /** Returns whether the law is of a library that ships with this release. */
    boolean isShipped(PhysicsLaw law) {
        return shipped.contains(law.library());
    }

    /** Returns which of these law libraries ship with this release. */
    List<String> shipped(String... names) {
        return Stream.of(names).filter(shipped::contains).toList();
    }

    static List<String> columns(PropertyUse use) {
        return PropertyNames.columns(use.kind(), use.name());
    }

    private static boolean reads(PropertyUse use) {
        return use.access().contains(Access.READ);
    }

    private static boolean isBody(PropertyUse use, String name) {
        return use.kind().equals(WorldPrototype.BODY) && use.name().equals(name);
    }
}
