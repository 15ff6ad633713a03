// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;
import reve.core.world.FieldDescriptor;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * Reader of the keys {@code prototype} and {@code properties}, which define the properties that the
 * world's items have.
 */
final class PrototypeReader {
    /** Key of the kind of items to which the values of a property refer. */
    static final String REFERS_TO = "refersTo";

    /** Type of a property that is a function of position. */
    static final String FIELD = "field";

    /** Key of the access of laws to a property. */
    static final String ACCESS = "access";

    /** Value of {@link #ACCESS}: laws add to the property, and the engine sums in each step. */
    static final String ACCUMULATE = "accumulate";

    /** Maximum number of properties of one world. */
    static final int MAX_PROPERTIES = 1000;

    /** Keys with long lists of numbers. The search for properties skips them. */
    private static final Set<String> MESH_KEYS = Set.of("vertices", "triangles", "heights");

    /**
     * Properties that a law writes for each body, by the property that requests them. A world with
     * an item that sets the first property also gets the second one.
     */
    private static final Map<String, String> WRITTEN_WITH = Map.of("touchSensor", "touchCount");

    /** The properties that {@link WorldPrototype#withSubstances()} adds. */
    private static final Set<String> SUBSTANCE_NAMES =
            Set.of(WorldPrototype.SUBSTANCE, "substances", "pairFriction", "pairRestitution");

    /** The properties of pairs of substances that a world has if a substance states these keys. */
    private static final Map<String, String> RESISTANCES =
            Map.of(
                    "rollingFriction", WorldPrototype.PAIR_ROLLING_FRICTION,
                    "spinFriction", WorldPrototype.PAIR_SPIN_FRICTION);

    private static final Pattern PHYSICS_NAME = Pattern.compile("\\bphysics\\.(\\w+)");

    private final Problems problems;
    private final Quantities quantities;
    private final Set<String> misdeclared = new HashSet<>();

    /** A property that was read, and its node. */
    private record Declared(PropertyDescriptor descriptor, Node node) {}

