// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.pe.adapter.LawLibrary;
import reve.tests.Reve.Outcome;
import reve.worlds.server.History;
import reve.worlds.server.LawPath;
import reve.worlds.server.StoredRun;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.Collections;
import java.util.List;
import java.util.Optional;
import java.util.stream.Stream;
import java.util.zip.ZipFile;

/** Packs of recordings and stores, which are moved and run in an empty folder. */
@Tag("slow")
class PackedRecordingIT {
    @TempDir private Path folder;

    @Test
    void theWorldOfAnyFrameContinuesElsewhereToTheSameBits() throws Exception {
        Path log = recorded("world.yaml", "0.5");
        String end = replayed(log, 30).path("stateHash").asString();
        Path middle = packed(log, "middle.reve", "--at", "0.2");
        Path frame = packed(log, "frame.reve", "--frame", "12");
        Path last = packed(log, "last.reve");
        assertThat(middle).hasSameBinaryContentAs(frame);
        assertThat(names(middle)).containsExactly("expected.json", "models/body.obj", "world.yaml");
        assertThat(content(middle, "world.yaml"))
                .contains("age: 12", "law wind", "camera:", "bodies:", "physics.velocity[0] > 0.1");
        JsonNode expected = new JsonMapper().readTree(content(middle, "expected.json"));
        assertThat(expected.path("frames").asInt()).isEqualTo(18);
        assertThat(expected.path("seconds").asDouble()).isEqualTo(0.3);
        assertThat(expected.path("stateHash").asString()).isEqualTo(end);
        // Nothing follows the last frame.
        assertThat(names(last)).containsExactly("models/body.obj", "world.yaml");

        remove(folder.resolve("here"));
        Files.delete(log);
        assertThat(hash(elsewhere(middle), "0.3")).isEqualTo(end);
        assertThat(hash(elsewhere(last), "0")).isEqualTo(end);
    }

