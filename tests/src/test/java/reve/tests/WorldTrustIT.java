// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;
import reve.worlds.check.WorldCheck;
import reve.worlds.cli.Main;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.InputStream;
import java.io.PrintStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.util.ArrayList;
import java.util.List;

/**
 * Native code that comes with a world, a store or a recording. The library is real. It leaves a
 * mark when it is opened, even in the probe process.
 */
@Tag("slow")
class WorldTrustIT {
    private static final String FILE = "libvesper_law_evil.so";
    private static final String NOT_OPENED =
            "law 'evil' comes with the world, in laws/"
                    + FILE
                    + ": native code, which runs with all of your rights and is opened only with"
                    + " --trust, or in a sandbox with --apart";

    @TempDir private static Path shared;
    private static Path evil = Path.of("");
    private static Path mark = Path.of("");

    @TempDir private Path folder;

    @BeforeAll
    static void compile() throws Exception {
        mark = shared.resolve("mark");
        evil = compile(FILE);
    }

    private static Path compile(String name, String... options) throws Exception {
        Path file = shared.resolve(name);
        Path source = shared.resolve("evil_law.cpp");
        try (InputStream text = WorldTrustIT.class.getResourceAsStream("evil_law.cpp")) {
            Files.write(source, text.readAllBytes());
        }
        List<String> command =
                new ArrayList<>(
                        List.of(
                                "g++",
                                "-std=c++20",
                                "-shared",
                                "-fPIC",
                                "-O0",
                                "-fvisibility=hidden",
                                "-ffp-contract=off",
                                "-fno-gnu-unique",
                                "-DEVIL_MARK=\"" + mark + "\"",
                                "-I" + Project.ROOT.resolve("vesper-native/include"),
                                source.toString(),
                                "-o",
                                file.toString()));
        command.addAll(List.of(options));
        Process compiler = new ProcessBuilder(command).redirectErrorStream(true).start();
        String said = new String(compiler.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        assertThat(compiler.waitFor()).as(said).isZero();
        return file;
    }

    @BeforeEach
    void eraseMark() throws IOException {
        Files.deleteIfExists(mark);
    }

    private String world(String laws) throws IOException {
        return Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: visited
                        laws: %s
                        items:
                          - {name: one, physics: {mass: 1}}
                        """
                                .formatted(laws))
                .toString();
    }

    private Path ownLaws() throws IOException {
        return Files.createDirectories(folder.resolve("laws"));
    }

    private void assertNeverOpened() {
        assertThat(mark).as("what the library's constructor writes").doesNotExist();
    }

    /** Runs a command line in this process, without a start of a JVM. */
    private static Outcome reve(String... arguments) {
        PrintStream out = System.out;
        PrintStream err = System.err;
        var said = new ByteArrayOutputStream();
        var complained = new ByteArrayOutputStream();
        try {
            System.setOut(new PrintStream(said, true, StandardCharsets.UTF_8));
            System.setErr(new PrintStream(complained, true, StandardCharsets.UTF_8));
            int code = Main.run(arguments);
            return new Outcome(
                    code,
                    said.toString(StandardCharsets.UTF_8),
                    complained.toString(StandardCharsets.UTF_8));
        } finally {
            System.setOut(out);
            System.setErr(err);
        }
    }

    private static Outcome reve(List<String> command, String... more) {
        List<String> all = new ArrayList<>(command);
        all.addAll(List.of(more));
        return reve(all.toArray(String[]::new));
    }

    @Test
    void aWorldNamesLawsNeverPaths() throws Exception {
        Files.copy(evil, folder.resolve("evil.so"));
        Path beside = Files.createDirectory(folder.resolve("x")).resolve(FILE);
        Files.copy(evil, beside);
        String world =
                world("[./evil.so, x/" + FILE + ", " + beside + ", {name: ../x/" + FILE + "}]");
        for (List<String> command :
                List.of(List.of("check", world), List.of("run", world, "--trust"))) {
            Outcome outcome = reve(command);
            assertThat(outcome.code()).isEqualTo(3);
            assertThat(outcome.err())
                    .contains(
                            ":3:8: laws[0]: found text `./evil.so`",
                            ":3:19: laws[1]: found text `x/" + FILE,
                            ":3:44: laws[2]: found text `/",
                            ": name: found text `../x/",
                            "expected the name of a law: letters, digits, `_` and `-`, never a"
                                    + " path");
        }
        assertNeverOpened();
    }

    @Test
    void checkSaysWhatItDidNotOpen() throws Exception {
        Files.copy(evil, ownLaws().resolve(FILE));
        String world = world("[newton_motion, evil]");
        Outcome outcome = reve("check", world);
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(outcome.err())
                .endsWith(
                        world
                                + ":3:23: not checked: "
                                + NOT_OPENED
                                + "\n"
                                + WorldCheck.leftOut()
                                + "\n");
        assertThat(outcome.out()).contains("valid, 1 items, 1 laws, not checked: 1 more");
        JsonNode json = new JsonMapper().readTree(reve("check", world, "--json").out());
        assertThat(json.at("/unchecked/0").asString()).contains(NOT_OPENED);
        assertNeverOpened();
        Outcome trusted = reve("check", world, "--trust");
        assertThat(trusted.out()).contains("valid, 1 items, 2 laws\n");
        assertThat(mark).as("what this library does when it is opened").exists();
    }

    @Test
    void lawsThatComeWithAWorldAreOpenedOnlyWithTrust() throws Exception {
        Files.copy(evil, ownLaws().resolve(FILE));
        String world = world("[newton_motion, evil]");
        String picture = folder.resolve("p.png").toString();
        for (List<String> command :
                List.of(
                        List.of("run", world),
                        List.of("picture", world, "--out", picture),
                        List.of("serve", world, "--port", "0", "--seconds", "0.1", "--fast"))) {
            Outcome outcome = reve(command);
            assertThat(outcome.code()).as(outcome.out()).isEqualTo(4);
            assertThat(outcome.err()).contains(world + ":3:23: " + NOT_OPENED);
        }
        assertNeverOpened();
        assertThat(reve("run", world, "--seconds", "0.1", "--trust").code()).isZero();
        assertThat(mark).exists();
    }

    @Test
    void linksOutOfTheWorldsLawsAreRefused() throws Exception {
        Files.createSymbolicLink(ownLaws().resolve(FILE), evil);
        String world = world("[newton_motion, evil]");
        Outcome file = reve("run", world, "--trust");
        assertThat(file.code()).isEqualTo(4);
        assertThat(file.err()).contains("laws/" + FILE + ": a link that leads out of the world's");
        Files.delete(folder.resolve("laws").resolve(FILE));
        Files.delete(folder.resolve("laws"));
        Path other = Files.createDirectory(folder.resolve("other"));
        Files.copy(evil, other.resolve(FILE));
        Files.createSymbolicLink(folder.resolve("laws"), other);
        Outcome whole = reve("check", world, "--trust");
        assertThat(whole.code()).isEqualTo(4);
        assertThat(whole.err()).contains("laws/" + FILE + ": a link that leads out of the world's");
        assertNeverOpened();
    }

    @Test
    void aLawOfAWorldNeverReplacesAShippedOne() throws Exception {
        Path own = ownLaws().resolve("libvesper_law_newton_motion.so");
        Files.copy(evil, own);
        Outcome outcome =
                Reve.runAsProcess(
                        "run", world("[newton_motion]"), "--seconds", "0.1", "--trust", "--json");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(new JsonMapper().readTree(outcome.out()).get("laws").toString())
                .contains("newton_motion")
                .doesNotContain("evil");
        assertThat(outcome.err())
                .contains(
                        own.toRealPath()
                                + " is not used: the law of that name "
                                + "that ships comes first");
        assertNeverOpened();
    }

    /**
     * A library may use such a name neither for itself nor for a law in it. Shipped libraries and
     * their copies keep their names.
     */
    @Test
    void aTrustedLibraryMayNotCallItselfLikeAShippedLaw() throws Exception {
        Path library = compile("library.so", "-DEVIL_LIBRARY=\"gravity_field\"");
        Path law = compile("law.so", "-DEVIL_LAW=\"gravity_field\"");
        Path operators = Files.createDirectory(folder.resolve("operators"));
        Path ships = Project.NATIVE.resolve("laws/libvesper_law_gravity_field.so");
        String world = world("[newton_motion, evil]");
        for (Path impostor : List.of(library, law)) {
            Path own = ownLaws().resolve(FILE);
            Files.copy(impostor, own, StandardCopyOption.REPLACE_EXISTING);
            Outcome trusted = reve("check", world, "--trust");
            assertThat(trusted.code()).as(trusted.out()).isEqualTo(4);
            assertThat(trusted.err())
                    .contains(
                            world + ":3:23: ",
                            own.toRealPath()
                                    + " calls "
                                    + "itself 'gravity_field', which is the law that ships as ",
                            ships.toString());
            Files.copy(impostor, operators.resolve(FILE), StandardCopyOption.REPLACE_EXISTING);
            Outcome found = reve("check", world, "--laws", operators.toString());
            assertThat(found.code()).as(found.out()).isEqualTo(4);
            assertThat(found.err()).contains(operators.resolve(FILE) + " calls itself ");
            Outcome dropped =
                    reve(
                            "serve",
                            world("[newton_motion]"),
                            "--port",
                            "0",
                            "--seconds",
                            "3",
                            "--laws",
                            operators.toString(),
                            "--json");
            assertThat(dropped.out())
                    .contains("\"fault\"", " calls itself 'gravity_field'")
                    .doesNotContain("\"laws\":\"gravity_field\"");
            world = world("[newton_motion, evil]");
        }
        Files.copy(ships, operators.resolve(FILE), StandardCopyOption.REPLACE_EXISTING);
        assertThat(reve("check", world, "--laws", operators.toString()).code()).isZero();
    }

    @Test
    void aMistypedLawsFolderIsAnErrorOfEachCommand() throws Exception {
        String world = world("[newton_motion]");
        Path none = folder.resolve("lwas");
        for (List<String> command :
                List.of(
                        List.of("check", world),
                        List.of("run", world),
                        List.of("picture", world, "--out", folder.resolve("p.png").toString()),
                        List.of("serve", world, "--port", "0", "--seconds", "0.1"),
                        List.of("replay", folder.resolve("r.log").toString()))) {
            Outcome outcome = reve(command, "--laws", none.toString());
            assertThat(outcome.code()).as(command.toString()).isEqualTo(2);
            assertThat(outcome.err()).contains("--laws: laws folder " + none + " is not a folder");
            assertThat(none).doesNotExist();
        }
    }

    @Test
    void aRecordingWithNativeCodeOfItsOwnIsReplayedOnlyWithTrust() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("operators"));
        Files.copy(evil, laws.resolve(FILE));
        String log = folder.resolve("r.log").toString();
        Outcome run =
                reve(
                        "run",
                        world("[newton_motion, evil]"),
                        "--seconds",
                        "0.1",
                        "--laws",
                        laws.toString(),
                        "--record",
                        log);
        assertThat(run.code()).as(run.err()).isZero();
        Files.delete(mark);
        Outcome refused = reve("replay", log);
        assertThat(refused.code()).isEqualTo(4);
        assertThat(refused.err())
                .startsWith("reve: " + log + ": the law library 'evil' (SHA-256 ")
                .contains("is native code", "--trust");
        assertNeverOpened();
        assertThat(reve("replay", log, "--laws", laws.toString()).out())
                .startsWith("identical: 6 frames");
        assertThat(reve("replay", log, "--trust").out()).startsWith("identical: 6 frames");
    }

    @Test
    void aStoreWithNativeCodeOfItsOwnGoesOnOnlyWithTrustOrItsLaws() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("operators"));
        Files.copy(evil, laws.resolve(FILE));
        Path store = folder.resolve("w.db");
        List<String> serve =
                List.of(
                        "serve",
                        world("[newton_motion, evil]"),
                        "--port",
                        "0",
                        "--fast",
                        "--seconds",
                        "0.1",
                        "--store",
                        store.toString(),
                        "--json");
        Outcome begun = reve(serve, "--laws", laws.toString());
        assertThat(begun.code()).as(begun.out()).isZero();
        Files.delete(mark);
        Outcome refused = reve(serve);
        assertThat(refused.code()).isEqualTo(4);
        assertThat(refused.err()).contains(store + ": the law library 'evil' (SHA-256 ");
        assertNeverOpened();
        Outcome resumed = reve(serve, "--laws", laws.toString());
        assertThat(resumed.code()).as(resumed.err()).isZero();
        assertThat(resumed.out()).doesNotContain("\"fault\"");
        assertThat(reve(serve, "--trust").code()).isZero();
    }

    /** The upgrade in this test is the same release with other bytes in its laws. */
    @Test
    void aStoreGoesOnAfterAnUpgradeForTheAccountThatMadeIt() throws Exception {
        Path upgraded = Files.createDirectory(folder.resolve("native"));
        for (String file :
                List.of(
                        "libvesper.so.1",
                        "libvesper.so",
                        "vesper-host",
                        "vesper-sandbox",
                        "vesper-probe",
                        "libsqlitejdbc.so")) {
            Files.copy(Project.NATIVE.resolve(file), upgraded.resolve(file));
        }
        String library = "laws/libvesper_law_newton_motion.so";
        Files.createDirectory(upgraded.resolve("laws"));
        Files.copy(Project.NATIVE.resolve(library), upgraded.resolve(library));
        Files.write(upgraded.resolve(library), new byte[1], StandardOpenOption.APPEND);
        String store = folder.resolve("w.db").toString();
        String[] serve = {
            "serve",
            world("[newton_motion]"),
            "--port",
            "0",
            "--fast",
            "--seconds",
            "0.1",
            "--store",
            store
        };
        assertThat(serveAs("ada", Project.NATIVE, serve).code()).isZero();
        Outcome resumed = serveAs("ada", upgraded, serve);
        assertThat(resumed.code()).as(resumed.err()).isZero();
        Outcome elsewhere = serveAs("bob", upgraded, serve);
        assertThat(elsewhere.code()).isEqualTo(4);
        assertThat(elsewhere.err()).contains("the law library 'newton_motion' (SHA-256 ");
    }

    private Outcome serveAs(String account, Path natives, String... arguments) throws Exception {
        List<String> command =
                new ArrayList<>(List.of("env", "XDG_STATE_HOME=" + folder.resolve(account)));
        command.addAll(Reve.commandIn(natives, arguments));
        return Reve.run(command);
    }
}
