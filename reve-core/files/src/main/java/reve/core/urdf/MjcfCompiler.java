// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.world.Pose;

import java.util.List;
import java.util.Optional;
import java.util.Set;

/**
 * The attributes of the element {@code compiler} of an MJCF file. They determine how the file
 * states angles, limits, poses and paths.
 */
final class MjcfCompiler {
    static final Set<String> READ =
            Set.of(
                    "angle",
                    "eulerseq",
                    "autolimits",
                    "meshdir",
                    "assetdir",
                    "strippath",
                    "inertiafromgeom",
                    "inertiagrouprange",
                    "coordinate");
    private static final Set<String> ORIENTATIONS = Set.of("axisangle", "xyaxes", "zaxis", "euler");

    private final double angle;
    private final String eulerSequence;
    private final boolean isAutomatic;
    private final String meshFolder;
    private final boolean stripsPaths;

    /**
     * Whether the inertia of a body is computed from its geoms: {@code auto}, {@code true} or
     * {@code false}.
     */
    final String inertiaFromGeoms;

    /** Smallest and largest group of the geoms from which masses are computed. */
    final double[] inertiaGroups;

    /**
     * @param elements the elements {@code compiler}; attributes of later ones override those of
     *     earlier ones
     */
    MjcfCompiler(List<XmlElement> elements) throws RobotFileException {
        this.angle = choice(elements, "angle", "degree", "radian").equals("degree") ? DEGREE : 1;
        this.isAutomatic = choice(elements, "autolimits", "true", "false").equals("true");
        this.stripsPaths = choice(elements, "strippath", "false", "true").equals("true");
        this.inertiaFromGeoms = choice(elements, "inertiafromgeom", "auto", "true", "false");
        choice(elements, "coordinate", "local");
        String sequence = "xyz";
        String folder = "";
        double[] groups = {0, 5};
        for (XmlElement element : elements) {
            folder = element.find("meshdir").or(() -> element.find("assetdir")).orElse(folder);
            groups = element.numbers("inertiagrouprange", groups);
            if (element.find("eulerseq").isPresent()) {
                sequence = element.text("eulerseq");
                if (!sequence.matches("[xyzXYZ]{3}")) {
                    throw element.problem(
                            "eulerseq is " + sequence + ", expected three of x y z X Y Z");
                }
            }
        }
        this.eulerSequence = sequence;
        this.meshFolder = folder.isEmpty() || folder.endsWith("/") ? folder : folder + "/";
        this.inertiaGroups = groups;
    }

    private static final double DEGREE = Math.PI / 180;

    /** Returns the last value of an attribute. The default is the first choice. */
    private static String choice(List<XmlElement> elements, String attribute, String... choices)
            throws RobotFileException {
        String chosen = choices[0];
        for (XmlElement element : elements) {
            if (element.find(attribute).isPresent()) {
                chosen = element.text(attribute);
                if (!List.of(choices).contains(chosen)) {
                    throw element.problem(
                            attribute
                                    + " is "
                                    + chosen
                                    + ", expected "
                                    + String.join(" or ", choices));
                }
            }
        }
        return chosen;
    }

    /** Returns the factor that converts angles of the file to radians. */
    double angle() {
        return angle;
    }

    /** Returns the path of a mesh file relative to the folder of the first file. */
    String meshPath(String file) {
        return meshFolder + (stripsPaths ? file.substring(file.lastIndexOf('/') + 1) : file);
    }

    /**
     * Returns the range of an attribute; empty if the range has no effect.
     *
     * @param limited name of the attribute that states whether the range has an effect
     */
    Optional<double[]> range(XmlElement element, String attribute, String limited)
            throws RobotFileException {
        String stated = element.find(limited).orElse("auto");
        boolean has = element.find(attribute).isPresent();
        if (stated.equals("false") || !has && !stated.equals("true") || !has) {
            return Optional.empty();
        }
        if (stated.equals("auto") && !isAutomatic) {
            return Optional.empty();
        }
        double[] range = element.list(attribute, 2, 2);
        if (!(range[0] < range[1])) {
            throw element.problem(
                    attribute
                            + " is from "
                            + range[0]
                            + " to "
                            + range[1]
                            + ", expected the lower value first");
        }
        return Optional.of(range);
    }

