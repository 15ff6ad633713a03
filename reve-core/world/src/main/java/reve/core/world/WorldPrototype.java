// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static reve.core.world.ScalarType.F64;
import static reve.core.world.ScalarType.I32;
import static reve.core.world.ScalarType.REF;
import static reve.core.world.ScalarType.U32;

import reve.core.unit.Unit;

import java.util.ArrayList;
import java.util.Collections;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.Stream;

/**
 * The declared properties and symbols of the items of a world, by kind. It is the schema that a
 * world, its designers and the engine share. Immutable.
 *
 * <p>{@link #properties()} belong to the physics aspect. {@link #physicalProperties()} belong to
 * the physical aspect (place, shape and appearance), which every body has, including scenery.
 */
public final class WorldPrototype {

    /** The kind of items that have a place in space. */
    public static final String BODY = "body";

    /** The kind of springs, which connect two bodies. */
    public static final String SPRING = "spring";

    /** The kind of triangles with bodies as corners. */
    public static final String SURFACE = "surface";

    /** The kind with exactly one row, for constants of the world. */
    public static final String WORLD = "world";

    /**
     * The kind of joints between bodies. Only worlds that use joints have this kind, see {@link
     * #withJoints()}.
     */
    public static final String JOINT = "joint";

    /**
     * Name of the property for the specific force of a body [m/s²], in the body's own axes. It is
     * the mean acceleration during the last frame minus the acceleration of gravity. The phase
     * DERIVE computes it for bodies with an {@link Instrument.Imu}.
     */
    public static final String SPECIFIC_FORCE = "specificForce";

    /**
     * Name of the property for the angular velocity of a body [rad/s], in the body's own axes, at
     * the end of the last frame. The phase DERIVE computes it for bodies with an {@link
     * Instrument.Imu}.
     */
    public static final String ANGULAR_RATE = "angularRate";

    /**
     * Name of the property for the force on a body at its contacts [N], in the axes of the world.
     * Laws that exert forces write it, such as {@code sphere_contact}.
     */
    public static final String CONTACT_FORCE = "contactForce";

    /**
     * Name of the property for the force on a body at its contacts [N], in the axes of the world.
     * Laws that move bodies write it, such as {@code rigid_contact}.
     */
    public static final String REACTION_FORCE = "reactionForce";

    /**
     * The kind of gears between two joints. Only worlds that use gears have this kind, see {@link
     * #withGears()}.
     */
    public static final String GEAR = "gear";

    /**
     * Name of the property for the code of a body's substance, see {@link #withSubstances()}; 0 for
     * none.
     */
    public static final String SUBSTANCE = "substance";

    /**
     * The kind of the rows that contain friction and restitution of substances and of pairs of
     * substances. Only worlds that use substances have this kind, see {@link #withSubstances()}.
     */
    public static final String SUBSTANCE_PAIR = "substancePair";

    /** Beginning of the name of an item with the values of one substance. */
    public static final String SUBSTANCE_PREFIX = "substance ";

    /** Name of the property for the lever arm of a substance or a pair against rolling [m]. */
    public static final String PAIR_ROLLING_FRICTION = "pairRollingFriction";

    /** Name of the property for the lever arm of a substance or a pair against spinning [m]. */
    public static final String PAIR_SPIN_FRICTION = "pairSpinFriction";

    /** Name of the property for the mass of a body. Laws do not move a body of mass 0. */
    public static final String MASS = "mass";

    private final String name;
    private final ScalarType realType;
    private final List<PropertyDescriptor> properties;
    private final List<PropertyDescriptor> physicalProperties;
    private final List<FieldDescriptor> fields;
    private final List<SymbolDescriptor> symbols;
    private final ClassHierarchy classes;
    private final List<String> kinds;
    private final Map<String, PropertyDescriptor> byName = new HashMap<>();
    private final Map<String, SymbolDescriptor> symbolsByName = new HashMap<>();

