// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.file.YamlWriter;
import reve.core.file.YamlWriter.Numeral;
import reve.core.urdf.RobotModel.Form;
import reve.core.urdf.RobotModel.Geometry;
import reve.core.urdf.RobotModel.Joint;
import reve.core.urdf.RobotModel.JointType;
import reve.core.urdf.RobotModel.Link;
import reve.core.urdf.RobotModel.Surface;
import reve.core.world.Pose;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;

/**
 * Writer of a robot as items of a world file. It writes these items:
 *
 * <ul>
 *   <li>a body for each rigid part; its centre of mass and its principal axes are the origin and
 *       axes of the item
 *   <li>the shapes of the part, as items that are attached to the body
 *   <li>the joints, with the actions that drive them
 *   <li>gears between joints that the file couples
 * </ul>
 */
final class RobotWorld {
    private static final int LAYER = 1;
    private static final String HIDDEN = "#00000000";

    /** Rotation from +Z up, as in URDF, to +Y up, as in worlds. */
    private static final Pose Z_UP = new Pose(0, 0, 0, -Math.sqrt(0.5), 0, 0, Math.sqrt(0.5));

    private final RobotModel model;
    private final ShapeWriter shapes;
    private final RobotImport.Options options;
    private final List<String> notes;
    private final Pose up;
    private final RigidTree tree;
    private final Optional<TouchLayers> layers;
    private final Set<String> names = new TreeSet<>(Set.of("world", "ground"));
    private final Map<String, String> bodyNames = new HashMap<>();
    private final Map<String, Pose> bodyPoses = new HashMap<>();

    /** Names of the items of hinges and sliders, by the names of the joints in the file. */
    private final Map<String, String> jointNames = new HashMap<>();

    private final List<Map<String, Object>> items = new ArrayList<>();
    private double lowest = Double.POSITIVE_INFINITY;

    RobotWorld(
            RobotModel model, MeshFiles meshes, RobotImport.Options options, List<String> notes) {
        this.model = model;
        this.shapes = new ShapeWriter(meshes, notes);
        this.options = options;
        this.notes = notes;
        this.up = options.zUp() ? Z_UP : Pose.ORIGIN;
        this.tree = new RigidTree(model, up, notes);
        this.layers = model.scene().map(this::layers);
        if (model.scene().isPresent()) {
            names.remove("ground");
        }
    }

    private TouchLayers layers(RobotModel.Scene scene) {
        return new TouchLayers(
                scene.scenery().stream().map(RobotModel.Scenery::surface).toList(),
                tree.bodies().stream().flatMap(body -> surface(body).stream()).toList(),
                notes);
    }

    private static Optional<Surface> surface(RigidTree.Body body) {
        return body.links().stream()
                .flatMap(link -> link.surface().stream())
                .reduce(
                        (one, other) ->
                                new Surface(
                                        one.type() | other.type(),
                                        one.affinity() | other.affinity(),
                                        one.friction(),
                                        one.spinning(),
                                        one.rolling()));
    }

    /** Returns the text of the file with the items of the robot. */
    String write() {
        for (RigidTree.Body body : tree.bodies()) {
            body(body);
        }
        for (Joint joint : tree.joints()) {
            joint(joint);
        }
        model.couplings().forEach(this::gear);
        for (String ignored : model.ignored()) {
            notes.add("not imported: " + ignored);
        }
        Map<String, Object> file = new LinkedHashMap<>();
        if (layers.isPresent() && layers.get().hasFriction()) {
            Map<String, Object> friction = new LinkedHashMap<>();
            friction.put("name", "friction");
            friction.put("kind", "body");
            friction.put("min", Numeral.of(0));
            friction.put("doc", "Coefficient of friction.");
            file.put("properties", List.of(friction));
        }
        file.put("items", items);
        return YamlWriter.write(file);
    }

    int bodyCount() {
        return (int) tree.bodies().stream().filter(body -> !isNeedless(body)).count();
    }

    int jointCount() {
        return (int) tree.joints().stream().filter(joint -> type(joint).isPresent()).count();
    }

    /**
     * Returns the smallest Y coordinate of the bounding boxes of all shapes [m]; infinity if there
     * are no shapes.
     */
    double lowest() {
        return lowest;
    }

    boolean isFixed() {
        RigidTree.Body root = tree.bodyOf(model.root());
        return switch (options.base()) {
            case FIXED -> true;
            case FREE -> !root.hasMass();
            case AUTOMATIC -> !root.hasMass() || model.root().equals("world");
        };
    }