    /** Returns the pose of an element, from {@code pos} and its orientation. */
    Pose pose(XmlElement element) throws RobotFileException {
        return Pose.of(element.numbers("pos", 0, 0, 0), orientation(element));
    }

    private double[] orientation(XmlElement element) throws RobotFileException {
        if (ORIENTATIONS.stream().filter(name -> element.find(name).isPresent()).count() > 1) {
            throw element.problem(
                    "<"
                            + element.name()
                            + "> states its orientation twice; expected one of"
                            + " quat, axisangle, xyaxes, zaxis, euler");
        }
        if (element.find("axisangle").isPresent()) {
            double[] turn = element.list("axisangle", 4, 4);
            return about(unit(element, "axisangle", turn[0], turn[1], turn[2]), angle * turn[3]);
        }
        if (element.find("xyaxes").isPresent()) {
            double[] axes = element.list("xyaxes", 6, 6);
            double[] x = unit(element, "xyaxes", axes[0], axes[1], axes[2]);
            double along = x[0] * axes[3] + x[1] * axes[4] + x[2] * axes[5];
            double[] y =
                    unit(
                            element,
                            "xyaxes",
                            axes[3] - along * x[0],
                            axes[4] - along * x[1],
                            axes[5] - along * x[2]);
            double[] z = cross(x, y);
            return SymmetricMatrix.quaternion(
                    new double[][] {{x[0], y[0], z[0]}, {x[1], y[1], z[1]}, {x[2], y[2], z[2]}});
        }
        if (element.find("zaxis").isPresent()) {
            double[] z = element.list("zaxis", 3, 3);
            return fromZ(unit(element, "zaxis", z[0], z[1], z[2]));
        }
        if (element.find("euler").isPresent()) {
            return euler(element.list("euler", 3, 3));
        }
        double[] quat = element.numbers("quat", 1, 0, 0, 0);
        double square = 0;
        for (double part : quat) {
            square += part * part;
        }
        if (!(square > 0)) {
            throw element.problem("the quaternion is 0 0 0 0, expected a rotation w x y z");
        }
        return new double[] {quat[1], quat[2], quat[3], quat[0]};
    }

    /**
     * Returns the rotation (quaternion xyzw) of three successive turns. The axis of a turn either
     * turns along with the earlier turns (x, y, z) or is fixed (X, Y, Z).
     *
     * @param angles angles of the turns, in the unit of the file
     */
    private double[] euler(double[] angles) {
        Pose turn = Pose.ORIGIN;
        for (int i = 0; i < angles.length; i++) {
            char letter = eulerSequence.charAt(i);
            double[] axis = new double[3];
            axis[Character.toLowerCase(letter) - 'x'] = 1;
            Pose one = Pose.of(new double[3], about(axis, angle * angles[i]));
            turn = Character.isLowerCase(letter) ? one.within(turn) : turn.within(one);
        }
        return turn.orientation();
    }

    private static double[] about(double[] axis, double radians) {
        double sine = Math.sin(radians / 2);
        return new double[] {sine * axis[0], sine * axis[1], sine * axis[2], Math.cos(radians / 2)};
    }

    /** Returns the smallest rotation (quaternion xyzw) from +Z to a unit vector. */
    static double[] fromZ(double[] z) {
        double sine = Math.hypot(z[0], z[1]);
        if (!(sine > 0)) {
            return z[2] > 0 ? new double[] {0, 0, 0, 1} : new double[] {1, 0, 0, 0};
        }
        return about(new double[] {-z[1] / sine, z[0] / sine, 0}, Math.atan2(sine, z[2]));
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }

    /** Returns a vector of length 1. */
    static double[] unit(XmlElement element, String attribute, double x, double y, double z)
            throws RobotFileException {
        double length = Math.sqrt(x * x + y * y + z * z);
        if (!(length > 0)) {
            throw element.problem(attribute + ": a vector has the length 0, expected a direction");
        }
        return new double[] {x / length, y / length, z / length};
    }
}