    /** The properties that refer to items, by kind. Every kind has a key. */
    private final Map<String, List<PropertyDescriptor>> references = new HashMap<>();

    private WorldPrototype(
            String name,
            ScalarType realType,
            List<PropertyDescriptor> properties,
            List<FieldDescriptor> fields,
            List<SymbolDescriptor> symbols,
            List<ItemClass> classes) {
        this.name = name;
        this.realType = realType;
        this.properties = List.copyOf(properties);
        this.fields = List.copyOf(fields);
        this.symbols = List.copyOf(symbols);
        this.physicalProperties = standardPhysical(realType);
        var distinctKinds = new LinkedHashSet<String>();
        for (PropertyDescriptor property : this.properties) {
            addUnique(property);
            distinctKinds.add(property.kind());
            List<PropertyDescriptor> ofKind =
                    references.computeIfAbsent(property.kind(), kind -> new ArrayList<>());
            if (property.type() == REF) {
                ofKind.add(property);
            }
        }
        for (SymbolDescriptor symbol : this.symbols) {
            if (symbolsByName.putIfAbsent(symbol.name(), symbol) != null) {
                throw new IllegalArgumentException(
                        "symbol " + symbol.name() + " is declared twice");
            }
        }
        physicalProperties.forEach(this::addUnique);
        requireOtherNames(this.fields);
        this.kinds = List.copyOf(distinctKinds);
        this.classes = classes.isEmpty() ? ClassHierarchy.NONE : hierarchy(classes);
    }

    private ClassHierarchy hierarchy(List<ItemClass> declared) {
        if (symbolsByName.containsKey(StandardSymbols.CLASSES)) {
            throw new IllegalArgumentException(
                    "symbol "
                            + StandardSymbols.CLASSES
                            + " is derived by a world with classes; it cannot be declared");
        }
        for (ItemClass each : declared) {
            each.symbols()
                    .forEach((symbol, value) -> requireInheritable(each.name(), symbol, value));
        }
        return new ClassHierarchy(declared, kinds);
    }

    /**
     * Returns the prototype of the given name. The default {@code si-f64} has 64-bit numbers. The
     * prototype {@code si-f32} has 32-bit numbers and is faster.
     *
     * @throws IllegalArgumentException for any other name
     */
    public static WorldPrototype standard(String name) {
        ScalarType real =
                switch (name) {
                    case "si-f64" -> ScalarType.F64;
                    case "si-f32" -> ScalarType.F32;
                    default ->
                            throw new IllegalArgumentException(
                                    "prototype \"" + name + "\": expected si-f64 or si-f32");
                };
        return new WorldPrototype(
                name, real, standardPhysics(real), List.of(), List.of(), List.of());
    }

    /**
     * Returns a copy with the kind {@code joint} and its properties, for worlds that use joints.
     */
    public WorldPrototype withJoints() {
        return extendedBy(joints(realType));
    }

    /**
     * Returns a copy with the kind {@code gear} and its properties, for worlds that use gears.
     *
     * @throws IllegalArgumentException if this prototype has no kind {@code joint}
     */
    public WorldPrototype withGears() {
        return extendedBy(gears(realType));
    }

    /**
     * Returns whether a property is one of those that {@link #withJoints()} or {@link #withGears()}
     * adds.
     */
    public boolean isOfJoints(PropertyDescriptor property) {
        return property.kind().equals(JOINT) && joints(realType).contains(property)
                || property.kind().equals(GEAR) && gears(realType).contains(property);
    }

    /**
     * Returns a copy with the substances of bodies: the property {@link #SUBSTANCE} and the kind
     * {@link #SUBSTANCE_PAIR}.
     */
    public WorldPrototype withSubstances() {
        return extendedBy(substances(realType));
    }

    /** Returns whether this prototype has the property that {@link #withSubstances()} adds. */
    public boolean hasSubstances() {
        return find(BODY, SUBSTANCE).filter(substances(realType)::contains).isPresent();
    }

