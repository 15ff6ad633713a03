// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.mesh.MassProperties;
import reve.core.urdf.RobotModel.Form;
import reve.core.urdf.RobotModel.Geometry;
import reve.core.urdf.RobotModel.Inertial;
import reve.core.urdf.RobotModel.Surface;
import reve.core.world.Pose;
import reve.core.world.Shape;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** Reader of the shapes (geoms) of an MJCF file, with their masses. */
final class MjcfGeoms {
    private static final double DENSITY = 1000; // [kg/m^3]
    private static final double ENDLESS = 200; // edge of a plane without limits [m]
    private static final int FIRST_HIDDEN_GROUP = 3;
    private static final Set<String> READ =
            Set.of(
                    "name",
                    "class",
                    "type",
                    "contype",
                    "conaffinity",
                    "group",
                    "friction",
                    "mass",
                    "density",
                    "rgba",
                    "material",
                    "mesh",
                    "size",
                    "fromto",
                    "pos",
                    "quat",
                    "axisangle",
                    "xyaxes",
                    "zaxis",
                    "euler");

    private final MjcfCompiler compiler;
    private final MeshFiles files;
    private final Ignored ignored;
    private final Map<String, Form.MeshFile> meshes = new HashMap<>();
    private final Map<String, String> materials = new HashMap<>();

    /**
     * A shape.
     *
     * @param geometry the shape in a world; empty if worlds have no such shape
     * @param solid mass and inertia; empty if the shape has no mass
     */
    record Geom(
            String name,
            Optional<Geometry> geometry,
            Optional<Inertial> solid,
            Surface surface,
            boolean isHidden) {
        boolean collides() {
            return surface.type() != 0 || surface.affinity() != 0;
        }
    }

    MjcfGeoms(MjcfCompiler compiler, MeshFiles files, Ignored ignored) {
        this.compiler = compiler;
        this.files = files;
        this.ignored = ignored;
    }

    /** Reads the definition of a mesh or a material. */
    void asset(XmlElement asset) throws RobotFileException {
        switch (asset.name()) {
            case "mesh" -> mesh(asset);
            case "material" -> {
                if (asset.find("texture").isPresent() || !asset.children().isEmpty()) {
                    ignored.add("textures of materials");
                }
                materials.put(asset.text("name"), colour(asset.numbers("rgba", 1, 1, 1, 1)));
            }
            default -> ignored.add("<asset> <" + asset.name() + ">");
        }
    }

    private void mesh(XmlElement mesh) throws RobotFileException {
        if (mesh.find("file").isEmpty()) {
            ignored.add("meshes without a file");
            return;
        }
        ignored.attributes(mesh, Set.of("name", "class", "file", "scale", "content_type"));
        String file = mesh.text("file");
        String base = file.substring(file.lastIndexOf('/') + 1).replaceFirst("\\.[^.]*$", "");
        meshes.put(
                mesh.find("name").orElse(base),
                new Form.MeshFile(compiler.meshPath(file), mesh.numbers("scale", 1, 1, 1)));
    }

    /**
     * Reads a geom.
     *
     * @param geom the element, with its default values
     * @param outer pose of the frame that contains the geom, in the frame of the link
     * @param isStatic whether the link is the world
     */
    Geom read(XmlElement geom, Pose outer, boolean isStatic) throws RobotFileException {
        ignored.attributes(geom, READ);
        String type = geom.find("type").orElse("sphere");
        Pose pose = compiler.pose(geom).within(outer);
        double half = 0;
        if (geom.find("fromto").isPresent()) {
            double[] ends = geom.list("fromto", 6, 6);
            double[] middle = new double[3];
            double[] way = new double[3];
            for (int axis = 0; axis < 3; axis++) {
                middle[axis] = 0.5 * (ends[axis] + ends[axis + 3]);
                way[axis] = ends[axis] - ends[axis + 3];
            }
            double[] z = MjcfCompiler.unit(geom, "fromto", way[0], way[1], way[2]);
            half = 0.5 * Math.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
            pose = Pose.of(middle, MjcfCompiler.fromZ(z)).within(outer);
        }
        Optional<Form> form = form(geom, type, half, isStatic);
        String colour =
                geom.find("rgba").isPresent()
                        ? colour(geom.numbers("rgba", 0, 0, 0, 1))
                        : geom.find("material").map(materials::get).orElse("#808080");
        int group = (int) geom.number("group", 0);
        boolean counts = group >= compiler.inertiaGroups[0] && group <= compiler.inertiaGroups[1];
        Optional<Inertial> solid =
                counts && !type.equals("plane")
                        ? solid(geom, type, form, half, pose)
                        : Optional.empty();
        Pose placed = pose;
        return new Geom(
                geom.find("name").orElse(type),
                form.map(each -> new Geometry(geom.place(), placed, each, Optional.of(colour))),
                solid,
                new Surface(
                        (int) geom.number("contype", 1),
                        (int) geom.number("conaffinity", 1),
                        geom.find("friction").isPresent() ? friction(geom) : 1),
                group >= FIRST_HIDDEN_GROUP);
    }

