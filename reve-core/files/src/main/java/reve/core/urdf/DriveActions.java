// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.file.YamlWriter.Numeral;
import reve.core.urdf.RobotModel.Drive;
import reve.core.urdf.RobotModel.DriveKind;
import reve.core.urdf.RobotModel.Joint;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Actions that drive a joint by its motor. The law {@code rigid_contact} computes this motor. */
final class DriveActions {
    /**
     * Speed of a motor with a given torque or force [rad/s or m/s]. It is so high that the motor
     * never reaches it and exerts its full torque or force.
     */
    private static final double ENDLESS = 1e5;

    private DriveActions() {}

    /**
     * Returns the actions of a joint by their names. A joint has at most one action of each kind. A
     * note reports each further action, which is omitted.
     */
    static Map<String, Object> of(Joint joint, boolean slides, List<String> notes) {
        Map<String, Object> actions = new LinkedHashMap<>();
        boolean hasServo = hasServo(joint);
        boolean setsDamping = setsDamping(joint);
        for (Drive drive : joint.drives()) {
            String name =
                    switch (drive.kind()) {
                        case SPEED -> "drive";
                        case LOAD -> "push";
                        case PLACE -> "move";
                    };
            if (actions.containsKey(name)) {
                notes.add(
                        "actuator "
                                + drive.actuator()
                                + ": the joint "
                                + joint.name()
                                + " has the action "
                                + name
                                + " of another actuator");
                continue;
            }
            actions.put(name, action(drive, slides, hasServo, setsDamping));
        }
        return actions;
    }

    private static boolean hasServo(Joint joint) {
        return joint.drives().stream().anyMatch(drive -> drive.kind() == DriveKind.PLACE);
    }

    /** Returns whether the actions of a joint set the damping of its motor. */
    private static boolean setsDamping(Joint joint) {
        return hasServo(joint)
                ? joint.drives().stream().anyMatch(drive -> drive.damping() > 0)
                : joint.drives().stream().map(Drive::damping).distinct().count() > 1;
    }

    /**
     * Returns the drive of a joint that acts from the start: the first servo, or else the first
     * drive with damping.
     */
    private static Optional<Drive> first(Joint joint) {
        return joint.drives().stream()
                .filter(drive -> drive.kind() == DriveKind.PLACE)
                .findFirst()
                .or(() -> joint.drives().stream().filter(drive -> drive.damping() > 0).findFirst());
    }

    /**
     * Writes the drive that acts from the start, if there is one. Until the first act, a servo
     * holds the joint at the place 0, and any other drive brakes it. Also writes each property that
     * an action sets, because a world has only the properties that its items state.
     *
     * @return whether there is such a drive
     */
    static boolean putFirst(Joint joint, boolean slides, Map<String, Object> physics) {
        Optional<Drive> first = first(joint);
        first.ifPresent(drive -> put(drive, setsDamping(joint), slides, physics));
        return first.isPresent();
    }

    private static void put(
            Drive drive, boolean statesDamping, boolean slides, Map<String, Object> physics) {
        String motor = slides ? "drive" : "motor";
        physics.put(
                slides ? "driveForce" : "motorTorque",
                Numeral.of(drive.most() > 0 ? drive.most() : ENDLESS));
        if (drive.kind() == DriveKind.PLACE) {
            physics.put(motor + "Stiffness", Numeral.of(drive.stiffness()));
        }
        if (drive.damping() > 0 || statesDamping) {
            physics.put(motor + "Damping", Numeral.of(drive.damping()));
        }
        if (drive.kind() == DriveKind.PLACE) {
            physics.put(slides ? "driveTravel" : "motorAngle", Numeral.of(0));
        }
    }

    private static Map<String, Object> action(
            Drive drive, boolean slides, boolean hasServo, boolean setsDamping) {
        String load = slides ? "force" : "torque";
        String speedProperty = slides ? "driveSpeed" : "motorSpeed";
        String loadProperty = slides ? "driveForce" : "motorTorque";
        Map<String, Object> parameters = new LinkedHashMap<>();
        String doc;
        Object speed;
        String most = "$" + load;
        List<Object> effects = new ArrayList<>();
        switch (drive.kind()) {
            case SPEED -> {
                doc =
                        "Moves the joint at a speed, with at most a "
                                + load
                                + (drive.damping() > 0
                                        ? "; the speed 0 brakes it."
                                        : "; the speed 0 holds it.");
                parameters.put("speed", parameter(slides ? "m/s" : "rad/s", drive.range()));
                speed = "$speed";
            }
            case LOAD -> {
                doc = "Exerts a " + load + " on the joint until the next act.";
                speed = "$math.sign(" + load + ") * " + ENDLESS;
                most = "$math.abs(" + load + ")";
            }
            default -> {
                String place = slides ? "travel" : "angle";
                doc =
                        "Moves the joint to the "
                                + place
                                + ", with at most a "
                                + load
                                + ", and holds it there.";
                parameters.put(place, parameter(slides ? "m" : "rad", drive.range()));
                effects.add(set(slides ? "driveTravel" : "motorAngle", "$" + place));
                speed = Numeral.of(0);
            }
        }
        double bound = drive.most() > 0 ? drive.most() : Double.POSITIVE_INFINITY;
        double[] range = drive.kind() == DriveKind.LOAD ? drive.range() : new double[] {0, bound};
        parameters.put(load, parameter(slides ? "N" : "N*m", range));
        Map<String, Object> action = new LinkedHashMap<>();
        action.put(
                "doc",
                drive.actuator().isEmpty() ? doc : doc + " Actuator " + drive.actuator() + ".");
        action.put("parameters", parameters);
        effects.add(set(speedProperty, speed));
        effects.add(set(loadProperty, most));
        String motor = slides ? "drive" : "motor";
        if (hasServo) {
            // An act that sets another quantity switches the servo off. For this purpose it sets
            // the stiffness to 0.
            effects.add(set(motor + "Stiffness", Numeral.of(drive.stiffness())));
        }
        if (setsDamping) {
            effects.add(set(motor + "Damping", Numeral.of(drive.damping())));
        }
        action.put("effects", effects);
        return action;
    }

    private static Map<String, Object> parameter(String unit, double[] range) {
        Map<String, Object> parameter = new LinkedHashMap<>();
        parameter.put("unit", unit);
        if (Double.isFinite(range[0])) {
            parameter.put("min", Numeral.of(range[0]));
        }
        if (Double.isFinite(range[1])) {
            parameter.put("max", Numeral.of(range[1]));
        }
        return parameter;
    }

    private static Map<String, Object> set(String property, Object value) {
        Map<String, Object> effect = new LinkedHashMap<>();
        effect.put("set", "physics." + property);
        effect.put("to", value);
        return effect;
    }
}