    /**
     * Returns {@code friction} and {@code restitution} of bodies. A world with substances has them
     * if an item sets them. In such a world, the value 0 means that the value is not set.
     */
    public List<PropertyDescriptor> ownContacts() {
        return List.of(
                notNegative(BODY, "friction", realType, 1, "1", "Coefficient of friction."),
                notNegative(BODY, "restitution", realType, 1, "1", "Coefficient of restitution."));
    }

    /**
     * Returns the resistances of substances to rolling and to spinning. A world with substances has
     * each of them if one of its substances states it. The value 0 of such a property, and of
     * {@code rollingFriction} or {@code spinFriction} of a body, then means that the value is not
     * set.
     */
    public List<PropertyDescriptor> resistancesOfSubstances() {
        return List.of(
                notNegative(
                        SUBSTANCE_PAIR,
                        PAIR_ROLLING_FRICTION,
                        realType,
                        1,
                        "m",
                        "Lever arm against rolling; 0: not set."),
                notNegative(
                        SUBSTANCE_PAIR,
                        PAIR_SPIN_FRICTION,
                        realType,
                        1,
                        "m",
                        "Lever arm against spinning; 0: not set."));
    }

    /**
     * Returns the properties that a world has only if it uses them:
     *
     * <ul>
     *   <li>properties of contacts of bodies, except {@code friction} and {@code restitution}
     *   <li>substances, and their resistances to rolling and spinning
     *   <li>springs, damping, friction, rotors, servos and speeds of joints
     *   <li>measurements of the instruments of bodies
     * </ul>
     */
    public List<PropertyDescriptor> propertiesOnDemand() {
        List<PropertyDescriptor> properties = new ArrayList<>(contacts(realType));
        properties.addAll(loadsOfJoints(realType));
        properties.addAll(measurements(realType));
        properties.addAll(substances(realType));
        properties.addAll(resistancesOfSubstances());
        return properties;
    }

    /**
     * Returns whether a kind has a standard property of this name, also if this prototype does not
     * contain it. The engine limits the access of laws to such a property.
     */
    public boolean isStandard(String kind, String propertyName) {
        return Stream.of(
                        standardPhysics(realType),
                        joints(realType),
                        gears(realType),
                        propertiesOnDemand(),
                        ownContacts())
                .flatMap(List::stream)
                .anyMatch(
                        property ->
                                property.kind().equals(kind)
                                        && property.name().equals(propertyName));
    }

    /** Returns the names of the properties of a body that an instrument of the body needs. */
    public static List<String> measuredBy(Instrument instrument) {
        return switch (instrument) {
            case Instrument.Imu _ -> List.of(SPECIFIC_FORCE, ANGULAR_RATE);
            case Instrument.Lidar _, Instrument.Provided _ -> List.of();
            case Instrument.ContactForce _ -> List.of(CONTACT_FORCE, REACTION_FORCE);
        };
    }

    /**
     * Returns a copy with further physics properties, which the designer of a world declares. A
     * property of an unknown kind adds this kind.
     *
     * @throws IllegalArgumentException if a name is taken, or a reference names a kind that does
     *     not exist
     */
    public WorldPrototype extendedBy(List<PropertyDescriptor> more) {
        var all = new ArrayList<>(properties);
        all.addAll(more);
        var extended = new WorldPrototype(name, realType, all, fields, symbols, classes.all());
        for (PropertyDescriptor property : more) {
            property.refersTo()
                    .filter(kind -> !extended.kinds.contains(kind))
                    .ifPresent(
                            kind -> {
                                throw new IllegalArgumentException(
                                        "property "
                                                + property.name()
                                                + " refers to kind "
                                                + kind
                                                + ", which does not exist; kinds are "
                                                + extended.kinds);
                            });
        }
        return extended;
    }

    /**
     * Returns a copy with further fields, which the designer of a world declares.
     *
     * @throws IllegalArgumentException if a name is taken by a property or another field
     */
    public WorldPrototype withFields(List<FieldDescriptor> more) {
        var all = new ArrayList<>(fields);
        all.addAll(more);
        return new WorldPrototype(name, realType, properties, all, symbols, classes.all());
    }

