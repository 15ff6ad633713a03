// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.urdf.MjcfGeoms.Geom;
import reve.core.urdf.RobotModel.Coupling;
import reve.core.urdf.RobotModel.Drive;
import reve.core.urdf.RobotModel.Geometry;
import reve.core.urdf.RobotModel.Inertial;
import reve.core.urdf.RobotModel.Joint;
import reve.core.urdf.RobotModel.JointType;
import reve.core.urdf.RobotModel.Link;
import reve.core.urdf.RobotModel.Loads;
import reve.core.urdf.RobotModel.Scene;
import reve.core.urdf.RobotModel.Scenery;
import reve.core.urdf.RobotModel.Surface;
import reve.core.world.Pose;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * Reader of MJCF files, the format of MuJoCo
 * (https://mujoco.readthedocs.io/en/stable/XMLreference.html).
 */
final class MjcfReader {
    private static final int MAX_BODIES = 1000;
    private static final int MAX_GEOMS = 10_000;

    /** Maximum number of joints of a body. In MuJoCo, a body has at most six degrees of freedom. */
    private static final int MAX_JOINTS_OF_A_BODY = 6;

    private static final double[] GRAVITY = {0, 0, -9.81};
    private static final double STEP = 0.002; // [s]
    private static final String WORLD = "world";

    /**
     * Fraction of a body's mass and inertia that an intermediate body gets. The joints of a body
     * with several joints form a chain, with an intermediate body between two successive joints.
     */
    private static final double SHARE = 0.02;

    private static final Set<String> SECTIONS =
            Set.of("compiler", "option", "default", "asset", "worldbody", "actuator", "equality");
    private static final Set<String> COUPLING =
            Set.of("name", "joint1", "joint2", "polycoef", "active");
    private static final Set<String> JOINT =
            Set.of(
                    "name",
                    "class",
                    "type",
                    "pos",
                    "axis",
                    "range",
                    "limited",
                    "frictionloss",
                    "damping",
                    "armature",
                    "stiffness",
                    "springref",
                    "ref",
                    "actuatorfrcrange",
                    "actuatorfrclimited",
                    "group");
    private static final Set<String> BODY =
            Set.of("name", "childclass", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler");

    private final XmlElement root;
    private final RobotImport.Base base;
    private final List<String> notes;
    private final Ignored ignored = new Ignored();
    private final MjcfCompiler compiler;
    private final MjcfDefaults defaults;
    private final MjcfGeoms geoms;
    private final Map<String, Link> links = new LinkedHashMap<>();
    private final Map<String, Joint> joints = new LinkedHashMap<>();
    private int geomCount;
    private final List<Scenery> scenery = new ArrayList<>();
    private boolean hasFree;

    private MjcfReader(XmlElement root, MeshFiles meshes, RobotImport.Base base, List<String> notes)
            throws RobotFileException {
        this.root = root;
        this.base = base;
        this.notes = notes;
        this.compiler = new MjcfCompiler(root.all("compiler"));
        this.defaults = new MjcfDefaults(root.all("default"));
        this.geoms = new MjcfGeoms(compiler, meshes, ignored);
    }

    /**
     * Reads a robot.
     *
     * @param root root element of the file, which also contains the elements of included files
     * @param base {@code FIXED} fixes the bodies that have a free joint
     * @param notes receives one line for each difference between the world and the file
     * @throws RobotFileException if the file is no valid MJCF
     */
    static RobotModel read(
            XmlElement root, MeshFiles meshes, RobotImport.Base base, List<String> notes)
            throws RobotFileException {
        return new MjcfReader(root, meshes, base, notes).read();
    }

    private RobotModel read() throws RobotFileException {
        for (XmlElement section : root.children()) {
            if (!SECTIONS.contains(section.name())) {
                section.children()
                        .forEach(
                                child ->
                                        ignored.add(
                                                "<" + section.name() + "> <" + child.name() + ">"));
                if (section.children().isEmpty()) {
                    ignored.add("<" + section.name() + ">");
                }
            }
        }
        for (XmlElement each : root.all("compiler")) {
            ignored.attributes(each, MjcfCompiler.READ);
            each.children().forEach(child -> ignored.add("<compiler> <" + child.name() + ">"));
        }
        for (XmlElement section : root.all("asset")) {
            for (XmlElement asset : section.children()) {
                geoms.asset(defaults.resolve(asset, ""));
            }
        }
        Group world = new Group("");
        for (XmlElement each : root.all("worldbody")) {
            collect(each, Pose.ORIGIN, "", world);
        }
        putWorld(world);
        for (Nested body : world.bodies) {
            body(body, WORLD);
        }
        if (links.size() == 1 && scenery.isEmpty()) {
            throw root.problem("<worldbody> has neither a <body> nor a <geom>");
        }
        new MjcfActuators(defaults, compiler, ignored).read(root.all("actuator"), joints);
        if (base == RobotImport.Base.FREE && !hasFree) {
            notes.add("--base free has no effect: no body has a free joint in the file");
        }
        Scene scene = scene();
        return new RobotModel(
                root.find("model").orElse("robot"),
                links,
                List.copyOf(joints.values()),
                WORLD,
                couplings(),
                Optional.of(scene),
                ignored.lines());
    }

    /** Returns the linear couplings of two hinges or slides. */
    private List<Coupling> couplings() throws RobotFileException {
        List<Coupling> couplings = new ArrayList<>();
        for (XmlElement section : root.all("equality")) {
            for (XmlElement element : section.children()) {
                if (element.name().equals("joint")) {
                    coupling(element).ifPresent(couplings::add);
                } else {
                    ignored.add("<equality> <" + element.name() + ">");
                }
            }
        }
        return couplings;
    }

    private Optional<Coupling> coupling(XmlElement element) throws RobotFileException {
        double[] terms = element.numbers("polycoef", 0, 1, 0, 0, 0);
        boolean isLinear = terms[2] == 0 && terms[3] == 0 && terms[4] == 0;
        if (element.find("joint2").isEmpty()
                || !isLinear
                || element.find("active").equals(Optional.of("false"))) {
            ignored.add(
                    "<equality> <joint>"
                            + (isLinear ? " of one joint or not active" : " that is not linear"));
            return Optional.empty();
        }
        ignored.attributes(element, COUPLING);
        for (String key : List.of("joint1", "joint2")) {
            if (!joints.containsKey(element.text(key))) {
                throw element.problem("there is no joint " + element.text(key));
            }
        }
        if (element.text("joint1").equals(element.text("joint2"))) {
            throw element.problem("the joint " + element.text("joint1") + " is coupled to itself");
        }
        return Optional.of(
                new Coupling(element.text("joint1"), element.text("joint2"), terms[1], terms[0]));
    }

    private Scene scene() throws RobotFileException {
        double[] gravity = GRAVITY;
        double step = STEP;
        for (XmlElement option : root.all("option")) {
            ignored.attributes(option, Set.of("gravity", "timestep"));
            gravity = option.numbers("gravity", gravity);
            step = option.number("timestep", step);
            if (!(step > 0)) {
                throw option.problem("timestep is " + step + " s, expected more than 0");
            }
            for (XmlElement flag : option.all("flag")) {
                ignored.attributes(flag, Set.of("gravity"));
                if (flag.find("gravity").orElse("enable").equals("disable")) {
                    gravity = new double[3];
                }
            }
        }
        return new Scene(gravity, step, scenery);
    }

    /**
     * A body, with its pose in the frame of the body that contains it, and the default class that
     * it inherits.
     */
    private record Nested(XmlElement element, Pose outer, String inherited) {}

    /** The content of a body, including that of the frames in the body. */
    private static final class Group {
        final String name;
        final List<Geom> geoms = new ArrayList<>();
        final List<XmlElement> joints = new ArrayList<>();
        final List<Nested> bodies = new ArrayList<>();
        Optional<XmlElement> inertial = Optional.empty();

        Group(String name) {
            this.name = name;
        }
    }

    private void collect(XmlElement element, Pose outer, String inherited, Group into)
            throws RobotFileException {
        boolean isWorld = into.name.isEmpty();
        for (XmlElement child : element.children()) {
            switch (child.name()) {
                case "body" -> into.bodies.add(new Nested(child, outer, inherited));
                case "frame" -> {
                    ignored.attributes(child, BODY);
                    collect(
                            child,
                            compiler.pose(child).within(outer),
                            defaults.childClass(child, inherited),
                            into);
                }
                case "geom" -> {
                    if (++geomCount > MAX_GEOMS) {
                        throw child.problem("the file has more than " + MAX_GEOMS + " geoms");
                    }
                    into.geoms.add(geoms.read(defaults.resolve(child, inherited), outer, isWorld));
                }
                case "joint", "freejoint" -> {
                    if (isWorld || outer != Pose.ORIGIN) {
                        throw child.problem(
                                "<"
                                        + child.name()
                                        + "> is outside of a body; expected it in a"
                                        + " <body>");
                    }
                    into.joints.add(
                            child.name().equals("joint")
                                    ? defaults.resolve(child, inherited)
                                    : child);
                }
                case "inertial" -> into.inertial = Optional.of(child);
                default -> ignored.add("<" + child.name() + "> of bodies");
            }
        }
    }

    /**
     * Turns the geoms of the world body that collide into scenery, and the other geoms into shapes
     * of its link.
     */
    private void putWorld(Group world) {
        List<Geometry> looks = new ArrayList<>();
        for (Geom geom : world.geoms) {
            if (geom.geometry().isEmpty()) {
                continue;
            }
            if (geom.collides()) {
                scenery.add(new Scenery(geom.name(), geom.geometry().get(), geom.surface()));
            } else {
                looks.add(geom.geometry().get());
            }
        }
        links.put(
                WORLD,
                new Link(
                        WORLD, root.place(), Optional.empty(), looks, List.of(), Optional.empty()));
    }

    private void body(Nested nested, String parent) throws RobotFileException {
        XmlElement element = nested.element;
        ignored.attributes(element, BODY);
        String name = element.find("name").orElse("body " + links.size());
        if (links.containsKey(name)) {
            throw element.problem("a second body has the name " + name);
        }
        if (links.size() > MAX_BODIES) {
            throw element.problem("the file has more than " + MAX_BODIES + " bodies");
        }
        Group group = new Group(name);
        String inherited = defaults.childClass(element, nested.inherited);
        collect(element, Pose.ORIGIN, inherited, group);
        Optional<Inertial> inertial = inertial(group);
        Pose pose = compiler.pose(element).within(nested.outer);
        int count = group.joints.size();
        if (count > MAX_JOINTS_OF_A_BODY) {
            throw element.problem(
                    "the body "
                            + name
                            + " has "
                            + count
                            + " joints, expected at most "
                            + MAX_JOINTS_OF_A_BODY);
        }
        String above = parent;
        if (count == 0) {
            put(fixed(name, element.place(), parent, pose));
        }
        for (int i = 0; i < count; i++) {
            boolean isLast = i == count - 1;
            String link = isLast ? name : name + " link " + (i + 1);
            if (!isLast) {
                Optional<Inertial> part = inertial.map(whole -> share(whole, SHARE));
                links.put(link, link(link, element, part, List.of()));
            }
            put(joint(group.joints.get(i), above, link, i == 0 ? pose : Pose.ORIGIN, count));
            above = link;
        }
        if (count > 1) {
            notes.add(
                    "body "
                            + name
                            + ": it has "
                            + count
                            + " joints; bodies between them have "
                            + Math.round(100 * SHARE)
                            + " % of its mass each");
        }
        double left = 1 - SHARE * Math.max(count - 1, 0);
        links.put(
                name, link(name, element, inertial.map(whole -> share(whole, left)), group.geoms));
        for (Nested child : group.bodies) {
            body(child, name);
        }
    }

    private static Inertial share(Inertial whole, double part) {
        if (part == 1) {
            return whole;
        }
        double[] inertia = whole.inertia().clone();
        for (int i = 0; i < inertia.length; i++) {
            inertia[i] *= part;
        }
        return new Inertial(whole.pose(), part * whole.mass(), inertia);
    }

    private Link link(
            String name, XmlElement element, Optional<Inertial> inertial, List<Geom> shapes) {
        List<Geometry> looks = new ArrayList<>();
        List<Geometry> collisions = new ArrayList<>();
        Optional<Surface> surface = Optional.empty();
        boolean hasLooks = shapes.stream().anyMatch(geom -> !geom.collides());
        for (Geom geom : shapes) {
            if (geom.geometry().isEmpty()) {
                continue;
            }
            if (!geom.collides() || !geom.isHidden() || !hasLooks) {
                looks.add(geom.geometry().get());
            }
            if (!geom.collides()) {
                continue;
            }
            collisions.add(geom.geometry().get());
            if (surface.isPresent() && !surface.get().equals(geom.surface())) {
                ignored.add(
                        "different contype, conaffinity or friction of the geoms of one body; all"
                                + " bits count, and the first friction");
            }
            int type = surface.map(Surface::type).orElse(0) | geom.surface().type();
            int affinity = surface.map(Surface::affinity).orElse(0) | geom.surface().affinity();
            Surface first = surface.orElse(geom.surface());
            surface =
                    Optional.of(
                            new Surface(
                                    type,
                                    affinity,
                                    first.friction(),
                                    first.spinning(),
                                    first.rolling()));
        }
        return new Link(name, element.place(), inertial, looks, collisions, surface);
    }

    private Optional<Inertial> inertial(Group group) throws RobotFileException {
        boolean fromGeoms =
                switch (compiler.inertiaFromGeoms) {
                    case "true" -> true;
                    case "false" -> false;
                    default -> group.inertial.isEmpty();
                };
        if (fromGeoms) {
            return MjcfGeoms.sum(group.geoms);
        }
        if (group.inertial.isEmpty()) {
            return Optional.empty();
        }
        XmlElement element = group.inertial.get();
        element.text("pos");
        Pose pose = compiler.pose(element);
        double mass = element.number("mass");
        double[] inertia = new double[6];
        if (element.find("fullinertia").isPresent()) {
            double[] full = element.list("fullinertia", 6, 6);
            inertia = new double[] {full[0], full[1], full[2], full[5], full[4], full[3]};
        } else {
            System.arraycopy(element.list("diaginertia", 3, 3), 0, inertia, 0, 3);
        }
        if (mass < 0) {
            throw element.problem("the mass is " + mass + " kg, expected 0 or more");
        }
        return mass > 0 ? Optional.of(new Inertial(pose, mass, inertia)) : Optional.empty();
    }

    private void put(Joint joint) throws RobotFileException {
        if (joints.put(joint.name(), joint) != null) {
            throw new RobotFileException(
                    joint.place() + ": a second joint has the name " + joint.name());
        }
    }

    private static Joint fixed(String child, String place, String parent, Pose pose) {
        return new Joint(
                child + " weld",
                place,
                JointType.FIXED,
                parent,
                child,
                pose,
                new double[3],
                new double[] {0, 0, 1},
                Optional.empty(),
                0,
                Loads.NONE,
                List.of());
    }

    private Joint joint(XmlElement element, String parent, String child, Pose pose, int count)
            throws RobotFileException {
        String stated =
                element.name().equals("freejoint") ? "free" : element.find("type").orElse("hinge");
        String name = element.find("name").orElse(child + " joint");
        JointType type =
                switch (stated) {
                    case "hinge" -> JointType.CONTINUOUS;
                    case "slide" -> JointType.PRISMATIC;
                    case "ball" -> JointType.BALL;
                    case "free" -> JointType.FLOATING;
                    default ->
                            throw element.problem(
                                    "the joint has the type "
                                            + stated
                                            + ", expected hinge, slide, ball or free");
                };
        if (type == JointType.FLOATING) {
            if (!parent.equals(WORLD) || count > 1) {
                throw element.problem(
                        "a free joint is below another body or joint; expected it as the only"
                                + " joint of a body in <worldbody>");
            }
            hasFree = true;
            type = base == RobotImport.Base.FIXED ? JointType.FIXED : type;
        } else {
            ignored.attributes(element, JOINT);
        }
        double[] axis = element.numbers("axis", 0, 0, 1);
        double factor =
                type == JointType.CONTINUOUS || type == JointType.BALL ? compiler.angle() : 1;
        double ref = factor * element.number("ref", 0);
        Optional<double[]> limits = compiler.range(element, "range", "limited");
        if (type == JointType.BALL && limits.isPresent()) {
            ignored.add("range of joints of type ball");
            limits = Optional.empty();
        }
        if (ref != 0) {
            notes.add("joint " + name + ": its angle or travel is 0 at the start, not " + ref);
        }
        return new Joint(
                name,
                element.place(),
                type,
                parent,
                child,
                pose,
                element.numbers("pos", 0, 0, 0),
                MjcfCompiler.unit(element, "axis", axis[0], axis[1], axis[2]),
                limits.map(each -> new double[] {factor * each[0] - ref, factor * each[1] - ref}),
                0,
                loads(element, type, factor, ref),
                List.<Drive>of());
    }

    /**
     * Reads the loads that act along the axis of a joint.
     *
     * @param factor factor that converts angles of the file to radians; 1 for a slider
     * @param ref angle or travel at the start, in the convention of the file
     */
    private Loads loads(XmlElement element, JointType type, double factor, double ref)
            throws RobotFileException {
        double damping = notNegative(element, "damping");
        double friction = notNegative(element, "frictionloss");
        double stiffness = notNegative(element, "stiffness");
        double rotor = notNegative(element, "armature");
        double rest = factor * element.number("springref", 0) - ref;
        if (type == JointType.CONTINUOUS || type == JointType.PRISMATIC) {
            return new Loads(damping, friction, stiffness, stiffness > 0 ? rest : 0, rotor);
        }
        boolean isBall = type == JointType.BALL;
        String of = " of joints of type " + (isBall ? "ball" : "free");
        if (friction != 0) {
            ignored.add("frictionloss" + of);
        }
        if (stiffness != 0) {
            ignored.add("stiffness" + of);
        }
        if (rotor != 0) {
            ignored.add("armature" + of);
        }
        if (damping != 0 && !isBall) {
            ignored.add("damping" + of);
        }
        return isBall ? new Loads(damping, 0, 0, 0, 0) : Loads.NONE;
    }

    private static double notNegative(XmlElement element, String attribute)
            throws RobotFileException {
        double number = element.number(attribute, 0);
        if (number < 0) {
            throw element.problem(attribute + " is " + number + ", expected 0 or more");
        }
        return number;
    }
}