    @Test
    void thePackContainsWhatAgentsAndOperatorsChangedUntilItsFrame() throws Exception {
        Path world = windy("world.yaml");
        Path log = folder.resolve("served.log");
        Path store = folder.resolve("served.db");
        String hash;
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        world.toString(),
                        "--port",
                        "0",
                        "--json",
                        "--record",
                        log.toString(),
                        "--store",
                        store.toString())) {
            String port = server.port();
            for (List<String> change :
                    List.of(
                            List.of("change", "item=two", "physics.mass=5 kg"),
                            List.of("remove", "item=three"),
                            List.of("shut-down"))) {
                List<String> command =
                        Stream.of(List.of("control"), change, List.of("--port", port))
                                .flatMap(List::stream)
                                .toList();
                Outcome done = Reve.run(command.toArray(String[]::new));
                assertThat(done.code()).as(done.err()).isZero();
            }
            hash = server.events().await("end", any -> true).path("stateHash").asString();
            assertThat(server.exitCode()).isZero();
        }
        Path end = packed(log, "end.reve");
        assertThat(content(end, "world.yaml")).contains("mass: 5").doesNotContain("name: three");
        Path stored = packed(store, "store.reve");
        assertThat(content(stored, "world.yaml")).isEqualTo(content(end, "world.yaml"));

        Path begin = packed(log, "begin.reve", "--frame", "0");
        assertThat(content(begin, "world.yaml")).doesNotContain("mass: 5").contains("name: three");
        remove(folder.resolve("here"));
        assertThat(hash(elsewhere(end), "0")).isEqualTo(hash);
        // The expected results end before the first change, which the pack does not contain.
        Path moved = elsewhere(begin);
        JsonNode expected = new JsonMapper().readTree(content(moved, "expected.json"));
        assertThat(expected.path("frames").asInt()).isPositive();
        assertThat(hash(moved, expected.path("seconds").asString()))
                .isEqualTo(expected.path("stateHash").asString());
    }

    @Test
    void thePackBringsTheLawsOfTheRecording() throws Exception {
        Path world = windy("world.yaml");
        Path law = world.getParent().resolve("laws/libvesper_law_evil.so");
        compile(law);
        Files.writeString(
                world.getParent().resolve("laws/spin.py"),
                Document.read(Project.ROOT.resolve("docs/laws-in-python.md"))
                        .titled("spin.py")
                        .text());
        Files.writeString(
                world, Files.readString(world).replace("- wind\n", "- wind\n  - evil\n  - spin\n"));
        Path log = folder.resolve("run.log");
        Outcome run =
                Reve.run(
                        "run",
                        world.toString(),
                        "--seconds",
                        "0.2",
                        "--trust",
                        "--record",
                        log.toString());
        assertThat(run.code()).as(run.err()).isZero();
        byte[] bytes = Files.readAllBytes(law);
        remove(world.getParent().resolve("laws"));

        Path pack = folder.resolve("a.reve");
        Outcome refused = Reve.run("pack", log.toString(), "--out", pack.toString());
        assertThat(refused.code()).isEqualTo(4);
        assertThat(refused.err()).contains("'evil'", "--trust");
        assertThat(pack).doesNotExist();
        // The world file names laws that its folder no longer contains; the recording has them.
        Outcome made =
                Reve.run("pack", log.toString(), "--trust", "--frame", "6", "--out", "" + pack);
        assertThat(made.code()).as(made.err()).isZero();
        assertThat(made.out())
                .contains("windy at frame 6, ", "native code and Python, which needs --trust");
        assertThat(names(pack)).contains("laws/libvesper_law_evil.so", "laws/spin.py");
        try (ZipFile zip = new ZipFile(pack.toFile());
                InputStream in = zip.getInputStream(zip.getEntry("laws/libvesper_law_evil.so"))) {
            assertThat(in.readAllBytes()).isEqualTo(bytes);
        }

        String end = replayed(log, 12, "--trust").path("stateHash").asString();
        remove(folder.resolve("here"));
        Path moved = elsewhere(pack);
        Outcome untrusted = Reve.run("run", moved.toString(), "--seconds", "0.1");
        assertThat(untrusted.code()).isEqualTo(4);
        assertThat(hash(moved, "0.1", "--trust")).isEqualTo(end);
    }

    @Test
    void thePackSaysWhatItDoesNotContain() throws Exception {
        Path world = windy("other.yaml");
        Files.writeString(
                world,
                Files.readString(world).replace("- wind\n", "- wind\n  - surface_contact\n"));
        Path log = recordedRun(world, "0.2");
        Path pack = folder.resolve("a.reve");
        Outcome made = Reve.run("pack", log.toString(), "--frame", "6", "--out", pack.toString());
        assertThat(made.code()).as(made.err()).isZero();
        assertThat(made.err())
                .contains(
                        "contains no camera, agents and rules",
                        "name the world file with --world WORLD",
                        "the pack does not contain what surface_contact remembers of earlier steps"
                                + " (frictionStretch, frictionUse)");
        assertThat(names(pack)).containsExactly("models/body.obj", "world.yaml");
        assertThat(content(pack, "world.yaml")).doesNotContain("camera:", "rules:");

        // At the first frame, the law remembers nothing yet.
        Path begin = packed(log, "begin.reve", "--at", "0", "--world", world.toString());
        assertThat(content(begin, "world.yaml")).contains("camera:", "rules:");
        JsonNode expected = new JsonMapper().readTree(content(begin, "expected.json"));
        assertThat(expected.path("frames").asInt()).isEqualTo(12);
        assertThat(hash(elsewhere(begin), "0.2")).isEqualTo(expected.path("stateHash").asString());
    }

    /** The laws that ship now stand for another release, which has another newton_motion. */
    @Test
    void aLawOfAnotherReleaseIsNamedAndNotPacked() throws Exception {
        Path log = recorded("world.yaml", "0.1");
        Path recordedLaws = Project.ROOT.resolve("build/current/native/laws");
        Path ships = Files.createDirectory(folder.resolve("ships"));
        String file = "libvesper_law_newton_motion.so";
        Files.write(ships.resolve(file), new byte[] {1});
        LawPath now = new LawPath(ships, Optional.of(recordedLaws), Optional.empty(), false);
        try (History history = new History(StoredRun.open(log, now))) {
            assertThat(history.next()).isTrue();
            assertThat(history.otherVersions())
                    .extracting(LawLibrary::name)
                    .containsExactly("newton_motion");
            assertThat(history.ownLaws()).isEmpty();
        }
        Files.copy(
                recordedLaws.resolve(file),
                ships.resolve(file),
                StandardCopyOption.REPLACE_EXISTING);
        try (History history = new History(StoredRun.open(log, now))) {
            assertThat(history.next()).isTrue();
            assertThat(history.otherVersions()).isEmpty();
        }
    }

    @Test
    void theMeshesAreFoundInTheFolderOfTheNamedWorld() throws Exception {
        Path log = recorded("world.yaml", "0.1");
        Files.move(folder.resolve("here"), folder.resolve("there"));
        Outcome missing = Reve.run("pack", log.toString(), "--out", file("a.reve"));
        assertThat(missing.code()).isEqualTo(1);
        assertThat(missing.err()).contains("models/body.obj");
        Path pack = packed(log, "a.reve", "--world", file("there"));
        assertThat(names(pack)).containsExactly("models/body.obj", "world.yaml");
    }

    @Test
    void aFrameThatTheRecordingDoesNotHaveIsRefused() throws Exception {
        Path log = recorded("world.yaml", "0.1");
        refused(2, "ends at frame 6, 0.1 s after its first state", log, "--at", "7");
        refused(2, "ends at frame 6", log, "--frame", "7");
        refused(2, "--at is -1,", log, "--at", "-1");
        refused(2, "--frame is -1", log, "--frame", "-1");
        refused(2, "leave one of them out", log, "--frame", "1", "--at", "1");
        Path world = folder.resolve("here");
        refused(2, "are for a recording or a store", world, "--at", "1");
        Path another = Project.WORLDS.resolve("spring-orbit");
        refused(1, "the stored world is called windy", log, "--world", another.toString());
    }

    private void refused(int code, String message, Path source, String... options)
            throws Exception {
        Path pack = folder.resolve("refused.reve");
        Outcome made = Reve.run(command(source, pack, options));
        assertThat(made.code()).as(made.err()).isEqualTo(code);
        assertThat(made.err()).contains(message);
        assertThat(pack).doesNotExist();
    }

    private static String[] command(Path source, Path pack, String... options) {
        return Stream.concat(
                        Stream.of("pack", source.toString(), "--out", pack.toString()),
                        Stream.of(options))
                .toArray(String[]::new);
    }

    /** Makes a pack, which must succeed without a message. */
    private Path packed(Path source, String name, String... options) throws Exception {
        Path pack = folder.resolve(name);
        Outcome made = Reve.run(command(source, pack, options));
        assertThat(made.code()).as(made.err()).isZero();
        assertThat(made.messages()).isEmpty();
        return pack;
    }

    private Path recorded(String worldFile, String seconds) throws Exception {
        return recordedRun(windy(worldFile), seconds);
    }

    private Path recordedRun(Path world, String seconds) throws Exception {
        Path log = folder.resolve("run.log");
        Outcome run =
                Reve.run("run", world.toString(), "--seconds", seconds, "--record", log.toString());
        assertThat(run.code()).as(run.err()).isZero();
        return log;
    }

    private static JsonNode replayed(Path log, int frame, String... options) throws Exception {
        Outcome replay =
                Reve.run(
                        Stream.concat(
                                        Stream.of(
                                                "replay",
                                                log.toString(),
                                                "--json",
                                                "--until",
                                                Integer.toString(frame)),
                                        Stream.of(options))
                                .toArray(String[]::new));
        assertThat(replay.code()).as(replay.err()).isZero();
        JsonNode result = new JsonMapper().readTree(replay.out());
        assertThat(result.path("frame").asInt()).isEqualTo(frame);
        return result;
    }

    /** Moves a pack to an empty folder. */
    private Path elsewhere(Path pack) throws IOException {
        Path empty = Files.createTempDirectory(folder, "elsewhere");
        return Files.move(pack, empty.resolve("moved.reve"));
    }

    private static String hash(Path world, String seconds, String... options) throws Exception {
        Outcome run =
                Reve.run(
                        Stream.concat(
                                        Stream.of(
                                                "run",
                                                world.toString(),
                                                "--seconds",
                                                seconds,
                                                "--json"),
                                        Stream.of(options))
                                .toArray(String[]::new));
        assertThat(run.code()).as(run.err()).isZero();
        return new JsonMapper().readTree(run.out()).path("stateHash").asString();
    }

    private String file(String name) {
        return folder.resolve(name).toString();
    }

    private static List<String> names(Path pack) throws IOException {
        try (ZipFile zip = new ZipFile(pack.toFile())) {
            return Collections.list(zip.entries()).stream().map(each -> each.getName()).toList();
        }
    }

    private static String content(Path pack, String name) throws IOException {
        try (ZipFile zip = new ZipFile(pack.toFile());
                InputStream in = zip.getInputStream(zip.getEntry(name))) {
            return new String(in.readAllBytes(), StandardCharsets.UTF_8);
        }
    }

    private static void remove(Path all) throws IOException {
        try (Stream<Path> files = Files.walk(all)) {
            for (Path each : files.sorted(Collections.reverseOrder()).toList()) {
                Files.delete(each);
            }
        }
    }

    private static void compile(Path library) throws Exception {
        Path source = library.resolveSibling("evil_law.cpp");
        try (InputStream text = WorldTrustIT.class.getResourceAsStream("evil_law.cpp")) {
            Files.write(source, text.readAllBytes());
        }
        Process compiler =
                new ProcessBuilder(
                                "g++",
                                "-std=c++20",
                                "-shared",
                                "-fPIC",
                                "-O0",
                                "-fvisibility=hidden",
                                "-ffp-contract=off",
                                "-fno-gnu-unique",
                                "-DEVIL_MARK=\"/dev/null\"",
                                "-I" + Project.ROOT.resolve("vesper-native/include"),
                                source.toString(),
                                "-o",
                                library.toString())
                        .redirectErrorStream(true)
                        .start();
        String said = new String(compiler.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        assertThat(compiler.waitFor()).as(said).isZero();
        Files.delete(source);
    }

    /** Writes a world with a law as text, a rule, a camera, agents and a mesh. */
    private Path windy(String name) throws IOException {
        Path world = Files.createDirectory(folder.resolve("here"));
        for (String below : List.of("laws", "models")) {
            Files.createDirectory(world.resolve(below));
        }
        Files.writeString(world.resolve("models/body.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.writeString(
                world.resolve("laws/wind.law"),
                """
                law wind "Drag towards a uniform wind."
                  parameter c = 2 kg/s, from 0 to 1e6 kg/s
                  parameter w = (5, 0, 0) m/s
                  each body:
                    force += c (w - velocity)
                """);
        return Files.writeString(
                world.resolve(name),
                """
                reve: 1
                name: windy
                laws:
                  - wind
                  - newton_motion
                camera: {eye: [0, 2, 9], target: [0, 0, 0]}
                agents: {bodies: [two]}
                rules: {blown: "physics.velocity[0] > 0.1"}
                items:
                  - name: one
                    physical: {shape: mesh, file: models/body.obj}
                    physics: {mass: 1}
                  - {name: two, physical: {shape: sphere, radius: 0.1}, physics: {mass: 2}}
                  - {name: three, physics: {mass: 3}}
                """);
    }
}