    /** Returns the declared fields, in the order of declaration. */
    public List<FieldDescriptor> fields() {
        return fields;
    }

    /**
     * Returns a copy with declared types of semantic symbols. Undeclared symbols may have any type.
     *
     * @throws IllegalArgumentException if a symbol is declared twice
     */
    public WorldPrototype withSymbols(List<SymbolDescriptor> more) {
        var all = new ArrayList<>(symbols);
        all.addAll(more);
        return new WorldPrototype(name, realType, properties, fields, all, classes.all());
    }

    /**
     * Returns a copy with these classes of items instead of the previous ones.
     *
     * @throws IllegalArgumentException naming the class if it is declared twice, has the name of a
     *     kind, has an unknown parent, is above itself, or has a symbol that does not fit
     */
    public WorldPrototype withClasses(List<ItemClass> declared) {
        return new WorldPrototype(name, realType, properties, fields, symbols, declared);
    }

    /**
     * Checks a symbol that the items of a class are to inherit.
     *
     * @param itemClass name of the class, for messages
     * @return the value in the form in which it is stored
     * @throws IllegalArgumentException naming class and symbol if the symbol is a standard one, or
     *     the value is not a value of this symbol
     */
    public Object requireInheritable(String itemClass, String symbol, Object value) {
        return Values.requireInheritable(this, itemClass, symbol, value);
    }

    /** Returns the hierarchy of the declared classes of items. */
    public ClassHierarchy classes() {
        return classes;
    }

    /** Returns the name of the prototype, for example {@code si-f64}. */
    public String name() {
        return name;
    }

    /**
     * Returns the type of real numbers such as positions and forces: {@link ScalarType#F64} or
     * {@link ScalarType#F32}.
     */
    public ScalarType realType() {
        return realType;
    }

    /**
     * Returns the properties of the physics aspect in a fixed order, beginning with the standard
     * properties.
     */
    public List<PropertyDescriptor> properties() {
        return properties;
    }

    /** Returns the declared semantic symbols, in the order of declaration. */
    public List<SymbolDescriptor> symbols() {
        return symbols;
    }

    /** Returns the declaration of a semantic symbol. */
    public Optional<SymbolDescriptor> symbol(String symbolName) {
        return Optional.ofNullable(symbolsByName.get(symbolName));
    }

    /** Returns the properties of the physical aspect of {@code body}. */
    public List<PropertyDescriptor> physicalProperties() {
        return physicalProperties;
    }

    /**
     * Returns all kinds in the order of their first property: body, spring, surface, world, then
     * the designer's own kinds.
     */
    public List<String> kinds() {
        return kinds;
    }

    /** Returns whether the kind exists. */
    public boolean hasKind(String kind) {
        return references.containsKey(kind);
    }

    /** Returns the reference properties of a kind, in their order. */
    public List<PropertyDescriptor> references(String kind) {
        return Collections.unmodifiableList(references.getOrDefault(kind, List.of()));
    }

    /** Returns the physics property of that kind and name. */
    public Optional<PropertyDescriptor> find(String kind, String propertyName) {
        return Optional.ofNullable(byName.get(propertyName))
                .filter(property -> property.kind().equals(kind))
                .filter(property -> !physicalProperties.contains(property));
    }

    private void requireOtherNames(List<FieldDescriptor> declared) {
        var names = new HashSet<String>();
        for (FieldDescriptor field : declared) {
            if (byName.containsKey(field.name())) {
                throw new IllegalArgumentException(
                        "field "
                                + field.name()
                                + ": the name is already taken by a property of kind "
                                + byName.get(field.name()).kind());
            }
            if (!names.add(field.name())) {
                throw new IllegalArgumentException("field " + field.name() + " is declared twice");
            }
        }
    }