    private double friction(XmlElement geom) throws RobotFileException {
        double[] friction = geom.list("friction", 1, 3);
        if (friction.length > 1 && friction[1] != 0.005
                || friction.length > 2 && friction[2] != 0.0001) {
            ignored.add("friction of geoms against spinning and rolling");
        }
        if (friction[0] < 0) {
            throw geom.problem("the friction is " + friction[0] + ", expected 0 or more");
        }
        return friction[0];
    }

    private Optional<Form> form(XmlElement geom, String type, double half, boolean isStatic)
            throws RobotFileException {
        if (!type.equals("mesh") && geom.find("mesh").isPresent()) {
            ignored.add("geoms that are fitted to a mesh; their shape and mass are left out");
            return Optional.empty();
        }
        switch (type) {
            case "sphere":
                return Optional.of(new Form.Sphere(size(geom, 1)[0]));
            case "capsule":
                double[] capsule = size(geom, half > 0 ? 1 : 2);
                double ends = 2 * capsule[0];
                return Optional.of(
                        new Form.Capsule(capsule[0], ends + 2 * (half > 0 ? half : capsule[1])));
            case "cylinder":
                double[] cylinder = size(geom, half > 0 ? 1 : 2);
                return Optional.of(
                        new Form.Cylinder(cylinder[0], 2 * (half > 0 ? half : cylinder[1])));
            case "box":
                double[] box = extents(geom, half);
                return Optional.of(new Form.Box(new double[] {2 * box[0], 2 * box[1], 2 * box[2]}));
            case "plane":
                if (!isStatic) {
                    throw geom.problem("a plane is on a body that moves; expected a fixed one");
                }
                double[] plane = geom.list("size", 1, 3);
                double x = plane[0] > 0 ? 2 * plane[0] : ENDLESS;
                double y = plane.length > 1 && plane[1] > 0 ? 2 * plane[1] : ENDLESS;
                return Optional.of(new Form.Plane(x, y));
            case "mesh":
                Form.MeshFile mesh = meshes.get(geom.text("mesh"));
                if (mesh == null) {
                    throw geom.problem("there is no mesh " + geom.text("mesh"));
                }
                return Optional.of(mesh);
            case "ellipsoid":
                ignored.add("shapes of geoms of type ellipsoid, whose masses count");
                return Optional.empty();
            case "hfield", "sdf":
                ignored.add("geoms of type " + type);
                return Optional.empty();
            default:
                throw geom.problem(
                        "the type "
                                + type
                                + " is unknown; expected plane, hfield, sphere, capsule,"
                                + " ellipsoid, cylinder, box, mesh or sdf");
        }
    }

    /** Returns the half extents of a box or an ellipsoid. */
    private static double[] extents(XmlElement geom, double half) throws RobotFileException {
        if (half > 0) {
            double radius = size(geom, 1)[0];
            return new double[] {radius, radius, half};
        }
        return size(geom, 3);
    }

    private static double[] size(XmlElement geom, int count) throws RobotFileException {
        double[] size = geom.list("size", count, 3);
        geom.requireLengths(Arrays.copyOf(size, count));
        return size;
    }

