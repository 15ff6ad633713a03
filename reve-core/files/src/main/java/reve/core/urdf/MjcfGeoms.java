// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.mesh.HeightGrid;
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

    /** The default friction: coefficient of sliding [1], lever arms of spin and of rolling [m]. */
    private static final double[] FRICTION = {1, 0.005, 0.0001};

    // Dimensions of contacts (condim): the normal force, then two for sliding, one for spin, two
    // for rolling.
    private static final int FRICTIONLESS = 1;
    private static final int SLIDING = 3;
    private static final int SPINNING = 4;
    private static final int ROLLING = 6;
    private static final Set<String> READ =
            Set.of(
                    "name",
                    "class",
                    "type",
                    "contype",
                    "conaffinity",
                    "group",
                    "friction",
                    "condim",
                    "mass",
                    "density",
                    "rgba",
                    "material",
                    "mesh",
                    "hfield",
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
    private final Map<String, Optional<Form>> heightFields = new HashMap<>();

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
            case "hfield" -> heightField(asset);
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
     * Reads a height field. Its heights are relative: the lowest one becomes 0, and the highest one
     * the third number of the size.
     */
    private void heightField(XmlElement field) throws RobotFileException {
        ignored.attributes(
                field,
                Set.of(
                        "name",
                        "class",
                        "file",
                        "content_type",
                        "nrow",
                        "ncol",
                        "elevation",
                        "size"));
        double[] size = field.list("size", 4, 4);
        field.requireLengths(size);
        String file = field.find("file").orElse("");
        String base = file.substring(file.lastIndexOf('/') + 1).replaceFirst("\\.[^.]*$", "");
        String name = field.find("name").orElse(base);
        float[][] rows;
        if (file.isEmpty()) {
            rows = elevation(field);
        } else {
            HeightGrid grid;
            try {
                grid = files.image(field.place(), compiler.meshPath(file));
            } catch (RobotFileException unreadable) {
                ignored.add("a height field: " + unreadable.getMessage());
                heightFields.put(name, Optional.empty());
                return;
            }
            rows = new float[grid.rows()][];
            for (int i = 0; i < rows.length; i++) {
                rows[i] =
                        Arrays.copyOfRange(
                                grid.values(), i * grid.columns(), (i + 1) * grid.columns());
            }
        }
        scale(rows, size[2]);
        heightFields.put(name, Optional.of(new Form.Terrain(name, 2 * size[0], 2 * size[1], rows)));
    }

    /** Returns the heights that the file itself contains. They are 0 if it states none. */
    private static float[][] elevation(XmlElement field) throws RobotFileException {
        double rows = field.number("nrow");
        double columns = field.number("ncol");
        if (!(rows >= 2 && columns >= 2 && rows * columns <= HeightGrid.MAX_HEIGHTS)) {
            throw field.problem(
                    "the height field has "
                            + rows
                            + " x "
                            + columns
                            + " heights, expected at least 2 x 2 and at most "
                            + HeightGrid.MAX_HEIGHTS
                            + " in all");
        }
        float[][] heights = new float[(int) rows][(int) columns];
        if (field.find("elevation").isPresent()) {
            int count = heights.length * heights[0].length;
            double[] all = field.list("elevation", count, count);
            for (int i = 0; i < count; i++) {
                heights[i / heights[0].length][i % heights[0].length] = (float) all[i];
            }
        }
        return heights;
    }

    /** Moves and scales heights to the range from 0 to {@code highest}. */
    private static void scale(float[][] rows, double highest) {
        float low = Float.POSITIVE_INFINITY;
        float high = Float.NEGATIVE_INFINITY;
        for (float[] row : rows) {
            for (float height : row) {
                low = Math.min(low, height);
                high = Math.max(high, height);
            }
        }
        for (float[] row : rows) {
            for (int i = 0; i < row.length; i++) {
                row[i] = high > low ? (float) (highest * (row[i] - low) / (high - low)) : 0;
            }
        }
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
                counts && form.isPresent() ? solid(geom, form.get(), pose) : Optional.empty();
        Pose placed = pose;
        return new Geom(
                geom.find("name").orElse(type),
                form.map(each -> new Geometry(geom.place(), placed, each, Optional.of(colour))),
                solid,
                surface(geom),
                group >= FIRST_HIDDEN_GROUP);
    }

    /**
     * Reads how a geom collides. The number of dimensions {@code condim} of its contacts determines
     * which of the three values of {@code friction} have an effect.
     */
    private Surface surface(XmlElement geom) throws RobotFileException {
        double[] friction = FRICTION.clone();
        if (geom.find("friction").isPresent()) {
            double[] given = geom.list("friction", 1, 3);
            System.arraycopy(given, 0, friction, 0, given.length);
        }
        for (double each : friction) {
            if (each < 0) {
                throw geom.problem("the friction is " + each + ", expected 0 or more");
            }
        }
        double dimensions = geom.number("condim", SLIDING);
        if (dimensions != FRICTIONLESS
                && dimensions != SLIDING
                && dimensions != SPINNING
                && dimensions != ROLLING) {
            throw geom.problem("condim is " + dimensions + ", expected 1, 3, 4 or 6");
        }
        return new Surface(
                (int) geom.number("contype", 1),
                (int) geom.number("conaffinity", 1),
                dimensions == FRICTIONLESS ? 0 : friction[0],
                dimensions >= SPINNING ? friction[1] : 0,
                dimensions >= ROLLING ? friction[2] : 0);
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
                return Optional.of(new Form.Box(extents(geom, half)));
            case "ellipsoid":
                return Optional.of(new Form.Ellipsoid(extents(geom, half)));
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
            case "hfield":
                if (!isStatic) {
                    throw geom.problem(
                            "a height field is on a body that moves; expected a fixed one");
                }
                Optional<Form> terrain = heightFields.get(geom.text("hfield"));
                if (terrain == null) {
                    throw geom.problem("there is no height field " + geom.text("hfield"));
                }
                return terrain;
            case "sdf":
                ignored.add("geoms of type sdf");
                return Optional.empty();
            default:
                throw geom.problem(
                        "the type "
                                + type
                                + " is unknown; expected plane, hfield, sphere, capsule,"
                                + " ellipsoid, cylinder, box, mesh or sdf");
        }
    }

    /** Returns the extents of a box or an ellipsoid, for which the file states the halves. */
    private static double[] extents(XmlElement geom, double half) throws RobotFileException {
        if (half > 0) {
            double across = 2 * size(geom, 1)[0];
            return new double[] {across, across, 2 * half};
        }
        double[] halves = size(geom, 3);
        return new double[] {2 * halves[0], 2 * halves[1], 2 * halves[2]};
    }

    private static double[] size(XmlElement geom, int count) throws RobotFileException {
        double[] size = geom.list("size", count, 3);
        geom.requireLengths(Arrays.copyOf(size, count));
        return size;
    }

    private Optional<Inertial> solid(XmlElement geom, Form form, Pose pose)
            throws RobotFileException {
        Optional<MassProperties> found = properties(geom, form);
        if (found.isEmpty()) {
            return Optional.empty();
        }
        MassProperties unit = found.get();
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
            case Form.Ellipsoid round ->
                    Optional.of(
                            MassProperties.of(
                                    Shape.ellipsoid(
                                            round.size()[0], round.size()[1], round.size()[2]),
                                    1));
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
            case Form.Terrain _ -> Optional.empty();
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
