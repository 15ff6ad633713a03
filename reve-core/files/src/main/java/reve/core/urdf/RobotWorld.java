// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.file.YamlWriter;
import reve.core.file.YamlWriter.Numeral;
import reve.core.urdf.RobotModel.Form;
import reve.core.urdf.RobotModel.Geometry;
import reve.core.urdf.RobotModel.Joint;
import reve.core.urdf.RobotModel.JointType;
import reve.core.urdf.RobotModel.Link;
import reve.core.world.Pose;

import java.math.BigDecimal;
import java.math.MathContext;
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
 * Writer of a robot as items of a world file: a body for each rigid part, with its centre of mass
 * and its principal axes as the origin and axes of the item; its shapes as attached items; and the
 * joints, with an action that drives them.
 */
final class RobotWorld {
    private static final int LAYER = 1;
    private static final double DIGITS = 1e12;
    private static final MathContext TWELVE_DIGITS = new MathContext(12);
    private static final double NOISE = 1e-14;
    private static final String HIDDEN = "#00000000";

    /** Rotates the axis of cylinders from +Y, as in world files, to +Z, as in URDF. */
    private static final Pose ALONG_Z = new Pose(0, 0, 0, Math.sqrt(0.5), 0, 0, Math.sqrt(0.5));

    /** Rotates +Z up, as in URDF, to +Y up, as in worlds. */
    private static final Pose Z_UP = new Pose(0, 0, 0, -Math.sqrt(0.5), 0, 0, Math.sqrt(0.5));

    private final RobotModel model;
    private final MeshFiles meshes;
    private final RobotImport.Options options;
    private final List<String> notes;
    private final RigidTree tree;
    private final Set<String> names = new TreeSet<>(Set.of("world", "ground"));
    private final Map<String, String> bodyNames = new HashMap<>();
    private final Map<String, Pose> bodyPoses = new HashMap<>();
    private final List<Map<String, Object>> items = new ArrayList<>();
    private double lowest = Double.POSITIVE_INFINITY;

    RobotWorld(
            RobotModel model, MeshFiles meshes, RobotImport.Options options, List<String> notes) {
        this.model = model;
        this.meshes = meshes;
        this.options = options;
        this.notes = notes;
        this.tree = new RigidTree(model, options.zUp() ? Z_UP : Pose.ORIGIN, notes);
    }

    /** Returns the file with the items of the robot. */
    String write() {
        for (RigidTree.Body body : tree.bodies()) {
            body(body);
        }
        for (Joint joint : tree.joints()) {
            joint(joint);
        }
        for (String ignored : model.ignored()) {
            notes.add("not imported: " + ignored);
        }
        return YamlWriter.write(Map.of("items", items));
    }

    int bodyCount() {
        return tree.bodies().size();
    }

    int jointCount() {
        return (int) tree.joints().stream().filter(joint -> type(joint).isPresent()).count();
    }

    /** Returns the least Y of the bounding boxes of all shapes [m]; infinity without shapes. */
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

