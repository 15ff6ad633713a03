// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.disk.NewFolder;
import reve.core.file.WorldFile;
import reve.worlds.Product;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.regex.Pattern;

/** The command {@code new}: creates a folder with a small, complete world or law. */
@Command(
        name = "new",
        description = "Makes a folder with a world or a law that runs, to be changed.")
public final class NewCommand {
    private static final Pattern NAME = Pattern.compile("[A-Za-z0-9][A-Za-z0-9 ._-]{0,63}");

    private static final String WORLD =
            """
            reve: 1
            name: %s
            doc: A ball falls onto a floor.

            frame: {rate: 60, steps: 10}    # 1/600 s per physics step
            laws:
              - gravity_field
              - {name: sphere_contact, parameters: {floorHeight: 0 m}}
              - newton_motion
            constants:
              gravity: [0, -9.81, 0]

            camera: {eye: [0, 1.5, 5], target: [0, 0.8, 0]}

            agents:
              body:                         # scenery: an agent's body disturbs nothing
                physical: {shape: box, size: [0.4, 0.4, 0.4], colour: "#f1c40f", location: [1.5, 0.2, 0]}

            items:
              - name: ball
                physical: {shape: sphere, radius: 30 cm, colour: "#c0392b", location: [0, 2, 0]}
                semantic: {class: toy}
                physics: {mass: 1 kg, radius: 30 cm}
                access:
                  push:
                    doc: Applies an impulse to the ball.
                    parameters: {impulse: {components: 3, unit: N*s}}
                    effects: [{impulse: $impulse}]

              - name: floor                 # what is drawn; the ball rests on floorHeight
                physical: {shape: plane, size: [6, 6], colour: "#dfe6e9"}
            """;

    @Spec private CommandSpec spec = CommandSpec.create();

    @Command(name = "world", description = "Makes a folder with a world file.")
    int world(@Parameters(paramLabel = "NAME", description = "The new folder.") Path folder)
            throws IOException {
        String name = folder.getFileName() == null ? "" : folder.getFileName().toString();
        if (!NAME.matcher(name).matches()) {
            throw new ParameterException(
                    spec.commandLine(),
                    "'"
                            + name
                            + "' is no name of a world; expected letters, digits, blanks, ., _ and"
                            + " -, beginning with a letter or digit");
        }
        if (Files.exists(folder)) {
            throw new IOException(folder + " is there already; nothing was written");
        }
        try (var made = new NewFolder(folder)) {
            made.write(WorldFile.NAME, WORLD.formatted(name).getBytes(StandardCharsets.UTF_8));
            made.finish();
        }
        String reve = Product.command();
        PrintWriter out = spec.commandLine().getOut();
        out.println(folder + ": written; look at it with");
        out.println(
                "  "
                        + reve
                        + " picture "
                        + quoted(folder)
                        + " --at 2 --out "
                        + quoted(folder.resolve("world.png")));
        out.println("  " + reve + " serve " + quoted(folder));
        out.flush();
        return ExitCode.OK;
    }

    @Command(
            name = "law",
            description = "Makes a folder with a law in C++, its build file and its test.")
    int law(@Parameters(paramLabel = "NAME", description = "The new folder.") Path folder)
            throws IOException, InterruptedException {
        Path parent = folder.toAbsolutePath().getParent();
        Process vesper =
                new ProcessBuilder(
                                Product.nativeFolder().resolve("vesper").toString(),
                                "new-law",
                                String.valueOf(folder.getFileName()),
                                "--dir",
                                String.valueOf(parent))
                        .inheritIO()
                        .start();
        return vesper.waitFor();
    }

    private static String quoted(Path path) {
        String text = path.toString();
        return text.matches("[A-Za-z0-9._/-]+") ? text : "'" + text.replace("'", "'\\''") + "'";
    }
}