    PrototypeReader(Problems problems) {
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /**
     * Returns the standard prototype that the file names, together with the declared properties.
     *
     * @param parts the parts of the files that may contain the kind {@code joint}, substances or
     *     sensors: items, prefabs, agents and rules
     * @param substances the substances that the files describe
     * @param classes the classes of items that the files declare
     */
    WorldPrototype read(
            Node root,
            List<Node> properties,
            List<Node> parts,
            List<Node> substances,
            List<Node> classes)
            throws WorldFileException {
        problems.requireAtMost(MAX_PROPERTIES, properties, "properties");
        WorldPrototype prototype = standard(root);
        boolean usesGears = uses(WorldPrototype.GEAR, properties, parts, classes);
        boolean ownJoints = declares(WorldPrototype.JOINT, properties);
        if (!ownJoints && (usesGears || uses(WorldPrototype.JOINT, properties, parts, classes))) {
            prototype = prototype.withJoints();
        }
        if (usesGears && !ownJoints) {
            prototype = prototype.withGears();
        }
        prototype = withPropertiesOnDemand(prototype, properties, parts, substances);
        List<Node> references = new ArrayList<>();
        List<Node> fields = new ArrayList<>();
        for (Node property : properties) {
            if (property.get("name").flatMap(Node::text).filter(misdeclared::contains).isEmpty()) {
                if (property.get(REFERS_TO).isPresent()) {
                    references.add(property);
                } else if (text(property, "type").equals(FIELD)) {
                    fields.add(property);
                } else {
                    prototype = extend(prototype, property);
                }
            }
        }
        return withFields(withReferences(prototype, references), fields);
    }

    /** Adds the functions of position. They come last, because they are no columns. */
    private WorldPrototype withFields(WorldPrototype prototype, List<Node> fields) {
        WorldPrototype extended = prototype;
        for (Node field : fields) {
            Optional<Unit> unit = unit(field, problems);
            Optional<Node> kind =
                    field.get("kind")
                            .filter(node -> !node.text().equals(Optional.of(WorldPrototype.WORLD)));
            kind.ifPresent(
                    node ->
                            problems.add(
                                    node,
                                    "kind: found "
                                            + node.describe()
                                            + ", expected world, because a field has one value at"
                                            + " each place and no rows"));
            for (String key : List.of("min", ACCESS)) {
                field.get(key)
                        .ifPresent(
                                node ->
                                        problems.addAtKey(
                                                node,
                                                key
                                                        + ": laws only read a field, which a law"
                                                        + " library provides; leave it out"));
            }
            if (kind.isPresent() || unit.isEmpty() || field.get("name").isEmpty()) {
                continue;
            }
            try {
                extended =
                        extended.withFields(
                                List.of(
                                        new FieldDescriptor(
                                                text(field, "name"),
                                                components(field),
                                                unit.get(),
                                                text(field, "doc"))));
            } catch (IllegalArgumentException refused) {
                refuse(field, refused.getMessage());
            }
        }
        return extended;
    }

    /**
     * Adds the properties that refer to items. They come after the others, because they may refer
     * to kinds that the file declares later.
     */
    private WorldPrototype withReferences(WorldPrototype prototype, List<Node> properties) {
        WorldPrototype standard = WorldPrototype.standard(prototype.name());
        Set<String> kinds = new HashSet<>(prototype.kinds());
        properties.forEach(property -> kinds.add(text(property, "kind")));
        List<Declared> read = new ArrayList<>();
        for (Node property : properties) {
            reference(property, standard, kinds)
                    .ifPresent(descriptor -> read.add(new Declared(descriptor, property)));
        }
        try {
            return prototype.extendedBy(read.stream().map(Declared::descriptor).toList());
        } catch (IllegalArgumentException one) {
            return extendOneByOne(prototype, read);
        }
    }

    /** Adds properties one by one, and records a problem for each that is refused. */
    private WorldPrototype extendOneByOne(WorldPrototype prototype, List<Declared> properties) {
        WorldPrototype extended = prototype;
        for (Declared property : properties) {
            try {
                extended = extended.extendedBy(List.of(property.descriptor));
            } catch (IllegalArgumentException refused) {
                refuse(property.node, refused.getMessage());
            }
        }
        return extended;
    }

    private void refuse(Node property, String message) {
        Node name = property.get("name").orElseThrow();
        problems.add(name, message);
        name.text().ifPresent(misdeclared::add);
    }

    /**
     * Reads a property that refers to items. Records a problem and returns empty if it is wrong.
     */
    private Optional<PropertyDescriptor> reference(
            Node node, WorldPrototype standard, Set<String> kinds) {
        Optional<String> name = node.get("name").flatMap(Node::text);
        Optional<String> kind = node.get("kind").flatMap(Node::text);
        Node target = node.get(REFERS_TO).orElseThrow();
        Optional<String> targetKind = target.text();
        name.ifPresent(misdeclared::add); // unless it is valid, see the end
        for (String key : List.of("type", "unit", "min", ACCESS)) {
            node.get(key)
                    .ifPresent(
                            other ->
                                    problems.addAtKey(
                                            other,
                                            key
                                                    + ": a property with `refersTo` holds references"
                                                    + " and no numbers; leave it out"));
        }
        if (name.isEmpty() || kind.isEmpty() || targetKind.isEmpty()) {
            return Optional.empty();
        }
        if (standard.hasKind(kind.get())) {
            problems.add(
                    node.get("kind").orElseThrow(),
                    "kind: items of kind `"
                            + kind.get()
                            + "` have no references of your own; declare a kind of your own, which"
                            + " refers to them");
            return Optional.empty();
        }
        if (targetKind.get().equals(WorldPrototype.WORLD) || !kinds.contains(targetKind.get())) {
            List<String> known =
                    kinds.stream()
                            .filter(each -> !each.equals(WorldPrototype.WORLD))
                            .sorted()
                            .toList();
            problems.add(
                    target,
                    "refersTo: there are no items of a kind `"
                            + Node.shorten(targetKind.get())
                            + "`; kinds are "
                            + String.join(", ", known)
                            + problems.suggestion(targetKind.get(), known));
            return Optional.empty();
        }
        try {
            var descriptor =
                    new PropertyDescriptor(
                            name.get(),
                            kind.get(),
                            ScalarType.REF,
                            components(node),
                            Unit.ONE,
                            targetKind,
                            node.get("doc").flatMap(Node::text).orElse(""));
            misdeclared.remove(name.get());
            return Optional.of(descriptor);
        } catch (IllegalArgumentException refused) {
            refuse(node, refused.getMessage());
            return Optional.empty();
        }
    }

    /**
     * Adds the properties on demand that items set or that rules of joints read. Omits those that
     * the file declares.
     */
    private WorldPrototype withPropertiesOnDemand(
            WorldPrototype prototype,
            List<Node> properties,
            List<Node> parts,
            List<Node> substances) {
        Set<String> set = new HashSet<>();
        Set<String> measured = new HashSet<>();
        for (Node part : parts) {
            findProperties(part, set, measured);
        }
        set.addAll(measured);
        if (!substances.isEmpty()) {
            set.add(WorldPrototype.SUBSTANCE);
        }
        substances.forEach(substance -> addResistances(substance, set));
        WRITTEN_WITH.forEach(
                (property, written) -> {
                    if (set.contains(property)) {
                        set.add(written);
                    }
                });
        for (Node property : properties) {
            Optional<String> name = property.get("name").flatMap(Node::text);
            name.ifPresent(set::remove);
            if (name.filter(measured::contains).isPresent()) {
                problems.add(
                        property.get("name").orElseThrow(),
                        name.get()
                                + ": a sensor of this world measures the property of this name;"
                                + " choose another name");
                misdeclared.add(name.get());
                set.add(name.get());
            }
        }
        WorldPrototype extended =
                prototype.extendedBy(
                        prototype.propertiesOnDemand().stream()
                                .filter(property -> !isOfSubstances(property))
                                .filter(property -> set.contains(property.name()))
                                .filter(property -> prototype.hasKind(property.kind()))
                                .toList());
        return withSubstances(extended, properties, set);
    }

    /**
     * Adds the properties of substances, if items have substances. Also adds the resistances that
     * substances have, and friction and restitution of single bodies, if items set them and the
     * file does not declare them.
     */
    private static WorldPrototype withSubstances(
            WorldPrototype prototype, List<Node> properties, Set<String> set) {
        List<PropertyDescriptor> own =
                prototype.ownContacts().stream()
                        .filter(property -> set.contains(property.name()))
                        .toList();
        boolean isDeclared =
                properties.stream()
                        .anyMatch(
                                property ->
                                        SUBSTANCE_NAMES.contains(text(property, "name"))
                                                || text(property, "kind")
                                                        .equals(WorldPrototype.SUBSTANCE_PAIR));
        if (isDeclared || own.isEmpty() && SUBSTANCE_NAMES.stream().noneMatch(set::contains)) {
            return prototype;
        }
        WorldPrototype extended = prototype.withSubstances().extendedBy(own);
        return extended.extendedBy(
                extended.resistancesOfSubstances().stream()
                        .filter(property -> set.contains(property.name()))
                        .toList());
    }

    /** Adds the names of the properties for the resistances that a substance or its pairs state. */
    private static void addResistances(Node substance, Set<String> set) {
        RESISTANCES.forEach(
                (key, property) -> {
                    boolean ofPairs =
                            substance.get("with").map(Node::children).orElse(List.of()).stream()
                                    .anyMatch(pair -> pair.get(key).isPresent());
                    if (ofPairs || substance.get(key).isPresent()) {
                        set.add(property);
                    }
                });
    }

    private static String text(Node property, String key) {
        return property.get(key).flatMap(Node::text).orElse("");
    }

    private static boolean isOfSubstances(PropertyDescriptor property) {
        return property.kind().equals(WorldPrototype.SUBSTANCE_PAIR)
                || SUBSTANCE_NAMES.contains(property.name());
    }

    /**
     * Adds the keys of all mappings under the key {@code physics} in a node. Also adds the names
     * after {@code physics.} in the rules of joints.
     *
     * @param measured receives the names of the properties that instruments measure
     */
    private static void findProperties(Node node, Set<String> found, Set<String> measured) {
        if (node.key().equals("physics") && node.isMapping()) {
            node.children().forEach(value -> found.add(value.key()));
        } else if (isOf(WorldPrototype.JOINT, node) && node.get("is").isPresent()) {
            Matcher names = PHYSICS_NAME.matcher(node.get("is").flatMap(Node::text).orElse(""));
            while (names.find()) {
                found.add(names.group(1));
            }
        } else if (node.key().equals("sensors") && node.isMapping()) {
            node.children().forEach(sensor -> measured.addAll(InstrumentReader.measured(sensor)));
        } else if (!MESH_KEYS.contains(node.key())) {
            node.children().forEach(child -> findProperties(child, found, measured));
        }
    }

    /**
     * Returns whether the files use a standard kind on demand: they contain it or have a class of
     * it, and do not declare properties of it.
     */
    private static boolean uses(
            String kind, List<Node> properties, List<Node> parts, List<Node> classes) {
        return !declares(kind, properties)
                && (parts.stream().anyMatch(part -> has(kind, part))
                        || classes.stream()
                                .map(ClassReader::parent)
                                .anyMatch(parent -> parent.equals(Optional.of(kind))));
    }

    private static boolean declares(String kind, List<Node> properties) {
        return properties.stream().anyMatch(property -> isOf(kind, property));
    }

    private static boolean isOf(String kind, Node node) {
        return node.get("kind").flatMap(Node::text).equals(Optional.of(kind));
    }

    /** Returns whether a node or a nested node is an item or a rule of a kind. */
    private static boolean has(String kind, Node node) {
        return isOf(kind, node)
                || !MESH_KEYS.contains(node.key())
                        && node.children().stream().anyMatch(child -> has(kind, child));
    }

    /** Returns the names of the properties whose declaration was refused. */
    Set<String> misdeclared() {
        return misdeclared;
    }

    /**
     * Returns the unit under the key {@code unit}, or the unit 1 if the key is missing. Records a
     * problem and returns empty if the unit is wrong.
     */
    static Optional<Unit> unit(Node owner, Problems problems) {
        Optional<Node> node = owner.get("unit");
        if (node.isEmpty()) {
            return Optional.of(Unit.ONE);
        }
        try {
            return node.get().scalar().map(Object::toString).map(Unit::parse);
        } catch (IllegalArgumentException notAUnit) {
            problems.add(node.get(), notAUnit.getMessage());
            return Optional.empty();
        }
    }

    /**
     * Returns the number under the key {@code components}, or 1 if it is missing or wrong. The
     * schema check reports a wrong number.
     */
    static int components(Node owner) {
        return Math.clamp(
                owner.get("components").flatMap(Node::number).orElse(1.0).longValue(),
                1,
                PropertyDescriptor.MAX_COMPONENTS);
    }

    private static WorldPrototype standard(Node root) {
        boolean single = root.get("prototype").flatMap(Node::text).equals(Optional.of("si-f32"));
        return WorldPrototype.standard(single ? "si-f32" : "si-f64");
    }

    private double minimum(Node property, Unit unit) {
        return property.get("min")
                .flatMap(node -> quantities.number(node, unit))
                .orElse(Double.NEGATIVE_INFINITY);
    }

    /**
     * Returns whether a property is a sum of what laws add. Records a problem and returns false if
     * it cannot be one.
     */
    private boolean accumulated(Node property, WorldPrototype prototype) {
        Optional<Node> access =
                property.get(ACCESS).filter(node -> node.text().equals(Optional.of(ACCUMULATE)));
        if (access.isEmpty()) {
            return false;
        }
        String kind = text(property, "kind");
        if (prototype.isStandard(kind, text(property, "name"))) {
            problems.add(
                    access.get(),
                    ACCESS
                            + ": `"
                            + text(property, "name")
                            + "` of kind "
                            + kind
                            + " is a standard property, whose access the engine knows; leave it"
                            + " out");
            return false;
        }
        Optional<Node> type =
                property.get("type").filter(node -> !node.text().equals(Optional.of("real")));
        type.ifPresent(
                node ->
                        problems.add(
                                node,
                                "type: found "
                                        + node.describe()
                                        + ", expected real, because laws sum only real numbers"));
        property.get("min")
                .ifPresent(
                        node ->
                                problems.addAtKey(
                                        node,
                                        "min: a sum of what laws add has no least value; leave it"
                                                + " out"));
        return type.isEmpty();
    }

    private WorldPrototype extend(WorldPrototype prototype, Node node) {
        Optional<String> name = node.get("name").flatMap(Node::text);
        Optional<String> kind = node.get("kind").flatMap(Node::text);
        Optional<Unit> unit = unit(node, problems);
        if (name.isEmpty() || kind.isEmpty() || unit.isEmpty()) {
            name.ifPresent(misdeclared::add);
            return prototype;
        }
        ScalarType type =
                switch (node.get("type").flatMap(Node::text).orElse("real")) {
                    case "i32" -> ScalarType.I32;
                    case "u32" -> ScalarType.U32;
                    default -> prototype.realType();
                };
        boolean accumulated = accumulated(node, prototype);
        try {
            return prototype.extendedBy(
                    List.of(
                            new PropertyDescriptor(
                                    name.get(),
                                    kind.get(),
                                    type,
                                    components(node),
                                    unit.get(),
                                    Optional.empty(),
                                    accumulated
                                            ? Double.NEGATIVE_INFINITY
                                            : minimum(node, unit.get()),
                                    accumulated,
                                    node.get("doc").flatMap(Node::text).orElse(""))));
        } catch (IllegalArgumentException refused) {
            problems.add(node.get("name").orElseThrow(), refused.getMessage());
            misdeclared.add(name.get());
            return prototype;
        }
    }
}