    private void addUnique(PropertyDescriptor property) {
        PropertyDescriptor other = byName.putIfAbsent(property.name(), property);
        if (other != null) {
            throw new IllegalArgumentException(
                    "property "
                            + property.name()
                            + " of kind "
                            + property.kind()
                            + ": the name is already taken by a property of kind "
                            + other.kind());
        }
    }

    private static List<PropertyDescriptor> standardPhysics(ScalarType real) {
        return List.of(
                notNegative(BODY, "mass", real, 1, "kg", "Inertial mass; 0 means immovable."),
                number(BODY, "charge", real, 1, "C", "Electric charge."),
                number(BODY, "velocity", real, 3, "m/s", "Velocity of the centre."),
                number(BODY, "acceleration", real, 3, "m/s^2", "Acceleration in the last step."),
                number(BODY, "externalForce", real, 3, "N", "Sum of the forces that laws applied."),
                number(
                        BODY,
                        "appliedForce",
                        real,
                        3,
                        "N",
                        "Force given from outside, added to the laws' sum."),
                notNegative(BODY, "radius", real, 1, "m", "Radius that laws of contact use."),
                number(BODY, "angularVelocity", real, 3, "rad/s", "Angular velocity."),
                notNegative(BODY, "inertia", real, 3, "kg*m^2", "Principal moments of inertia."),
                number(BODY, "torque", real, 3, "N*m", "Sum of the torques that laws applied."),
                number(
                        BODY,
                        "dragCoefficient",
                        real,
                        1,
                        "kg/m",
                        "Quadratic drag: force per squared speed."),
                number(
                        BODY,
                        "linearDragCoefficient",
                        real,
                        1,
                        "kg/s",
                        "Linear drag: force per speed."),
                number(SPRING, "springConstant", real, 1, "N/m", "Hooke's constant."),
                notNegative(SPRING, "length", real, 1, "m", "Rest length."),
                number(
                        SPRING,
                        "dampingConstant",
                        real,
                        1,
                        "N*s/m",
                        "Viscous damping along the spring."),
                reference(SPRING, "end1", 1, "The body at one end."),
                reference(SPRING, "end2", 1, "The body at the other end."),
                reference(SURFACE, "vertices", 3, "The bodies at the corners."),
                notNegative(SURFACE, "hardness", real, 1, "N/m", "Stiffness against penetration."),
                notNegative(
                        SURFACE,
                        "surfaceDamping",
                        real,
                        1,
                        "N*s/m",
                        "Damping against penetration."),
                notNegative(SURFACE, "frictionCoefficient", real, 1, "1", "Coulomb friction."),
                number(
                        WORLD,
                        "gravitationalConstant",
                        real,
                        1,
                        "m^3/(kg*s^2)",
                        "Newton's constant."),
                number(WORLD, "gravity", real, 3, "m/s^2", "Uniform gravity."),
                notNegative(
                        WORLD,
                        "softening",
                        real,
                        1,
                        "m",
                        "Length below which gravitation is softened."),
                number(WORLD, "coulombConstant", real, 1, "N*m^2/C^2", "Coulomb's constant."),
                number(WORLD, "electricField", real, 3, "V/m", "Uniform electric field."),
                number(WORLD, "magneticField", real, 3, "T", "Uniform magnetic flux density."));
    }

