// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.urdf.RobotModel.Coupling;
import reve.core.urdf.RobotModel.Drive;
import reve.core.urdf.RobotModel.Form;
import reve.core.urdf.RobotModel.Geometry;
import reve.core.urdf.RobotModel.Inertial;
import reve.core.urdf.RobotModel.Joint;
import reve.core.urdf.RobotModel.JointType;
import reve.core.urdf.RobotModel.Link;
import reve.core.urdf.RobotModel.Loads;
import reve.core.world.Pose;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** Reader of URDF files (Unified Robot Description Format, https://wiki.ros.org/urdf/XML). */
final class UrdfReader {
    private static final int MAX_LINKS = 1000;
    private static final Set<String> KNOWN = Set.of("link", "joint", "material");

    private final XmlElement robot;
    private final Map<String, String> colours = new HashMap<>();

    private final List<Coupling> couplings = new ArrayList<>();
    private final Ignored ignored = new Ignored();

    private UrdfReader(XmlElement robot) {
        this.robot = robot;
    }

    /**
     * Reads a robot.
     *
     * @param root root element of the file
     * @throws RobotFileException if the file is no URDF, or its links form no tree
     */
    static RobotModel read(XmlElement root) throws RobotFileException {
        if (!root.name().equals("robot")) {
            throw root.problem(
                    "the file is neither URDF nor MJCF: it begins with <"
                            + root.name()
                            + ">, expected <robot> or <mujoco>");
        }
        return new UrdfReader(root).read();
    }

    private RobotModel read() throws RobotFileException {
        for (XmlElement material : robot.all("material")) {
            Optional<String> colour = colour(material);
            if (colour.isPresent()) {
                colours.put(material.text("name"), colour.get());
            }
        }
        for (XmlElement other : robot.children()) {
            if (other.name().contains("macro") || other.name().equals("include")) {
                throw other.problem(
                        "<"
                                + other.name()
                                + "> is a macro of xacro; convert the file with `xacro FILE >"
                                + " robot.urdf` first");
            }
            if (!KNOWN.contains(other.name())) {
                ignore("<" + other.name() + ">");
            }
        }
        Map<String, Link> links = new LinkedHashMap<>();
        for (XmlElement element : robot.all("link")) {
            Link link = link(element);
            if (links.put(link.name(), link) != null) {
                throw element.problem("a second link has the name " + link.name());
            }
        }
        if (links.size() > MAX_LINKS) {
            throw robot.problem(
                    "the robot has " + links.size() + " links, expected at most " + MAX_LINKS);
        }
        List<Joint> joints = new ArrayList<>();
        for (XmlElement element : robot.all("joint")) {
            joints.add(joint(element, links));
        }
        checkCouplings(joints);
        String root = root(links, joints);
        return new RobotModel(
                robot.find("name").orElse("robot"),
                links,
                joints,
                root,
                couplings,
                Optional.empty(),
                ignored.lines());
    }

    private void ignore(String what) {
        ignored.add(what);
    }

    private Link link(XmlElement element) throws RobotFileException {
        List<Geometry> looks = new ArrayList<>();
        List<Geometry> collisions = new ArrayList<>();
        Optional<Inertial> inertial = Optional.empty();
        for (XmlElement child : element.children()) {
            switch (child.name()) {
                case "inertial" -> inertial = Optional.of(inertial(child));
                case "visual" -> looks.add(geometry(child));
                case "collision" -> collisions.add(geometry(child));
                default -> ignore("<" + child.name() + "> of links");
            }
        }
        return new Link(
                element.text("name"),
                element.place(),
                inertial.filter(one -> one.mass() > 0),
                looks,
                collisions,
                Optional.empty());
    }

    private Inertial inertial(XmlElement element) throws RobotFileException {
        double mass = required(element, "mass").number("value");
        XmlElement inertia = required(element, "inertia");
        if (mass < 0) {
            throw element.problem("the mass is " + mass + " kg, expected 0 or more");
        }
        return new Inertial(
                pose(element),
                mass,
                new double[] {
                    inertia.number("ixx"),
                    inertia.number("iyy"),
                    inertia.number("izz"),
                    inertia.number("iyz", 0),
                    inertia.number("ixz", 0),
                    inertia.number("ixy", 0)
                });
    }

    private static XmlElement required(XmlElement element, String child) throws RobotFileException {
        return element.child(child)
                .orElseThrow(
                        () -> element.problem("<" + element.name() + "> has no <" + child + ">"));
    }

    private Geometry geometry(XmlElement element) throws RobotFileException {
        XmlElement geometry = required(element, "geometry");
        XmlElement form =
                geometry.children().stream()
                        .findFirst()
                        .orElseThrow(() -> geometry.problem("<geometry> is empty"));
        Optional<String> colour = Optional.empty();
        Optional<XmlElement> material = element.child("material");
        if (material.isPresent()) {
            colour = colour(material.get());
            if (colour.isEmpty()) {
                colour = material.get().find("name").map(colours::get);
            }
        }
        return new Geometry(form.place(), pose(element), form(form), colour);
    }

    private Form form(XmlElement form) throws RobotFileException {
        return switch (form.name()) {
            case "box" -> {
                form.text("size");
                yield new Form.Box(positive(form, form.numbers("size", 0, 0, 0)));
            }
            case "sphere" -> new Form.Sphere(positive(form, form.number("radius"))[0]);
            case "cylinder" ->
                    new Form.Cylinder(
                            positive(form, form.number("radius"))[0],
                            positive(form, form.number("length"))[0]);
            case "mesh" -> new Form.MeshFile(form.text("filename"), form.numbers("scale", 1, 1, 1));
            default ->
                    throw form.problem(
                            "the shape <"
                                    + form.name()
                                    + "> is unknown; expected <box>, <sphere>, <cylinder> or"
                                    + " <mesh>");
        };
    }

    private static double[] positive(XmlElement place, double... numbers)
            throws RobotFileException {
        place.requireLengths(numbers);
        return numbers;
    }

    private Joint joint(XmlElement element, Map<String, Link> links) throws RobotFileException {
        JointType type = type(element);
        for (XmlElement child : element.children()) {
            switch (child.name()) {
                case "origin", "parent", "child", "axis", "limit", "dynamics", "mimic" -> {}
                default -> ignore("<" + child.name() + "> of joints");
            }
        }
        Optional<XmlElement> limit = element.child("limit");
        Optional<XmlElement> dynamics = element.child("dynamics");
        boolean isLimited = type == JointType.REVOLUTE || type == JointType.PRISMATIC;
        if (isLimited && limit.isEmpty()) {
            throw element.problem(
                    "a joint of type "
                            + element.text("type")
                            + " needs a <limit>; a joint without limits has the type continuous");
        }
        Optional<double[]> limits = Optional.empty();
        if (isLimited) {
            double[] both = {limit.get().number("lower", 0), limit.get().number("upper", 0)};
            if (both[0] > both[1]) {
                throw limit.get()
                        .problem("the lower limit " + both[0] + " is above the upper " + both[1]);
            }
            limits = Optional.of(both);
        }
        Optional<XmlElement> mimic = element.child("mimic");
        if (mimic.isPresent()) {
            couplings.add(coupling(element.text("name"), mimic.get()));
        }
        double effort = limit.isPresent() ? Math.abs(limit.get().number("effort", 0)) : 0;
        double speed = limit.isPresent() ? Math.abs(limit.get().number("velocity", 0)) : 0;
        return new Joint(
                element.text("name"),
                element.place(),
                type,
                linkName(element, "parent", links),
                linkName(element, "child", links),
                pose(element),
                new double[3],
                axis(element),
                limits,
                mimic.isPresent() ? 0 : effort,
                dynamics.isPresent() ? loads(dynamics.get()) : Loads.NONE,
                mimic.isPresent() ? List.of() : List.of(Drive.ofSpeed(speed, effort)));
    }

    private static Coupling coupling(String joint, XmlElement mimic) throws RobotFileException {
        String other = mimic.text("joint");
        if (other.equals(joint)) {
            throw mimic.problem("the joint " + joint + " mimics itself; expected another joint");
        }
        return new Coupling(joint, other, mimic.number("multiplier", 1), mimic.number("offset", 0));
    }

    private void checkCouplings(List<Joint> joints) throws RobotFileException {
        Set<String> names = new HashSet<>();
        joints.forEach(joint -> names.add(joint.name()));
        for (Coupling coupling : couplings) {
            if (!names.contains(coupling.second())) {
                throw robot.problem(
                        "the joint "
                                + coupling.first()
                                + " mimics "
                                + coupling.second()
                                + ", which is no joint of the file");
            }
        }
    }

    private static Loads loads(XmlElement dynamics) throws RobotFileException {
        return new Loads(
                Math.abs(dynamics.number("damping", 0)),
                Math.abs(dynamics.number("friction", 0)),
                0,
                0,
                0);
    }

    private static JointType type(XmlElement element) throws RobotFileException {
        for (JointType type : JointType.values()) {
            if (type != JointType.BALL
                    && element.text("type").equals(type.name().toLowerCase(Locale.ROOT))) {
                return type;
            }
        }
        throw element.problem(
                "the joint has the type "
                        + element.text("type")
                        + ", expected revolute, continuous, prismatic, fixed, floating or planar");
    }

    private static String linkName(XmlElement joint, String role, Map<String, Link> links)
            throws RobotFileException {
        XmlElement element = required(joint, role);
        String name = element.text("link");
        if (!links.containsKey(name)) {
            throw element.problem("the " + role + " " + name + " is no link of the file");
        }
        return name;
    }

    private static double[] axis(XmlElement joint) throws RobotFileException {
        Optional<XmlElement> element = joint.child("axis");
        double[] axis =
                element.isEmpty() ? new double[] {1, 0, 0} : element.get().numbers("xyz", 1, 0, 0);
        double length = Math.sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        if (!(length > 0)) {
            throw joint.problem("the axis is 0 0 0, expected a direction");
        }
        return new double[] {axis[0] / length, axis[1] / length, axis[2] / length};
    }

    /** Returns the pose in the child element {@code origin}: x y z, and roll, pitch, yaw. */
    private static Pose pose(XmlElement element) throws RobotFileException {
        Optional<XmlElement> origin = element.child("origin");
        if (origin.isEmpty()) {
            return Pose.ORIGIN;
        }
        double[] location = origin.get().numbers("xyz", 0, 0, 0);
        double[] rpy = origin.get().numbers("rpy", 0, 0, 0);
        return Pose.of(location, ofAngles(rpy[0], rpy[1], rpy[2]));
    }

    /**
     * Returns the quaternion xyzw of successive rotations about the fixed axes X, Y and Z [rad].
     */
    static double[] ofAngles(double roll, double pitch, double yaw) {
        double cr = Math.cos(roll / 2);
        double sr = Math.sin(roll / 2);
        double cp = Math.cos(pitch / 2);
        double sp = Math.sin(pitch / 2);
        double cy = Math.cos(yaw / 2);
        double sy = Math.sin(yaw / 2);
        return new double[] {
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy
        };
    }

    private Optional<String> colour(XmlElement material) throws RobotFileException {
        if (material.child("texture").isPresent()) {
            ignore("textures of materials");
        }
        Optional<XmlElement> element = material.child("color");
        if (element.isEmpty()) {
            return Optional.empty();
        }
        double[] rgba = element.get().numbers("rgba", 1, 1, 1, 1);
        StringBuilder text = new StringBuilder("#");
        for (double part : rgba) {
            text.append("%02x".formatted(Math.round(255 * Math.clamp(part, 0, 1))));
        }
        return Optional.of(text.toString().endsWith("ff") ? text.substring(0, 7) : text.toString());
    }

    private String root(Map<String, Link> links, List<Joint> joints) throws RobotFileException {
        if (links.isEmpty()) {
            throw robot.problem("the robot has no <link>");
        }
        Map<String, Joint> above = new HashMap<>();
        Set<String> names = new HashSet<>();
        for (Joint joint : joints) {
            if (!names.add(joint.name())) {
                throw new RobotFileException(
                        joint.place() + ": a second joint has the name " + joint.name());
            }
            if (above.put(joint.child(), joint) != null) {
                throw new RobotFileException(
                        joint.place()
                                + ": the link "
                                + joint.child()
                                + " is the child of two joints; a link may have one parent");
            }
        }
        List<String> roots =
                links.keySet().stream().filter(name -> !above.containsKey(name)).toList();
        if (roots.size() != 1) {
            throw robot.problem(
                    roots.isEmpty()
                            ? "the joints form a ring; expected a tree of links"
                            : "the links "
                                    + String.join(", ", roots)
                                    + " have no parent; expected one such link, the root");
        }
        Set<String> reached = new HashSet<>(roots);
        for (boolean more = true; more; ) {
            more = false;
            for (Joint joint : joints) {
                more |= reached.contains(joint.parent()) && reached.add(joint.child());
            }
        }
        for (Link link : links.values()) {
            if (!reached.contains(link.name())) {
                throw new RobotFileException(
                        link.place()
                                + ": no joints lead from the root "
                                + roots.getFirst()
                                + " to the link "
                                + link.name()
                                + ", because joints form a ring; expected a tree of links");
            }
        }
        return roots.getFirst();
    }
}
