// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.urdf.RobotModel.Drive;
import reve.core.urdf.RobotModel.DriveKind;
import reve.core.urdf.RobotModel.Joint;
import reve.core.urdf.RobotModel.JointType;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** Reader of the actuators of an MJCF file. They become actions of joints. */
final class MjcfActuators {
    private static final Set<String> READ =
            Set.of(
                    "name",
                    "class",
                    "joint",
                    "jointinparent",
                    "gear",
                    "ctrlrange",
                    "ctrllimited",
                    "forcerange",
                    "forcelimited",
                    "kp",
                    "kv",
                    "inheritrange",
                    "gaintype",
                    "gainprm",
                    "biastype",
                    "biasprm",
                    "dyntype",
                    "group");

    private final MjcfDefaults defaults;
    private final MjcfCompiler compiler;
    private final Ignored ignored;

    /** The force of an actuator: gain * control - stiffness * length - damping * speed. */
    private record Force(double gain, double stiffness, double damping) {}

    MjcfActuators(MjcfDefaults defaults, MjcfCompiler compiler, Ignored ignored) {
        this.defaults = defaults;
        this.compiler = compiler;
        this.ignored = ignored;
    }

    /** Adds a drive to a joint for each actuator. */
    void read(List<XmlElement> sections, Map<String, Joint> joints) throws RobotFileException {
        for (XmlElement section : sections) {
            for (XmlElement element : section.children()) {
                if (!MjcfDefaults.ACTUATORS.contains(element.name())) {
                    ignored.add("<actuator> <" + element.name() + ">");
                    continue;
                }
                read(defaults.resolve(element, ""), joints);
            }
        }
    }

    private void read(XmlElement element, Map<String, Joint> joints) throws RobotFileException {
        Optional<String> on = element.find("joint").or(() -> element.find("jointinparent"));
        if (on.isEmpty()) {
            ignored.add("<" + element.name() + "> of the actuators, which moves no joint");
            return;
        }
        Joint joint = joints.get(on.get());
        if (joint == null) {
            throw element.problem("there is no joint " + on.get());
        }
        Optional<Force> force = force(element);
        boolean moves = joint.type() == JointType.CONTINUOUS || joint.type() == JointType.PRISMATIC;
        if (force.isEmpty() || !moves) {
            ignored.add(
                    "<"
                            + element.name()
                            + "> of the actuators"
                            + (moves ? "" : ", on a joint that is no hinge and no slide"));
            return;
        }
        ignored.attributes(element, READ);
        Drive drive = drive(element, force.get(), joint);
        List<Drive> drives = new ArrayList<>(joint.drives());
        drives.add(drive);
        joints.put(
                joint.name(),
                new Joint(
                        joint.name(),
                        joint.place(),
                        joint.type(),
                        joint.parent(),
                        joint.child(),
                        joint.pose(),
                        joint.anchor(),
                        joint.axis(),
                        joint.limits(),
                        Math.max(joint.effort(), drive.most()),
                        joint.loads(),
                        drives));
    }

    private static Optional<Force> force(XmlElement element) throws RobotFileException {
        switch (element.name()) {
            case "motor":
                return Optional.of(new Force(1, 0, 0));
            case "velocity":
                double kv = element.number("kv", 1);
                return Optional.of(new Force(kv, 0, kv));
            case "position":
                double kp = element.number("kp", 1);
                return Optional.of(new Force(kp, kp, element.number("kv", 0)));
            case "general":
                double[] gain =
                        element.find("gainprm").isPresent()
                                ? element.list("gainprm", 1, 100)
                                : new double[] {1};
                double[] bias = new double[3];
                if (element.find("biasprm").isPresent()) {
                    double[] given = element.list("biasprm", 1, 100);
                    System.arraycopy(given, 0, bias, 0, Math.min(3, given.length));
                }
                boolean isAffine = element.find("biastype").orElse("none").equals("affine");
                boolean isLinear =
                        element.find("gaintype").orElse("fixed").equals("fixed")
                                && (isAffine
                                        || element.find("biastype").orElse("none").equals("none"))
                                && element.find("dyntype").orElse("none").equals("none");
                if (!isLinear || gain[0] == 0) {
                    return Optional.empty();
                }
                Force force =
                        isAffine
                                ? new Force(gain[0], -bias[1], -bias[2])
                                : new Force(gain[0], 0, 0);
                boolean isServo = isAffine && bias[0] == 0 && isServo(force);
                return isAffine && !isServo ? Optional.empty() : Optional.of(force);
            default:
                return Optional.empty();
        }
    }

    /**
     * Returns whether the control of an actuator is the length or the speed at which the force is
     * 0. Also returns true if the force depends only on the control.
     */
    private static boolean isServo(Force force) {
        return force.stiffness == force.gain
                || force.stiffness == 0 && force.damping == force.gain
                || force.stiffness == 0 && force.damping == 0;
    }

    private Drive drive(XmlElement element, Force force, Joint joint) throws RobotFileException {
        String name = element.find("name").orElse(element.name());
        double gear = element.find("gear").isPresent() ? element.list("gear", 1, 6)[0] : 1;
        if (gear == 0) {
            throw element.problem("the gear is 0, expected another factor");
        }
        Optional<double[]> control = compiler.range(element, "ctrlrange", "ctrllimited");
        double[] loads =
                compiler.range(element, "forcerange", "forcelimited")
                        .map(range -> scaled(range, gear))
                        .orElse(endless());
        if (force.stiffness == 0 && force.damping == 0) {
            double[] range = control.map(each -> scaled(each, gear * force.gain)).orElse(endless());
            range[0] = Math.max(range[0], loads[0]);
            range[1] = Math.min(range[1], loads[1]);
            double most = Math.max(Math.abs(range[0]), Math.abs(range[1]));
            return new Drive(DriveKind.LOAD, range, Double.isFinite(most) ? most : 0, 0, 0, name);
        }
        double most = Math.max(Math.abs(loads[0]), Math.abs(loads[1]));
        double[] range = control.map(each -> scaled(each, 1 / gear)).orElse(endless());
        if (force.stiffness == 0) {
            return new Drive(
                    DriveKind.SPEED,
                    range,
                    Double.isFinite(most) ? most : 0,
                    0,
                    gear * gear * force.damping,
                    name);
        }
        double inherit = element.number("inheritrange", 0);
        if (inherit > 0 && joint.limits().isPresent()) {
            double[] limits = joint.limits().get();
            double middle = 0.5 * (limits[0] + limits[1]);
            double half = 0.5 * inherit * (limits[1] - limits[0]);
            range = new double[] {middle - half, middle + half};
        }
        return new Drive(
                DriveKind.PLACE,
                range,
                Double.isFinite(most) ? most : 0,
                gear * gear * force.stiffness,
                gear * gear * force.damping,
                name);
    }

    private static double[] endless() {
        return new double[] {Double.NEGATIVE_INFINITY, Double.POSITIVE_INFINITY};
    }

    private static double[] scaled(double[] range, double factor) {
        double one = factor * range[0];
        double other = factor * range[1];
        return new double[] {Math.min(one, other), Math.max(one, other)};
    }
}