    private static List<PropertyDescriptor> joints(ScalarType real) {
        return List.of(
                reference(JOINT, "joined", 2, "The two bodies."),
                number(JOINT, "jointType", I32, 1, "1", "Fixed, ball, hinge, slider, distance."),
                number(JOINT, "anchor", real, 3, "m", "Place in the frame of the first body."),
                number(JOINT, "axis", real, 3, "1", "Of a hinge or slider, in the same frame."),
                number(JOINT, "angleLimits", real, 2, "1", "Least and greatest angle of a hinge."),
                number(JOINT, "travelLimits", real, 2, "m", "Least and greatest travel or length."),
                number(JOINT, "motorSpeed", real, 1, "rad/s", "Speed of a hinge's motor."),
                notNegative(JOINT, "motorTorque", real, 1, "N*m", "Greatest torque of the motor."),
                number(JOINT, "driveSpeed", real, 1, "m/s", "Speed of a slider's drive."),
                notNegative(JOINT, "driveForce", real, 1, "N", "Greatest force of the drive."),
                notNegative(JOINT, "breakingForce", real, 1, "N", "Greatest force; 0: any."),
                number(JOINT, "otherAnchor", real, 3, "m", "Place in the second body's frame."),
                number(JOINT, "otherTurn", real, 4, "1", "Second body's rotation at rest."),
                number(JOINT, "jointForce", real, 3, "N", "Force on the second body."),
                number(JOINT, "jointTorque", real, 3, "N*m", "Torque on the second body."),
                number(JOINT, "jointAngle", real, 1, "1", "Angle of a hinge."),
                number(JOINT, "jointTravel", real, 1, "m", "Travel of a slider, or length."),
                number(JOINT, "broken", I32, 1, "1", "1 if the joint is broken."));
    }

    private static List<PropertyDescriptor> contacts(ScalarType real) {
        return List.of(
                notNegative(BODY, "rollingFriction", real, 1, "m", "Lever arm; stops rolling."),
                notNegative(BODY, "touchLayer", I32, 1, "1", "Layer of contacts, 0 to 31."),
                number(BODY, "passesLayers", I32, 1, "1", "Layers it passes through, as bits."),
                number(BODY, "touchSensor", I32, 1, "1", "1: counts what touches it, no force."),
                number(BODY, "partOfBody", I32, 1, "1", "1: collides as part of its carrier."),
                number(BODY, "touchCount", I32, 1, "1", "Number of shapes that touch it."),
                number(BODY, "asleep", I32, 1, "1", "1 while it rests and is not moved."),
                notNegative(BODY, "spinFriction", real, 1, "m", "Lever arm; stops spinning."));
    }

    private static List<PropertyDescriptor> loadsOfJoints(ScalarType real) {
        return List.of(
                notNegative(JOINT, "angleDamping", real, 1, "N*m*s", "Torque per angular speed."),
                notNegative(JOINT, "travelDamping", real, 1, "N*s/m", "Force per speed."),
                notNegative(JOINT, "angleFriction", real, 1, "N*m", "Torque of dry friction."),
                notNegative(JOINT, "travelFriction", real, 1, "N", "Force of dry friction."),
                notNegative(JOINT, "angleStiffness", real, 1, "N*m", "Torque per angle."),
                notNegative(JOINT, "travelStiffness", real, 1, "N/m", "Force per travel."),
                number(JOINT, "restAngle", real, 1, "1", "Angle without torque of the spring."),
                number(JOINT, "restTravel", real, 1, "m", "Travel without force of the spring."),
                notNegative(JOINT, "rotorInertia", real, 1, "kg*m^2", "Added about the axis."),
                notNegative(JOINT, "rotorMass", real, 1, "kg", "Added along the axis."),
                number(JOINT, "angleSpeed", real, 1, "rad/s", "Speed of a hinge's angle."),
                number(JOINT, "travelSpeed", real, 1, "m/s", "Speed of a slider's travel."),
                number(JOINT, "motorAngle", real, 1, "1", "Angle to which the motor moves."),
                notNegative(JOINT, "motorStiffness", real, 1, "N*m", "Torque per angle."),
                notNegative(JOINT, "motorDamping", real, 1, "N*m*s", "Torque per speed."),
                number(JOINT, "driveTravel", real, 1, "m", "Travel to which the drive moves."),
                notNegative(JOINT, "driveStiffness", real, 1, "N/m", "Force per travel."),
                notNegative(JOINT, "driveDamping", real, 1, "N*s/m", "Force per speed."),
                notNegative(JOINT, "ropeLength", real, 1, "m", "Length of a rope."),
                number(JOINT, "offsetLeast", real, 3, "m", "Least offsets of six-axis."),
                number(JOINT, "offsetGreatest", real, 3, "m", "Below the least: no limit."),
                number(JOINT, "turnLeast", real, 3, "1", "Least angles of six-axis."),
                number(JOINT, "turnGreatest", real, 3, "1", "Below the least: no limit."));
    }