    /** Converts a vector from the axes of the file to the axes of the world. */
    double[] turned(double[] vector) {
        double[] turned =
                new Pose(vector[0], vector[1], vector[2], 0, 0, 0, 1).within(up).location();
        for (int axis = 0; axis < turned.length; axis++) {
            turned[axis] = Numerals.round(turned[axis]);
        }
        return turned;
    }

    /**
     * Returns the rules by which agents perceive the joints, as a part of a world file. The text is
     * empty if there are no hinges and sliders.
     */
    String rules() {
        Map<String, Object> rules = new LinkedHashMap<>();
        for (Joint joint : tree.joints()) {
            Optional<String> type = type(joint);
            if (type.equals(Optional.of("hinge"))) {
                rules.put("angle", rule("jointAngle", "Angle of a hinge [rad]."));
                rules.put("angleSpeed", rule("angleSpeed", "Speed of the angle [rad/s]."));
            } else if (type.equals(Optional.of("slider"))) {
                rules.put("travel", rule("jointTravel", "Travel of a slider [m]."));
                rules.put("travelSpeed", rule("travelSpeed", "Speed of the travel [m/s]."));
            }
        }
        return rules.isEmpty() ? "" : YamlWriter.write(Map.of("rules", rules)) + "\n";
    }

    private static Map<String, Object> rule(String property, String doc) {
        Map<String, Object> rule = new LinkedHashMap<>();
        rule.put("is", "physics." + property);
        rule.put("kind", "joint");
        rule.put("doc", doc);
        return rule;
    }

    /**
     * Returns the items of the scenery, as a part of a world file. The text is empty if there is no
     * scenery.
     */
    String scenery() {
        List<Map<String, Object>> scenery = new ArrayList<>();
        for (RobotModel.Scenery each : model.scene().orElseThrow().scenery()) {
            Optional<ShapeWriter.Written> written =
                    shapes.write(each.geometry(), each.geometry().colour());
            if (written.isPresent()) {
                Map<String, Object> item = new LinkedHashMap<>();
                item.put("name", unique(each.name()));
                Numerals.putPose(item, written.get().physical(), written.get().pose().within(up));
                scenery.add(item);
            }
        }
        return scenery.isEmpty() ? "" : YamlWriter.write(Map.of("items", scenery));
    }

    private void body(RigidTree.Body body) {
        if (isNeedless(body)) {
            return;
        }
        boolean immovable = body.top().name().equals(model.root()) && isFixed();
        String called = body.top().name();
        if (called.equals("world") && body.links().size() > 1) {
            called = body.links().get(1).name();
        }
        String name = unique(called.equals("world") ? "base" : called);
        Map<String, Object> physics = new LinkedHashMap<>();
        Pose pose = tree.pose(body.top().name());
        if (immovable) {
            physics.put("mass", Numeral.of(0));
        } else {
            RigidTree.Solid solid = tree.solid(body);
            pose = solid.pose();
            physics.put("mass", Numeral.of(solid.mass()));
            if (solid.moments()[0] > 0) {
                physics.put("inertia", Numerals.shortened(solid.moments()));
            }
        }
        Map<String, Object> item = new LinkedHashMap<>();
        item.put("name", name);
        Numerals.putPose(item, new LinkedHashMap<>(), pose);
        item.put("physics", physics);
        items.add(item);
        for (Link link : body.links()) {
            bodyNames.put(link.name(), name);
            bodyPoses.put(link.name(), pose);
            shapes(link, name, pose, touch(body));
        }
    }

    /** Returns the physics properties that determine how the shapes of a body collide. */
    private Map<String, Object> touch(RigidTree.Body body) {
        Map<String, Object> touch = new LinkedHashMap<>();
        touch.put("partOfBody", Numeral.of(1));
        if (layers.isPresent()) {
            surface(body).ifPresent(surface -> layers.get().put(surface, touch));
        } else if (!options.selfCollision()) {
            touch.put("touchLayer", Numeral.of(LAYER));
            touch.put("passesLayers", List.of(Numeral.of(LAYER)));
        }
        return touch;
    }

    /**
     * Returns whether a body needs no item. The only such body is the world body of an MJCF file
     * without shapes and joints.
     */
    private boolean isNeedless(RigidTree.Body body) {
        boolean isJoined =
                tree.joints().stream()
                        .anyMatch(
                                joint ->
                                        type(joint).isPresent()
                                                && tree.bodyOf(joint.parent()) == body);
        return model.scene().isPresent()
                && body.top().name().equals(model.root())
                && !isJoined
                && body.links().stream()
                        .allMatch(link -> link.looks().isEmpty() && link.collisions().isEmpty());
    }

