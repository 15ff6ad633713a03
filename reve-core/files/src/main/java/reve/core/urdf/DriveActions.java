// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.file.YamlWriter.Numeral;
import reve.core.urdf.RobotModel.Drive;
import reve.core.urdf.RobotModel.DriveKind;
import reve.core.urdf.RobotModel.Joint;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/** Actions that drive a joint by the motor that the law {@code rigid_contact} gives it. */
final class DriveActions {
    /** Speed that a motor with a given torque or force never reaches [rad/s or m/s]. */
    private static final double ENDLESS = 1e5;

    private DriveActions() {}

    /** Returns the actions of a joint by their names, one of each kind. */
    static Map<String, Object> of(Joint joint, boolean slides, List<String> notes) {
        Map<String, Object> actions = new LinkedHashMap<>();
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
            actions.put(name, action(drive, slides));
        }
        return actions;
    }

    private static Map<String, Object> action(Drive drive, boolean slides) {
        String load = slides ? "force" : "torque";
        String speedProperty = slides ? "driveSpeed" : "motorSpeed";
        String loadProperty = slides ? "driveForce" : "motorTorque";
        Map<String, Object> parameters = new LinkedHashMap<>();
        String doc;
        String speed;
        String most;
        switch (drive.kind()) {
            case SPEED -> {
                doc =
                        "Moves the joint at a speed, with at most a "
                                + load
                                + "; the speed 0 holds it.";
                parameters.put("speed", parameter(slides ? "m/s" : "rad/s", drive.range()));
                speed = "$speed";
                most = "$" + load;
            }
            case LOAD -> {
                doc = "Exerts a " + load + " on the joint until the next act.";
                speed = "$math.sign(" + load + ") * " + ENDLESS;
                most = "$math.abs(" + load + ")";
            }
            default -> {
                String place = slides ? "travel" : "angle";
                doc =
                        "Moves the joint towards the "
                                + place
                                + ", with at most a "
                                + load
                                + "; repeat it in each frame.";
                parameters.put(place, parameter(slides ? "m" : "rad", drive.range()));
                String state = slides ? "physics.jointTravel" : "physics.jointAngle";
                speed = "$(" + place + " - " + state + ") * " + drive.rate();
                most = "$" + load;
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
        action.put("effects", List.of(set(speedProperty, speed), set(loadProperty, most)));
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

    private static Map<String, Object> set(String property, String value) {
        Map<String, Object> effect = new LinkedHashMap<>();
        effect.put("set", "physics." + property);
        effect.put("to", value);
        return effect;
    }
}
