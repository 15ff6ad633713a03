// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.core.world.ItemDefinition;
import reve.pe.PhysicsException;
import reve.tests.Reve.Outcome;
import reve.worlds.server.Simulation;

import java.awt.image.BufferedImage;
import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.net.URL;
import java.net.URLClassLoader;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.stream.Collectors;
import java.util.stream.Stream;

import javax.imageio.ImageIO;
import javax.tools.ToolProvider;

/** Short examples of the README and of pages about keeping, replaying and meshes, unchanged. */
class DocumentExamplesIT {
    private static final String PROGRAM =
            """
            import reve.worlds.journal.SimulationImage;
            import reve.worlds.server.Simulation;

            public class Program {
                public static void run(Simulation simulation) {
            %s
                }
            }
            """;

    /** Least number of worlds of the pages that need no other files. */
    private static final int WORLDS_OF_PAGES = 30;

    @TempDir private Path folder;

    private static String blocks(String page, String language) throws Exception {
        return Document.read(Project.ROOT.resolve("docs").resolve(page)).blocks().stream()
                .filter(block -> block.language().equals(language))
                .map(Document.Block::text)
                .collect(Collectors.joining());
    }

    @Test
    void aWorldGoesBackAndRunsAheadAsPersistenceSays() throws Exception {
        Path source = folder.resolve("Program.java");
        Files.writeString(source, PROGRAM.formatted(blocks("persistence.md", "java")));
        var problems = new ByteArrayOutputStream();
        int status =
                ToolProvider.getSystemJavaCompiler()
                        .run(
                                null,
                                null,
                                problems,
                                "-d",
                                folder.toString(),
                                "-cp",
                                System.getProperty("java.class.path"),
                                source.toString());
        assertThat(status).as(problems.toString(StandardCharsets.UTF_8)).isZero();
        WorldDescription description =
                WorldFile.load(Project.WORLDS.resolve("icosahedron/world.yaml"));
        try (var loader = new URLClassLoader(new URL[] {folder.toUri().toURL()});
                Simulation simulation = new Simulation(description, Pacing.FAST)) {
            simulation.loop().run(3);
            long before = simulation.physics().stateHash();
            loader.loadClass("Program").getMethod("run", Simulation.class).invoke(null, simulation);
            assertThat(simulation.physics().stateHash()).isEqualTo(before);
            assertThat(simulation.loop().frame()).isEqualTo(3 + 120 + 1);
        }
    }

    @Test
    void aRunIsRecordedAndReplayedAsReplaySays() throws Exception {
        List<String> lines = Files.readAllLines(Project.ROOT.resolve("docs/replay.md"));
        int first = lines.indexOf("```") + 1;
        List<String> example = lines.subList(first, first + 4);
        String log = folder.resolve("run.log").toString();

        Outcome serve =
                run(example.get(0), "run.log", log, "--fast", "--seconds", "60", "--port", "0");
        assertThat(serve.code()).as(serve.err()).isZero();
        Outcome replay = run(example.get(1), "run.log", log);

        assertThat(replay.code()).as(replay.err()).isZero();
        assertThat(replay.out().lines()).first().isEqualTo(example.get(2));
        assertThat(example.get(3)).startsWith("state hash: ");
        assertThat(replay.out().lines()).last().asString().startsWith("state hash: ");
    }

    /** Runs a command line of a page with more options. One of its files is at another place. */
    private static Outcome run(String line, String file, String place, String... more)
            throws Exception {
        assertThat(line).startsWith("$ ./reve ");
        List<String> command =
                new ArrayList<>(
                        List.of(
                                line.substring("$ ./reve ".length())
                                        .replace(file, place)
                                        .replace("worlds/", Project.WORLDS + "/")
                                        .split(" ")));
        command.addAll(List.of(more));
        return Reve.run(command.toArray(String[]::new));
    }

    @Test
    void anActionInJavaIsFoundInAJarAsActionsSays() throws Exception {
        Path source = Files.createDirectory(folder.resolve("example")).resolve("Levitate.java");
        Files.writeString(source, blocks("actions.md", "java"));
        Path services = Files.createDirectories(folder.resolve("META-INF/services"));
        Files.writeString(
                services.resolve("reve.core.access.ActionProvider"), "example.Levitate\n");
        Files.writeString(
                folder.resolve("lift.yaml"),
                """
                reve: 1
                name: lift
                items: [{name: stone, access: {lift: {java: example.levitate}}}]
                """);
        String bin = System.getProperty("java.home") + "/bin/";

        var shell = new Shell(folder);
        shell.run(
                bin
                        + "javac -proc:none -cp \"$REVE/build/stage/lib/reve-core-files.jar\" -d . "
                        + "example/Levitate.java\n"
                        + "mkdir jars\n"
                        + bin
                        + "jar --create --file jars/levitate.jar example META-INF\n"
                        + "! \"$REVE/reve\" check lift.yaml\n");

        assertThat(shell.run("\"$REVE/reve\" check lift.yaml --plugins jars"))
                .contains("valid, 1 items");
        assertThat(shell.run("REVE_CLASSPATH=jars/levitate.jar \"$REVE/reve\" check lift.yaml"))
                .contains("valid, 1 items");
    }

