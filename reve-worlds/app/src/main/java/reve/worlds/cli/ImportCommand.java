// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.file.WorldFile;
import reve.core.urdf.RobotImport;
import reve.worlds.Product;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.concurrent.Callable;
import java.util.stream.Stream;

/** The command {@code import}: makes a world from a robot model. */
@Command(
        name = "import",
        description =
                "Makes the folder of a world from a robot model (URDF or MJCF) and its meshes.")
public final class ImportCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(paramLabel = "FILE", description = "A file of URDF or MJCF.")
    private Path file = Path.of("");

    @Option(
            names = "--out",
            paramLabel = "FOLDER",
            required = true,
            description = "The folder to make.")
    private Path out = Path.of("");

    @Option(
            names = "--base",
            paramLabel = "fixed|free|automatic",
            description =
                    "Whether the root of the robot moves (default: it does if it has a mass and is"
                            + " not named world; in MJCF, if it has a free joint).")
    private RobotImport.Base base = RobotImport.Base.AUTOMATIC;

    @Option(names = "--y-up", description = "+Y is up in the file (default: +Z).")
    private boolean yUp;

    @Option(
            names = "--self-collision",
            description = "Parts of the robot collide with each other (in MJCF, the file decides).")
    private boolean selfCollision;

    @Option(
            names = "--hold",
            description =
                    "The motors hold the joints with their largest torque from the start (default:"
                            + " the robot falls until an agent drives its joints).")
    private boolean hold;

    @Option(
            names = "--package",
            paramLabel = "NAME=FOLDER",
            description =
                    "The folder of a package that the file names as package://NAME/…; may be"
                            + " repeated (default: folders of this name around the file).")
    private Map<String, Path> packages = new LinkedHashMap<>();

    @Option(names = "--json", description = "Print the result as JSON.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        requireNew();
        RobotImport robot =
                RobotImport.read(
                        file, new RobotImport.Options(base, !yUp, selfCollision, hold, packages));
        robot.write(out);
        Path world = out.resolve(WorldFile.NAME);
        new WorldArgument(world).load(spec.commandLine().getErr());
        if (json) {
            Map<String, Object> result = new LinkedHashMap<>();
            result.put("world", world.toString());
            result.put("name", robot.name());
            result.put("bodies", robot.bodies());
            result.put("joints", robot.joints());
            result.put("files", robot.files().keySet());
            result.put("notes", robot.notes());
            Json.print(spec, result);
            return ExitCode.OK;
        }
        PrintWriter print = spec.commandLine().getOut();
        print.printf(
                "%s: %s, %d bodies, %d joints, %d meshes%n",
                world,
                robot.name(),
                robot.bodies(),
                robot.joints(),
                robot.files().keySet().stream().filter(name -> name.endsWith(".obj")).count());
        robot.notes().forEach(note -> print.println("  " + note));
        print.println("look at it with");
        print.println("  " + Product.command() + " picture " + out + " --out robot.png");
        print.println("  " + Product.command() + " serve " + out + " --web 0");
        print.flush();
        return ExitCode.OK;
    }

    private void requireNew() throws IOException {
        if (!Files.exists(out)) {
            return;
        }
        try (Stream<Path> there = Files.isDirectory(out) ? Files.list(out) : Stream.of(out)) {
            if (there.findAny().isPresent()) {
                throw new ParameterException(
                        spec.commandLine(),
                        "--out " + out + " is there already and is not an empty folder");
            }
        }
    }
}