    private static List<PropertyDescriptor> gears(ScalarType real) {
        return List.of(
                new PropertyDescriptor(
                        "geared",
                        GEAR,
                        REF,
                        2,
                        Unit.parse("1"),
                        Optional.of(JOINT),
                        "The two joints."),
                number(GEAR, "gearRatio", real, 1, "1", "Angle or travel of one per other."),
                number(GEAR, "offsetAngle", real, 1, "1", "Angle of the first one at 0."),
                number(GEAR, "offsetTravel", real, 1, "m", "Travel of the first one at 0."),
                number(GEAR, "gearTorque", real, 1, "N*m", "Torque on a first hinge."),
                number(GEAR, "gearForce", real, 1, "N", "Force on a first slider."),
                number(GEAR, "gearPlaces", real, 2, "1", "Angles with turns, or travels."));
    }

    private static List<PropertyDescriptor> measurements(ScalarType real) {
        return List.of(
                number(BODY, SPECIFIC_FORCE, real, 3, "m/s^2", "Of an IMU, in the body's axes."),
                number(BODY, ANGULAR_RATE, real, 3, "rad/s", "Of an IMU, in the body's axes."),
                number(BODY, CONTACT_FORCE, real, 3, "N", "Force of contacts, by force laws."),
                number(BODY, REACTION_FORCE, real, 3, "N", "Force of contacts, by movers."));
    }

    private static List<PropertyDescriptor> substances(ScalarType real) {
        return List.of(
                number(BODY, SUBSTANCE, I32, 1, "1", "Code of its substance; 0: none."),
                number(SUBSTANCE_PAIR, "substances", I32, 2, "1", "Codes of two; 0: any other."),
                notNegative(SUBSTANCE_PAIR, "pairFriction", real, 1, "1", "Friction; 0: not set."),
                notNegative(
                        SUBSTANCE_PAIR, "pairRestitution", real, 1, "1", "Restitution, likewise."));
    }

    private static List<PropertyDescriptor> standardPhysical(ScalarType real) {
        return List.of(
                number(
                        BODY,
                        "position",
                        real,
                        3,
                        "m",
                        "Place of the item's origin in the world frame."),
                number(BODY, "orientation", real, 4, "1", "Rotation as a unit quaternion xyzw."),
                notNegative(
                        BODY,
                        "size",
                        F64,
                        3,
                        "m",
                        "Extent of the shape along the item's own axes."),
                number(BODY, "shape", I32, 1, "1", "Code of the shape, see Shape.code()."),
                number(BODY, "colour", U32, 1, "1", "Colour, see Colour.rgba()."),
                number(
                        BODY,
                        "boundsMin",
                        F64,
                        3,
                        "m",
                        "Lower corner of the box around the item; derived."),
                number(
                        BODY,
                        "boundsMax",
                        F64,
                        3,
                        "m",
                        "Upper corner of the box around the item; derived."));
    }

    private static PropertyDescriptor number(
            String kind, String name, ScalarType type, int components, String unit, String doc) {
        return new PropertyDescriptor(
                name, kind, type, components, Unit.parse(unit), Optional.empty(), doc);
    }

    /** Returns a property with the minimum 0. */
    private static PropertyDescriptor notNegative(
            String kind, String name, ScalarType type, int components, String unit, String doc) {
        return new PropertyDescriptor(
                name, kind, type, components, Unit.parse(unit), Optional.empty(), 0, doc);
    }

    private static PropertyDescriptor reference(
            String kind, String name, int components, String doc) {
        return new PropertyDescriptor(
                name, kind, REF, components, Unit.parse("1"), Optional.of(BODY), doc);
    }
}