    private void body(RigidTree.Body body) {
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
                physics.put("inertia", shortened(solid.moments()));
            }
        }
        if (!options.selfCollision()) {
            physics.put("touchLayer", Numeral.of(LAYER));
            physics.put("passesLayers", List.of(Numeral.of(LAYER)));
        }
        Map<String, Object> item = new LinkedHashMap<>();
        item.put("name", name);
        putPose(item, new LinkedHashMap<>(), pose);
        item.put("physics", physics);
        items.add(item);
        for (Link link : body.links()) {
            bodyNames.put(link.name(), name);
            bodyPoses.put(link.name(), pose);
            shapes(link, name, pose);
        }
    }

    private void shapes(Link link, String body, Pose pose) {
        List<Geometry> looks = new ArrayList<>(link.looks());
        for (Geometry collision : link.collisions()) {
            Optional<Geometry> same =
                    looks.stream().filter(look -> isSame(look, collision)).findFirst();
            same.ifPresent(looks::remove);
            Optional<String> colour =
                    same.isPresent()
                            ? same.get().colour()
                            : link.looks().isEmpty() ? Optional.empty() : Optional.of(HIDDEN);
            shape(link, collision, body, pose, " shape", colour, true);
        }
        for (Geometry look : looks) {
            shape(link, look, body, pose, " look", look.colour(), false);
        }
    }

    private static boolean isSame(Geometry one, Geometry other) {
        return one.pose().equals(other.pose())
                && switch (one.form()) {
                    case Form.Box box ->
                            other.form() instanceof Form.Box also
                                    && Arrays.equals(box.size(), also.size());
                    case Form.MeshFile mesh ->
                            other.form() instanceof Form.MeshFile also
                                    && mesh.name().equals(also.name())
                                    && Arrays.equals(mesh.scale(), also.scale());
                    case Form.Sphere sphere -> sphere.equals(other.form());
                    case Form.Cylinder cylinder -> cylinder.equals(other.form());
                };
    }

    private void shape(
            Link link,
            Geometry geometry,
            String body,
            Pose bodyPose,
            String suffix,
            Optional<String> colour,
            boolean collides) {
        Map<String, Object> physical = new LinkedHashMap<>();
        Pose pose = geometry.pose();
        double[] half;
        switch (geometry.form()) {
            case Form.Box box -> {
                physical.put("shape", "box");
                physical.put("size", exactly(box.size()));
                half = new double[] {box.size()[0] / 2, box.size()[1] / 2, box.size()[2] / 2};
            }
            case Form.Sphere sphere -> {
                physical.put("shape", "sphere");
                physical.put("radius", Numeral.of(sphere.radius()));
                half = new double[] {sphere.radius(), sphere.radius(), sphere.radius()};
            }
            case Form.Cylinder cylinder -> {
                physical.put("shape", "cylinder");
                physical.put("radius", Numeral.of(cylinder.radius()));
                physical.put("height", Numeral.of(cylinder.length()));
                pose = ALONG_Z.within(pose);
                half = new double[] {cylinder.radius(), cylinder.length() / 2, cylinder.radius()};
            }
            case Form.MeshFile mesh -> {
                MeshFiles.Converted converted;
                try {
                    converted = meshes.convert(geometry.place(), mesh);
                } catch (UrdfException unreadable) {
                    notes.add(unreadable.getMessage() + "; the shape is left out");
                    return;
                }
                physical.put("shape", "mesh");
                physical.put("file", converted.file());
                double[] c = converted.centre();
                pose = new Pose(c[0], c[1], c[2], 0, 0, 0, 1).within(pose);
                half =
                        new double[] {
                            converted.size()[0] / 2,
                            converted.size()[1] / 2,
                            converted.size()[2] / 2
                        };
            }
        }
        Pose inWorld = pose.within(tree.pose(link.name()));
        lower(inWorld, half, geometry.form() instanceof Form.Sphere);
        colour.ifPresent(text -> physical.put("colour", text));
        Map<String, Object> item = new LinkedHashMap<>();
        item.put("name", unique(link.name() + suffix));
        item.put("parent", body);
        putPose(item, physical, inWorld.relativeTo(bodyPose));
        if (collides) {
            item.put("physics", Map.of("partOfBody", Numeral.of(1)));
        }
        items.add(item);
    }

    private void lower(Pose pose, double[] half, boolean ball) {
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
            lowest = Math.min(lowest, ball ? pose.y() - half[0] : at.y());
        }
    }

    private static Optional<String> type(Joint joint) {
        return switch (joint.type()) {
            case REVOLUTE, CONTINUOUS -> Optional.of("hinge");
            case PRISMATIC -> Optional.of("slider");
            case FIXED -> Optional.of("fixed");
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
        physics.put("anchor", rounded(own.location()));
        double[] axis = joint.axis();
        Pose end = new Pose(axis[0], axis[1], axis[2], 0, 0, 0, 1).within(own);
        physics.put(
                "axis",
                rounded(new double[] {end.x() - own.x(), end.y() - own.y(), end.z() - own.z()}));
        boolean slides = joint.type() == JointType.PRISMATIC;
        joint.limits()
                .ifPresent(
                        limits -> {
                            physics.put(slides ? "travelLimits" : "angleLimits", exactly(limits));
                            checkTurn(joint, slides, limits);
                        });
        // A motor that holds the speed 0 with a torque is dry friction.
        double load =
                options.hold() ? Math.max(joint.effort(), joint.friction()) : joint.friction();
        if (load > 0) {
            physics.put(slides ? "driveForce" : "motorTorque", Numeral.of(load));
        }
        Map<String, Object> item = new LinkedHashMap<>();
        item.put(
                "name",
                unique(names.contains(joint.name()) ? joint.name() + " joint" : joint.name()));
        item.put("kind", "joint");
        item.put("access", Map.of("drive", drive(joint, slides)));
        item.put("physics", physics);
        items.add(item);
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

    /** Returns an action that sets the speed and the largest torque or force of a joint. */
    private static Map<String, Object> drive(Joint joint, boolean slides) {
        Map<String, Object> parameters = new LinkedHashMap<>();
        Map<String, Object> speed = new LinkedHashMap<>();
        speed.put("unit", slides ? "m/s" : "rad/s");
        if (joint.speed() > 0) {
            speed.put("min", Numeral.of(-joint.speed()));
            speed.put("max", Numeral.of(joint.speed()));
        }
        parameters.put("speed", speed);
        String load = slides ? "force" : "torque";
        Map<String, Object> most = new LinkedHashMap<>();
        most.put("unit", slides ? "N" : "N*m");
        most.put("min", Numeral.of(0));
        if (joint.effort() > 0) {
            most.put("max", Numeral.of(joint.effort()));
        }
        parameters.put(load, most);
        Map<String, Object> action = new LinkedHashMap<>();
        action.put(
                "doc",
                "Moves the joint at a speed, with at most a " + load + "; the speed 0 holds it.");
        action.put("parameters", parameters);
        action.put(
                "effects",
                List.of(
                        set(slides ? "driveSpeed" : "motorSpeed", "$speed"),
                        set(slides ? "driveForce" : "motorTorque", "$" + load)));
        return action;
    }

    private static Map<String, Object> set(String property, String value) {
        Map<String, Object> effect = new LinkedHashMap<>();
        effect.put("set", "physics." + property);
        effect.put("to", value);
        return effect;
    }

    private static void putPose(Map<String, Object> item, Map<String, Object> physical, Pose pose) {
        physical.put("location", rounded(pose.location()));
        if (Math.abs(pose.qw()) < 1) {
            physical.put("orientation", withoutNoise(pose.orientation()));
        }
        item.put("physical", physical);
    }

    private static List<Numeral> exactly(double[] values) {
        List<Numeral> numerals = new ArrayList<>();
        for (double value : values) {
            numerals.add(Numeral.of(value == 0 ? 0 : value));
        }
        return numerals;
    }

    /** Returns the values with 12 digits. */
    private static List<Numeral> shortened(double[] values) {
        List<Numeral> numerals = new ArrayList<>();
        for (double value : values) {
            numerals.add(Numeral.of(new BigDecimal(value).round(TWELVE_DIGITS).doubleValue()));
        }
        return numerals;
    }

    /** Returns a unit quaternion with 0 in the place of rounding errors. */
    private static List<Numeral> withoutNoise(double[] quaternion) {
        double[] clean = quaternion.clone();
        for (int i = 0; i < clean.length; i++) {
            clean[i] = Math.abs(clean[i]) < NOISE ? 0 : clean[i];
        }
        return exactly(clean);
    }

    /** Returns the values without rounding errors around simple numbers. */
    private static List<Numeral> rounded(double[] values) {
        List<Numeral> numerals = new ArrayList<>();
        for (double value : values) {
            double round = Math.rint(value * DIGITS) / DIGITS;
            numerals.add(Numeral.of(round == 0 ? 0 : round));
        }
        return numerals;
    }

    /** Returns a valid name that no other item has. */
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