    private void shapes(Link link, String body, Pose pose, Map<String, Object> touch) {
        List<Geometry> looks = new ArrayList<>(link.looks());
        for (Geometry collision : link.collisions()) {
            Optional<Geometry> same =
                    looks.stream().filter(look -> isSame(look, collision)).findFirst();
            same.ifPresent(looks::remove);
            Optional<String> colour =
                    same.isPresent()
                            ? same.get().colour()
                            : link.looks().isEmpty() ? Optional.empty() : Optional.of(HIDDEN);
            shape(link, collision, body, pose, " shape", colour, touch);
        }
        for (Geometry look : looks) {
            shape(link, look, body, pose, " look", look.colour(), Map.of());
        }
    }

    private static boolean isSame(Geometry one, Geometry other) {
        return one.pose().equals(other.pose())
                && switch (one.form()) {
                    case Form.Box box ->
                            other.form() instanceof Form.Box also
                                    && Arrays.equals(box.size(), also.size());
                    case Form.Ellipsoid round ->
                            other.form() instanceof Form.Ellipsoid also
                                    && Arrays.equals(round.size(), also.size());
                    case Form.MeshFile mesh ->
                            other.form() instanceof Form.MeshFile also
                                    && mesh.name().equals(also.name())
                                    && Arrays.equals(mesh.scale(), also.scale());
                    case Form.Sphere sphere -> sphere.equals(other.form());
                    case Form.Cylinder cylinder -> cylinder.equals(other.form());
                    case Form.Capsule capsule -> capsule.equals(other.form());
                    case Form.Plane plane -> plane.equals(other.form());
                    case Form.Terrain terrain -> terrain.equals(other.form());
                };
    }

    private void shape(
            Link link,
            Geometry geometry,
            String body,
            Pose bodyPose,
            String suffix,
            Optional<String> colour,
            Map<String, Object> touch) {
        Optional<ShapeWriter.Written> written = shapes.write(geometry, colour);
        if (written.isEmpty()) {
            return;
        }
        Pose inWorld = written.get().pose().within(tree.pose(link.name()));
        lower(inWorld, written.get());
        Map<String, Object> physical = written.get().physical();
        Map<String, Object> item = new LinkedHashMap<>();
        item.put("name", unique(link.name() + suffix));
        item.put("parent", body);
        Numerals.putPose(item, physical, inWorld.relativeTo(bodyPose));
        if (!touch.isEmpty()) {
            item.put("physics", touch);
        }
        items.add(item);
    }

    private void lower(Pose pose, ShapeWriter.Written shape) {
        double[] half = shape.half();
        for (int corner = 0; corner < 8; corner++) {
            Pose at =
                    new Pose(
                                    (corner & 1) == 0 ? half[0] : -half[0],
                                    (corner & 2) == 0 ? half[1] : -half[1],
                                    (corner & 4) == 0 ? half[2] : -half[2],
                                    0,
                                    0,
                                    0,
                                    1)
                            .within(pose);
            lowest = Math.min(lowest, shape.isBall() ? pose.y() - half[0] : at.y());
        }
    }

    private static Optional<String> type(Joint joint) {
        return switch (joint.type()) {
            case REVOLUTE, CONTINUOUS -> Optional.of("hinge");
            case PRISMATIC -> Optional.of("slider");
            case FIXED -> Optional.of("fixed");
            case BALL -> Optional.of("ball");
            case FLOATING, PLANAR -> Optional.empty();
        };
    }

