// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.disk.NewFolder;
import reve.core.file.WorldFile;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.SortedMap;
import java.util.TreeMap;

/**
 * Import of a robot model: the files of a world that contains the robot.
 *
 * @param name name of the robot
 * @param files texts by name: {@code world.yaml}, {@code robot.yaml} with the items of the robot,
 *     and the meshes
 * @param bodies number of rigid bodies
 * @param joints number of joints between the bodies
 * @param notes one line for each difference between the world and the file, for example an ignored
 *     element
 */
public record RobotImport(
        String name, SortedMap<String, String> files, int bodies, int joints, List<String> notes) {
    private static final String ROBOT = "robot.yaml";
    private static final long MAX_BYTES = 16L << 20;

    /** Distance between the lowest shape of a free robot and the ground [m]. */
    private static final double GAP = 1e-3;

    /** Frames per second of the imported world. */
    private static final int RATE = 60;

    /** Minimum number of physics steps per frame. The next constant is the maximum. */
    private static final int LEAST_STEPS = 16;

    private static final int MOST_STEPS = 1000;

    /** The modes that determine whether the root link of the robot moves. */
    public enum Base {
        /** Mode in which the root moves if it has a mass and is not named {@code world}. */
        AUTOMATIC,
        /** Mode in which the root does not move. */
        FIXED,
        /** Mode in which the root moves if it has a mass. */
        FREE
    }

    /**
     * Options of an import.
     *
     * @param base whether the root link of the robot moves
     * @param zUp true if +Z is up in the file; false if +Y is up
     * @param selfCollision whether parts of the robot collide with each other; for MJCF files,
     *     {@code contype} and {@code conaffinity} decide instead
     * @param hold whether the motors hold the joints with their largest torque from the start
     * @param packages folders of packages by name, for {@code package://NAME/…}
     */
    public record Options(
            Base base,
            boolean zUp,
            boolean selfCollision,
            boolean hold,
            Map<String, Path> packages) {}

    /** Copies the collections. */
    public RobotImport {
        files = new TreeMap<>(files);
        notes = List.copyOf(notes);
    }

    /**
     * Reads a URDF or MJCF file and the files that it names.
     *
     * @throws RobotFileException if the file is not valid
     */
    public static RobotImport read(Path file, Options options)
            throws IOException, RobotFileException {
        if (Files.exists(file) && !Files.isRegularFile(file)) {
            throw new RobotFileException(file + ": expected a regular file");
        }
        if (Files.size(file) > MAX_BYTES) {
            throw new RobotFileException(file + ": the file is larger than 16 MiB");
        }
        XmlElement root = XmlElement.read(file.toString(), Files.readAllBytes(file));
        Path folder = file.toAbsolutePath().getParent();
        MeshFiles meshes =
                new MeshFiles(folder == null ? Path.of("/") : folder, options.packages());
        List<String> notes = new ArrayList<>();
        RobotModel model =
                root.name().equals("mujoco")
                        ? MjcfReader.read(
                                MjcfIncludes.expand(root, file.toAbsolutePath()),
                                meshes,
                                options.base(),
                                notes)
                        : UrdfReader.read(root);
        RobotWorld robot = new RobotWorld(model, meshes, options, notes);
        SortedMap<String, String> files = new TreeMap<>();
        files.put(ROBOT, robot.write());
        String name =
                model.name().replaceAll("[^A-Za-z0-9 ._-]", "_").replaceFirst("^[^A-Za-z0-9]+", "");
        if (name.isEmpty()) {
            name = "robot";
        }
        double ground = Double.isFinite(robot.lowest()) ? robot.lowest() - GAP : 0;
        files.put(
                WorldFile.NAME,
                model.scene().isPresent()
                        ? world(name, file, model.scene().get(), robot)
                        : world(
                                name,
                                file,
                                robot.isFixed() ? Math.min(ground, 0) : ground,
                                robot.rules()));
        files.putAll(meshes.texts()); // also those of the scenery in the world file
        return new RobotImport(name, files, robot.bodyCount(), robot.jointCount(), notes);
    }

    private static String world(String name, Path file, double ground, String rules) {
        return """
        reve: 1
        name: %s
        doc: A robot that was imported from %s.
        include: [%s]                   # the items of the robot, for other worlds, too

        frame: {rate: 60, steps: 16}    # 1/960 s per physics step
        laws: [gravity_field, rigid_contact]
        constants: {gravity: [0, -9.81, 0]}

        agents:
          body: {physical: {location: [0, 1, 0]}}   # who drives the joints

        %sitems:
          - name: ground
            physical: {shape: box, size: [20, 1, 20], location: [0, %s, 0], colour: "#dfe6e9"}
        """
                .formatted(
                        name,
                        file.getFileName().toString().replaceAll("[^A-Za-z0-9._-]", "_"),
                        ROBOT,
                        rules,
                        Double.toString(ground - 0.5));
    }

    /** Returns a world file with the gravity, the time step and the scenery of an MJCF file. */
    private static String world(String name, Path file, RobotModel.Scene scene, RobotWorld robot) {
        int steps = (int) Math.ceil(1 / (RATE * scene.step()) - 1e-9);
        steps = Math.clamp(steps, LEAST_STEPS, MOST_STEPS);
        return """
        reve: 1
        name: %s
        doc: A robot and its world that were imported from %s.
        include: [%s]                   # the items of the robot, for other worlds, too

        frame: {rate: %d, steps: %d}    # 1/%d s per physics step
        laws: [gravity_field, {name: rigid_contact, parameters: {%s}}]
        constants: {gravity: %s}

        agents:
          body: {physical: {location: [0, 1, 0]}}   # who drives the joints

        """
                        .formatted(
                                name,
                                file.getFileName().toString().replaceAll("[^A-Za-z0-9._-]", "_"),
                                ROBOT,
                                RATE,
                                steps,
                                RATE * steps,
                                parameters(scene.surface()),
                                Arrays.toString(robot.turned(scene.gravity())))
                + robot.rules()
                + robot.scenery();
    }

    /** Returns the parameters of the law for contacts with the scenery. */
    private static String parameters(RobotModel.Surface scenery) {
        String parameters = "friction: " + scenery.friction();
        if (scenery.spinning() > 0) {
            parameters += ", spinFriction: " + scenery.spinning();
        }
        if (scenery.rolling() > 0) {
            parameters += ", rollingFriction: " + scenery.rolling();
        }
        return parameters;
    }

    /** Writes the files into a new folder. */
    public void write(Path folder) throws IOException {
        try (var made = new NewFolder(folder)) {
            for (Map.Entry<String, String> file : files.entrySet()) {
                made.write(file.getKey(), file.getValue().getBytes(StandardCharsets.UTF_8));
            }
            made.finish();
        }
    }
}