    private Optional<Inertial> solid(
            XmlElement geom, String type, Optional<Form> form, double half, Pose pose)
            throws RobotFileException {
        boolean isEllipsoid = type.equals("ellipsoid") && geom.find("mesh").isEmpty();
        if (form.isEmpty() && !isEllipsoid) {
            return Optional.empty();
        }
        MassProperties unit;
        if (isEllipsoid) {
            unit = ellipsoid(extents(geom, half));
        } else {
            Optional<MassProperties> found = properties(geom, form.get());
            if (found.isEmpty()) {
                return Optional.empty();
            }
            unit = found.get();
        }
        double density = geom.number("density", DENSITY);
        if (geom.find("mass").isPresent()) {
            density = geom.number("mass") / unit.volume();
        }
        if (density < 0) {
            throw geom.problem("the mass or density is below 0, expected 0 or more");
        }
        if (density == 0) {
            return Optional.empty();
        }
        double[] m = unit.moments();
        double[] p = unit.products();
        double[] inertia = {m[0], m[1], m[2], p[0], p[1], p[2]};
        for (int i = 0; i < inertia.length; i++) {
            inertia[i] *= density;
        }
        double[] c = unit.centre();
        return Optional.of(
                new Inertial(
                        new Pose(c[0], c[1], c[2], 0, 0, 0, 1).within(pose),
                        unit.volume() * density,
                        inertia));
    }

    private Optional<MassProperties> properties(XmlElement geom, Form form) {
        return switch (form) {
            case Form.Box box ->
                    Optional.of(
                            MassProperties.of(
                                    Shape.box(box.size()[0], box.size()[1], box.size()[2]), 1));
            case Form.Sphere sphere ->
                    Optional.of(MassProperties.of(Shape.sphere(sphere.radius()), 1));
            case Form.Cylinder round ->
                    Optional.of(
                            alongZ(
                                    MassProperties.of(
                                            Shape.cylinder(round.radius(), round.length()), 1)));
            case Form.Capsule round ->
                    Optional.of(
                            alongZ(
                                    MassProperties.of(
                                            Shape.capsule(round.radius(), round.length()), 1)));
            case Form.Plane _ -> Optional.empty();
            case Form.MeshFile mesh -> {
                try {
                    yield Optional.of(files.solid(geom.place(), mesh));
                } catch (RobotFileException unreadable) {
                    ignored.add("the mass of a mesh: " + unreadable.getMessage());
                    yield Optional.empty();
                }
            }
        };
    }

    /**
     * Converts the properties of a solid along the Y axis to those of the same solid along the Z
     * axis.
     */
    private static MassProperties alongZ(MassProperties y) {
        double[] m = y.moments();
        return new MassProperties(
                y.volume(), y.mass(), y.centre(), new double[] {m[0], m[2], m[1]}, y.products());
    }

    private static MassProperties ellipsoid(double[] half) {
        double volume = 4 * Math.PI / 3 * half[0] * half[1] * half[2];
        double[] moments = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            double one = half[(axis + 1) % 3];
            double other = half[(axis + 2) % 3];
            moments[axis] = volume / 5 * (one * one + other * other);
        }
        return new MassProperties(volume, volume, new double[3], moments, new double[3]);
    }

    /** Adds up the masses and the inertia of the geoms of a link; empty if no geom has a mass. */
    static Optional<Inertial> sum(List<Geom> geoms) {
        List<Inertial> solids = new ArrayList<>();
        for (Geom geom : geoms) {
            geom.solid().ifPresent(solids::add);
        }
        double mass = 0;
        double[] centre = new double[3];
        for (Inertial solid : solids) {
            mass += solid.mass();
            for (int axis = 0; axis < 3; axis++) {
                centre[axis] += solid.mass() * solid.pose().location()[axis];
            }
        }
        if (!(mass > 0)) {
            return Optional.empty();
        }
        for (int axis = 0; axis < 3; axis++) {
            centre[axis] /= mass;
        }
        SymmetricMatrix inertia = new SymmetricMatrix(new double[6]);
        for (Inertial solid : solids) {
            double[] from = solid.pose().location();
            for (int axis = 0; axis < 3; axis++) {
                from[axis] -= centre[axis];
            }
            inertia =
                    inertia.plus(new SymmetricMatrix(solid.inertia()).turned(solid.pose()))
                            .plus(SymmetricMatrix.ofPoint(solid.mass(), from));
        }
        Pose pose = new Pose(centre[0], centre[1], centre[2], 0, 0, 0, 1);
        return Optional.of(new Inertial(pose, mass, inertia.values()));
    }

    private static String colour(double[] rgba) {
        StringBuilder text = new StringBuilder("#");
        for (double part : rgba) {
            text.append("%02x".formatted(Math.round(255 * Math.clamp(part, 0, 1))));
        }
        return text.toString().endsWith("ff") ? text.substring(0, 7) : text.toString();
    }
}