    private void joint(Joint joint) {
        if (type(joint).isEmpty()) {
            if (joint.type() == JointType.PLANAR) {
                notes.add(
                        "joint "
                                + joint.name()
                                + ": joints of type planar are not imported; "
                                + joint.child()
                                + " moves freely");
            }
            return;
        }
        Pose parent = bodyPoses.get(joint.parent());
        Pose own = joint.pose().within(tree.pose(joint.parent())).relativeTo(parent);
        Map<String, Object> physics = new LinkedHashMap<>();
        physics.put("joined", List.of(bodyNames.get(joint.parent()), bodyNames.get(joint.child())));
        physics.put("jointType", type(joint).get());
        double[] at = joint.anchor();
        Pose anchor = new Pose(at[0], at[1], at[2], 0, 0, 0, 1).within(own);
        physics.put("anchor", Numerals.rounded(anchor.location()));
        double[] axis = joint.axis();
        Pose end = new Pose(axis[0], axis[1], axis[2], 0, 0, 0, 1).within(own);
        physics.put(
                "axis",
                Numerals.rounded(
                        new double[] {end.x() - own.x(), end.y() - own.y(), end.z() - own.z()}));
        if (joint.type() == JointType.BALL) {
            physics.remove("axis");
        }
        boolean slides = joint.type() == JointType.PRISMATIC;
        joint.limits()
                .ifPresent(
                        limits -> {
                            physics.put(
                                    slides ? "travelLimits" : "angleLimits",
                                    Numerals.exactly(limits));
                            checkTurn(joint, slides, limits);
                        });
        boolean acts = DriveActions.putFirst(joint, slides, physics);
        if (!acts && options.hold() && joint.effort() > 0) {
            physics.put(slides ? "driveForce" : "motorTorque", Numeral.of(joint.effort()));
        }
        loads(joint.loads(), slides, physics);
        Map<String, Object> item = new LinkedHashMap<>();
        String name = unique(names.contains(joint.name()) ? joint.name() + " joint" : joint.name());
        item.put("name", name);
        if (slides || type(joint).get().equals("hinge")) {
            jointNames.put(joint.name(), name);
        }
        item.put("kind", "joint");
        Map<String, Object> actions = DriveActions.of(joint, slides, notes);
        if (!actions.isEmpty()) {
            item.put("access", actions);
        }
        item.put("physics", physics);
        items.add(item);
    }

    private void gear(RobotModel.Coupling coupling) {
        String first = jointNames.get(coupling.first());
        String second = jointNames.get(coupling.second());
        if (first == null || second == null) {
            notes.add(
                    "joint "
                            + coupling.first()
                            + ": its coupling to "
                            + coupling.second()
                            + " is not imported, because one of the two is no hinge or slider");
            return;
        }
        Map<String, Object> physics = new LinkedHashMap<>();
        physics.put("geared", List.of(first, second));
        physics.put("gearRatio", Numeral.of(coupling.ratio()));
        if (coupling.offset() != 0) {
            boolean slides =
                    model.joints().stream()
                            .anyMatch(
                                    joint ->
                                            joint.name().equals(coupling.first())
                                                    && joint.type() == JointType.PRISMATIC);
            physics.put(slides ? "offsetTravel" : "offsetAngle", Numeral.of(coupling.offset()));
            notes.add(
                    "joint "
                            + coupling.first()
                            + ": it is at 0 at the start, and then moves to its offset "
                            + coupling.offset());
        }
        Map<String, Object> item = new LinkedHashMap<>();
        item.put("name", unique(first + " gear"));
        item.put("kind", "gear");
        item.put("physics", physics);
        items.add(item);
    }

    private static void loads(RobotModel.Loads loads, boolean slides, Map<String, Object> physics) {
        String kind = slides ? "travel" : "angle";
        putPositive(physics, kind + "Damping", loads.damping());
        putPositive(physics, kind + "Friction", loads.friction());
        putPositive(physics, kind + "Stiffness", loads.stiffness());
        if (loads.rest() != 0) {
            physics.put(slides ? "restTravel" : "restAngle", Numeral.of(loads.rest()));
        }
        putPositive(physics, slides ? "rotorMass" : "rotorInertia", loads.rotor());
    }

    private static void putPositive(Map<String, Object> physics, String name, double value) {
        if (value > 0) {
            physics.put(name, Numeral.of(value));
        }
    }

    private void checkTurn(Joint joint, boolean slides, double[] limits) {
        if (limits[0] > 0 || limits[1] < 0) {
            notes.add(
                    "joint "
                            + joint.name()
                            + ": 0 is outside of its limits, and the robot starts there");
        }
        if (!slides && (limits[0] < -Math.PI || limits[1] > Math.PI)) {
            notes.add(
                    "joint "
                            + joint.name()
                            + ": limits beyond half a turn have no effect, because hinges measure"
                            + " angles from -180 to 180 deg");
        }
    }

    /** Returns a valid name that no other item has, similar to the wanted name. */
    private String unique(String wanted) {
        String name = wanted.replaceAll("[^\\p{L}\\p{N} ._/:-]", "_").strip();
        if (name.isEmpty()) {
            name = "link";
        }
        name = name.substring(0, Math.min(name.length(), 100)).strip();
        String first = name;
        for (int i = 2; !names.add(name); i++) {
            name = first + " " + i;
        }
        return name;
    }
}