    @Test
    void aWorldWithAMeshATextureAndADensityIsReadAsMeshesSays() throws Exception {
        Path handle = Project.WORLDS.resolve("t-handle");
        Files.createDirectory(folder.resolve("models"));
        Files.copy(handle.resolve("handle.glb"), folder.resolve("models/duck.glb"));
        Files.copy(handle.resolve("crate.png"), folder.resolve("crate.png"));
        Files.createDirectory(folder.resolve("maps"));
        var hills = new BufferedImage(3, 3, BufferedImage.TYPE_USHORT_GRAY);
        hills.getRaster().setSample(1, 1, 0, 65_535);
        ImageIO.write(hills, "png", folder.resolve("maps/hills.png").toFile());
        Files.writeString(folder.resolve("maps/quay.txt"), "# a quay\n2 2 2\n0 0 0\n");
        Path world = folder.resolve("world.yaml");
        Files.writeString(world, "reve: 1\nname: meshes\n" + blocks("meshes.md", "yaml"));

        List<ItemDefinition> items = WorldFile.load(world).items();

        assertThat(items)
                .extracting(ItemDefinition::name)
                .containsExactly("duck", "hills", "quay", "crate");
        assertThat(items.get(1).shape().size(1)).as("-5 m to 40 m").isEqualTo(45);
        assertThat(items.get(2).shape().size(1)).isEqualTo(2);
        assertThat(items.get(3).physics("mass").orElseThrow()).containsExactly(700);
    }

    /** Returns the pages whose examples of worlds are complete. */
    private static List<Path> pages() throws IOException {
        List<Path> pages = new ArrayList<>(List.of(Project.ROOT.resolve("README.md")));
        for (Path folder : List.of(Path.of("docs"), Path.of("laws/rigid_contact"))) {
            try (Stream<Path> files = Files.list(Project.ROOT.resolve(folder))) {
                files.filter(file -> file.toString().endsWith(".md")).sorted().forEach(pages::add);
            }
        }
        return pages;
    }

    @Test
    void theCheckHasNoWarningsAboutTheWorldsOfThePages() throws Exception {
        int checked = 0;
        for (Path page : pages()) {
            for (Document.Block block : Document.read(page).blocks()) {
                boolean isWorld = block.text().lines().limit(2).anyMatch("reve: 1"::equals);
                Optional<List<Problem>> found = isWorld ? warnings(block) : Optional.empty();
                if (found.isPresent()) {
                    assertThat(found.get())
                            .as(page + "\n" + block.text())
                            .hasSize(block.text().contains("name: silent\n") ? 2 : 0);
                    checked++;
                }
            }
        }
        assertThat(checked).isGreaterThanOrEqualTo(WORLDS_OF_PAGES);
    }

    /** Returns the warnings about a world. Empty if it needs other files, or laws of its page. */
    private static Optional<List<Problem>> warnings(Document.Block block) {
        byte[] text = block.text().getBytes(StandardCharsets.UTF_8);
        try (Simulation simulation = new Simulation(WorldFile.parse("w", text), Pacing.FAST)) {
            return Optional.of(simulation.warnings(true));
        } catch (WorldFileException | PhysicsException _) {
            return Optional.empty();
        }
    }

    @Test
    void theCheckHasNoWarningsAboutTheSampleWorlds() throws Exception {
        for (WorldsIT.Sample sample : WorldsIT.samples()) {
            try (Simulation simulation = sample.load()) {
                assertThat(simulation.warnings(true)).as(sample.toString()).isEmpty();
            }
        }
    }

    @Test
    void theClothOfThePageOfWorldFilesHangsTogether() throws Exception {
        String cloth =
                Document.read(Project.ROOT.resolve("docs/world-file.md")).blocks().stream()
                        .map(Document.Block::text)
                        .filter(text -> text.contains("name: cloth\n"))
                        .findFirst()
                        .orElseThrow();
        WorldDescription world =
                WorldFile.parse("cloth.yaml", cloth.getBytes(StandardCharsets.UTF_8));
        try (Simulation simulation = new Simulation(world, Pacing.FAST)) {
            simulation.loop().run(600);
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    @Test
    void theWorldOfTheReadmeRuns() throws Exception {
        Path world = folder.resolve("orbit.yaml");
        Files.writeString(world, blocks("../README.md", "yaml"));

        Outcome run = Reve.run("run", world.toString(), "--seconds", "1");

        assertThat(run.code()).as(run.err()).isZero();
        assertThat(run.out()).contains("orbit: 60 frames");
    }

    @Test
    void theLawOfTheReadmePassesTheChecksOfLaws() throws Exception {
        Files.writeString(folder.resolve("syrup.cpp"), blocks("../README.md", "cpp"));
        var shell = new Shell(folder);
        shell.run(
                "c++ -std=c++20 -O2 -shared -fPIC -fvisibility=hidden -ffp-contract=off"
                        + " -fno-gnu-unique -I \"$REVE/vesper-native/include\" syrup.cpp"
                        + " -o libvesper_law_syrup.so\n");

        assertThat(shell.run("\"$REVE/build/native/vesper\" test libvesper_law_syrup.so\n"))
                .contains(" 0 failed");
    }
}
