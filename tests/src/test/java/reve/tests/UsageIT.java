// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import static java.nio.file.StandardCopyOption.COPY_ATTRIBUTES;
import static java.util.stream.Collectors.joining;
import static java.util.stream.Collectors.toSet;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.Join;
import reve.tests.Reve.Outcome;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.concurrent.TimeUnit;
import java.util.stream.Stream;

/** Mistakes of operators, and the messages about them. */
@Tag("slow")
class UsageIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();

    @TempDir private Path folder;

    private static void refused(String message, String... arguments) throws Exception {
        Outcome outcome = Reve.run(arguments);
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(2);
        assertThat(outcome.err()).contains(message);
    }

    /** Libraries of the command line may read arguments from such a file. */
    @Test
    void anArgumentThatBeginsWithAnAtSignIsNoFileOfArguments() throws Exception {
        Path arguments = Files.writeString(folder.resolve("cool"), "--help\n");
        Outcome outcome = Reve.run("check", "@" + arguments);
        assertThat(outcome.code()).as(outcome.out()).isNotZero();
        assertThat(outcome.out()).isEmpty();
        assertThat(outcome.err()).contains("@" + arguments);
    }

    /** Listing a pipe of that name would wait for a writer. */
    @Test
    void aPipeInPlaceOfAWorldsFolderOfLawsIsNotOpened() throws Exception {
        Files.writeString(
                folder.resolve("world.yaml"), "reve: 1\nname: piped\nlaws: [wicked]\nitems: []\n");
        Path pipe = folder.resolve("laws");
        assertThat(new ProcessBuilder("mkfifo", pipe.toString()).start().waitFor()).isZero();
        Outcome outcome = Reve.run("check", folder.toString());
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(4);
        assertThat(outcome.err()).contains("wicked");
    }

    @Test
    void aFileOfAnEditThatIsNoYamlIsRefusedInOneLine() throws Exception {
        for (String text : List.of("name: " + "[".repeat(50_000), "name: [a,\nb: c}\n")) {
            Path file = Files.writeString(folder.resolve("edit.yaml"), text);
            Outcome outcome = Reve.run("control", "add", file.toString(), "--port", "1");
            assertThat(outcome.code()).as(outcome.err()).isEqualTo(1);
            assertThat(outcome.err())
                    .startsWith("reve: " + file)
                    .doesNotContain("\\u{a}")
                    .hasLineCount(1);
        }
    }

    @ParameterizedTest
    @ValueSource(strings = {"--store", "--record", "--laws", "--audit"})
    void anEmptyFileNameIsRefused(String option) throws Exception {
        refused(
                "'" + option + "': expected a file or a folder, found nothing",
                "serve",
                WORLD,
                option,
                "");
    }

    @Test
    void anOptionWithoutTheOneThatItBelongsToIsRefused() throws Exception {
        refused(
                "--store-every takes --store FILE; found none",
                "serve",
                WORLD,
                "--store-every",
                "2");
        refused(
                "--durability takes --store FILE; found none",
                "serve",
                WORLD,
                "--durability",
                "full");
        refused("--audit-size takes --audit FILE; found none", "serve", WORLD, "--audit-size", "2");
        refused("--audit-keep is 0, expected 1 or more", "serve", WORLD, "--audit-keep", "0");
        refused(
                "--record-keep takes --record FILE; found none",
                "run",
                WORLD,
                "--record-keep",
                "2");
    }

    @Test
    void aFolderThatCannotBeMadeIsNamedWithTheReason() throws Exception {
        Outcome outcome = Reve.run("serve", WORLD, "--port", "0", "--saves", "/proc/x");
        assertThat(outcome.code()).isEqualTo(2);
        assertThat(outcome.err()).contains("--saves /proc/x: it cannot be made: ");
    }

    @Test
    void aHeapInWhichNoWorldFitsIsRefusedInWords() throws Exception {
        for (String heap : List.of("8m", "1000k", "63M")) {
            Process launched =
                    new ProcessBuilder(
                                    "env",
                                    "REVE_HEAP=" + heap,
                                    Project.ROOT.resolve("reve").toString(),
                                    "--version")
                            .start();
            assertThat(new String(launched.getErrorStream().readAllBytes()))
                    .isEqualTo("reve: REVE_HEAP is " + heap + ", expected 64m or more\n");
            assertThat(launched.waitFor()).isEqualTo(2);
        }
    }

    @Test
    void aReplayBeyondTheEndOfTheRecordingSaysSo() throws Exception {
        String log = folder.resolve("run.log").toString();
        assertThat(Reve.run("run", WORLD, "--seconds", "1", "--record", log).code()).isZero();
        Outcome beyond = Reve.run("replay", log, "--until", "99");
        assertThat(beyond.code()).isZero();
        assertThat(beyond.out()).contains("the recording ends at frame 60, before frame 99");
        assertThat(Reve.run("replay", log, "--until", "60").out()).doesNotContain("before frame");
    }

    @Test
    void aLimitOfFileSizesIsNamedAsSuch() throws Exception {
        Outcome outcome =
                Reve.run(
                        Stream.concat(
                                        List.of("bash", "-c", "ulimit -f 1; exec \"$@\"", "bash")
                                                .stream(),
                                        Reve.command("run", WORLD).stream())
                                .toList());
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err())
                .contains("File too large", "(ulimit -f)")
                .doesNotContain("world.yaml:");
    }

    /** A limit of file sizes stands for a full disk. */
    @Test
    void newFilesThatTheDiskDoesNotTakeAreNamedAndRemoved() throws Exception {
        Path token = folder.resolve("secret.token");
        Path tokens = folder.resolve("tokens.json");
        Path world = folder.resolve("fresh");
        Path robot = folder.resolve("robot");
        String arm = Project.ROOT.resolve("worlds/robot-arm/arm.urdf").toString();
        for (List<String> command :
                List.of(
                        Reve.command("token", "new", "ada", "--file", tokens.toString()),
                        Reve.command(
                                "token",
                                "new",
                                "ada",
                                "--file",
                                tokens.toString(),
                                "--out",
                                token.toString()),
                        Reve.command("new", "world", world.toString()),
                        Reve.command("import", arm, "--out", robot.toString()))) {
            Outcome outcome =
                    Reve.run(
                            Stream.concat(
                                            List.of(
                                                    "bash",
                                                    "-c",
                                                    "ulimit -f 0; exec \"$@\"",
                                                    "bash")
                                                    .stream(),
                                            command.stream())
                                    .toList());
            assertThat(outcome.code()).as(outcome.err()).isEqualTo(1);
            assertThat(outcome.err()).contains("File too large", folder + "/");
            try (Stream<Path> left = Files.list(folder)) {
                assertThat(left.map(Path::getFileName).map(Path::toString))
                        .allMatch(name -> name.equals(".tokens.json.lock"));
            }
        }
    }

    @Test
    void tooFewOpenFilesAreRefusedBeforeTheProgramStarts() throws Exception {
        Outcome outcome =
                Reve.run(
                        Stream.concat(
                                        List.of("bash", "-c", "ulimit -n 40; exec \"$@\"", "bash")
                                                .stream(),
                                        Reve.command("run", WORLD).stream())
                                .toList());
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err())
                .hasLineCount(1)
                .contains("only 40 files", "expected 256 or more", "ulimit -n 4096");
    }

    @Test
    void aNameThatTheCharacterSetCannotWriteIsRefusedInWords() throws Exception {
        Path natives = Project.ROOT.resolve("build/native");
        Outcome outcome =
                Reve.run(inC(Reve.commandIn(natives, "serve", WORLD, "--store", "\u00e4.db")));
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(2);
        assertThat(outcome.err())
                .contains("'--store'", "the character set of the system", "LC_ALL=C.UTF-8")
                .doesNotContain("java.", "Exception");
    }

    /**
     * Returns a command that runs another one in the locale of a system service, in which names of
     * files are ASCII.
     */
    private List<String> inC(List<String> command) throws Exception {
        Path script =
                Files.writeString(
                        folder.resolve("script"),
                        "LC_ALL=C exec "
                                + command.stream()
                                        .map(each -> "'" + each + "'")
                                        .collect(joining(" ")));
        return List.of("bash", script.toString());
    }

    @Test
    void theLauncherUsesUtf8WhereTheSystemHasNoCharacterSet() throws Exception {
        Outcome outcome =
                Reve.run(inC(Reve.command("check", folder.resolve("\u00e4.yaml").toString())));
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err()).contains("\u00e4.yaml").doesNotContain("character set");
    }

    /**
     * The thread that follows the folder must not end, and no name of a file may forge lines of a
     * log.
     */
    @Test
    void aFileWhoseNameTheCharacterSetCannotWriteDoesNotStopTheLawsFolder() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("laws"));
        Files.writeString(laws.resolve("a\u00e4\n\u001b[31mforged.law"), "law a");
        Files.writeString(
                laws.resolve("good.law"), "law good\n  each body:\n    force += 1 N * (1, 0, 0)\n");
        Path natives = Project.ROOT.resolve("build/native");
        List<String> command =
                Reve.commandIn(
                        natives,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--laws",
                        laws.toString());
        Path errors = folder.resolve("server.err");
        Process process = new ProcessBuilder(inC(command)).redirectError(errors.toFile()).start();
        try (Server server = new Server(process, new Server.Events(process, errors))) {
            server.events()
                    .await("law-loaded", event -> event.path("library").asString().equals("good"));
            long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(300);
            while (!Files.readString(errors).contains("the character set of the system")) {
                assertThat(process.isAlive() && System.nanoTime() < end)
                        .as(Files.readString(errors))
                        .isTrue();
                Thread.sleep(20);
            }
            process.toHandle().destroy();
            server.events().await("end", event -> true);
            assertThat(server.exitCode()).as(Files.readString(errors)).isZero();
        }
        String messages = Files.readString(errors);
        assertThat(messages).doesNotContain("Exception", "\u001b");
        assertThat(messages.lines())
                .noneMatch(line -> line.contains("forged") && !line.contains("WARN"));
    }

    @Test
    void aNumberHasDigitsOfOneScriptOnly() throws Exception {
        refused(
                "'--audit-size': found '\uff11', expected a whole number",
                "serve",
                WORLD,
                "--audit",
                folder.resolve("a").toString(),
                "--audit-size",
                "\uff11");
        refused(
                "'--port': found '99999999999', expected a whole number up to 2147483647",
                "serve",
                WORLD,
                "--port",
                "99999999999");
        for (String wrong : List.of("x", "nan", "Infinity", "2s", "1,5", "1e999")) {
            refused(
                    "'--seconds': found '"
                            + wrong
                            + "', expected a finite number without a unit, such as 2.5",
                    "run",
                    WORLD,
                    "--seconds",
                    wrong);
        }
        refused("'--port': found 'x', expected a whole number\n", "serve", WORLD, "--port", "x");
        refused(
                "'--law-memory': found '1.5', expected a whole number\n",
                "run",
                WORLD,
                "--law-memory",
                "1.5");
        refused("--seconds is -5, expected a time of 0 s or more\n", "run", WORLD, "--seconds=-5");
        refused(
                "--seconds is 1e300, expected a time of at most 1.501e14 s\n",
                "run",
                WORLD,
                "--seconds",
                "1e300");
    }

    @Test
    void aMisspeltCommandOrOptionIsRefusedWithASuggestion() throws Exception {
        refused("./reve has no command 'rnu'; did you mean `run`?\n", "rnu", "x");
        refused("./reve has no command 'hlep'; did you mean `help`?\n", "hlep");
        refused("./reve has no command 'buidl'; did you mean `build`?\n", "buidl");
        refused("./reve has no command 'rnu'; did you mean `run`?\n", "help", "rnu");
        refused("./reve has no command 'nosuch', expected one of build, check, ", "help", "nosuch");
        refused("./reve law has no command 'chekc'; did you mean `check`?\n", "law", "chekc", "x");
        refused("./reve store has no command 'chekc'; did you mean `check`?\n", "store", "chekc");
        refused(
                "./reve run has no option '--secnods'; did you mean `--seconds`?\n",
                "run",
                WORLD,
                "--secnods",
                "5");
        refused("'5' is one argument too many for ./reve run\n", "run", WORLD, "5");
        refused(
                "'puase' is no command of the role control; did you mean `pause`?\n",
                "control",
                "puase");
        refused("it has image; did you mean `image`?\n", "control", "rewind", "imgae=calm");
    }

    /** A build may take minutes. */
    @Test
    void aCheckoutRefusesAnUnknownCommandWithoutBuilding() throws Exception {
        Outcome near = Reve.launch("buidl");
        assertThat(near.code()).isEqualTo(2);
        assertThat(near.err()).contains("has no command 'buidl'; did you mean `build`?\n");
        Path scripts = Files.createDirectories(folder.resolve("scripts/release"));
        Files.copy(Project.ROOT.resolve("reve"), folder.resolve("reve"), COPY_ATTRIBUTES);
        Files.copy(Project.ROOT.resolve("scripts/release/java.sh"), scripts.resolve("java.sh"));
        for (List<String> words : List.of(List.of("buidl"), List.of("help", "buidl"))) {
            List<String> command = new ArrayList<>(List.of(folder.resolve("reve").toString()));
            command.addAll(words);
            Outcome fresh = Reve.run(command);
            assertThat(fresh.code()).isEqualTo(2);
            assertThat(fresh.err())
                    .startsWith("reve: ./reve has no command 'buidl', expected one of build test ");
        }
        assertThat(folder.resolve("build")).doesNotExist();
    }

    @Test
    void theLauncherKnowsTheCommandsOfTheHelp() throws Exception {
        Set<String> described =
                Reve.run("--help")
                        .out()
                        .lines()
                        .filter(line -> line.matches(" {2}[a-z]+ {2,}\\S.*"))
                        .map(line -> line.strip().split(" ")[0])
                        .collect(toSet());
        Set<String> known =
                Files.readString(Project.ROOT.resolve("reve"))
                        .lines()
                        .filter(line -> line.matches("(own|release)_commands=\".*\""))
                        .flatMap(line -> Stream.of(line.split("\"")[1].split(" ")))
                        .collect(toSet());
        assertThat(known).isEqualTo(described);
    }

    @Test
    void aWrongPathOfAWorldIsRefusedWithAWorldThatMayBeMeant() throws Exception {
        Path near = Files.createDirectories(folder.resolve("worlds/near"));
        Files.writeString(near.resolve("world.yaml"), "reve: 1\nname: near\nitems: []\n");
        Files.writeString(folder.resolve("worlds/far.yaml"), "reve: 1\nname: far\nitems: []\n");
        Map<String, String> messages =
                Map.of(
                        "worlds/naer", "did you mean `" + folder + "/worlds/near`?\n",
                        "worlds/naer/world.yaml",
                                "did you mean `" + folder + "/worlds/near/world.yaml`?\n",
                        "wrlds/near", "did you mean `" + folder + "/worlds/near`?\n",
                        "worlds/far.yml", "did you mean `" + folder + "/worlds/far.yaml`?\n",
                        "worlds", "; in " + folder + "/worlds are far.yaml, near\n",
                        "worlds/other", "; in " + folder + "/worlds are far.yaml, near\n");
        for (Map.Entry<String, String> each : messages.entrySet()) {
            Outcome outcome = Reve.run("run", folder.resolve(each.getKey()).toString());
            assertThat(outcome.code()).isEqualTo(1);
            assertThat(outcome.err())
                    .contains("there is no world file " + folder.resolve(each.getKey()))
                    .endsWith(each.getValue());
        }
    }

    /** A user may take the name of a sample world for its path. */
    @Test
    void theNameOfASampleWorldIsRefusedWithItsPath() throws Exception {
        for (String name : List.of("pendulum", "pendulm")) {
            List<String> command = Reve.command("check", name);
            command.addAll(1, List.of("-C", Project.ROOT.toString()));
            Outcome outcome = Reve.run(command);
            assertThat(outcome.code()).isEqualTo(1);
            assertThat(outcome.err()).endsWith("; did you mean `worlds/pendulum`?\n");
        }
    }

    @Test
    void aPipeInPlaceOfCertificatesIsRefused() throws Exception {
        Path pipe = folder.resolve("pipe");
        assertThat(new ProcessBuilder("mkfifo", pipe.toString()).start().waitFor()).isZero();
        Outcome outcome =
                Reve.run("control", "pause", "--port", "1", "--tls-trust", pipe.toString());
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err()).contains(pipe + " is no file, expected a file of certificates");
    }

    /** The start takes long because the constructor of a law library sleeps. */
    @Test
    void whatIsStoppedWhileItStartsEndsWell() throws Exception {
        Path mark = folder.resolve("mark");
        Files.writeString(
                folder.resolve("slow.c"),
                """
                #include <stdio.h>
                #include <unistd.h>
                __attribute__((constructor)) static void hold(void) {
                  fclose(fopen("%s", "w"));
                  sleep(30);
                }
                """
                        .formatted(mark));
        new Shell(folder)
                .run("mkdir laws && gcc -shared -fPIC slow.c" + " -o laws/libvesper_law_slow.so");
        Path world =
                Files.writeString(
                        folder.resolve("world.yaml"),
                        "reve: 1\nname: held\nlaws: [slow]\nitems: []\n");
        for (String command : List.of("serve", "run")) {
            Files.deleteIfExists(mark);
            Process process =
                    new ProcessBuilder(
                                    Reve.command(
                                            command,
                                            world.toString(),
                                            "--laws",
                                            folder.resolve("laws").toString()))
                            .start();
            while (!Files.exists(mark)) {
                assertThat(process.isAlive()).as(command).isTrue();
                Thread.sleep(5);
            }
            List<ProcessHandle> probes = process.descendants().toList();
            process.toHandle().destroy();
            assertThat(process.waitFor()).as(command).isZero();
            probes.forEach(ProcessHandle::destroyForcibly);
        }
    }

    @Test
    void aSaveOrALawThatIsRefusedIsOneLineInTheLog() throws Exception {
        Path saves = Files.createDirectory(folder.resolve("saves"));
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--saves",
                        saves.toString())) {
            try (AgentClient boss =
                    Agents.join(
                            Integer.parseInt(server.port()), Join.as("boss").withRole("control"))) {
                Files.delete(saves);
                ActResult save = boss.command("save", Map.of("file", "later"));
                assertThat(save.code()).contains("save-refused");
                ActResult load = boss.command("load-law", Map.of("library", "nowhere"));
                assertThat(load.code()).contains("law-refused");
            }
            server.process().toHandle().destroy();
            assertThat(server.exitCode()).isZero();
        }
        String log = Files.readString(folder.resolve("server.err"));
        assertThat(log)
                .contains(
                        "the world cannot be saved as "
                                + saves.resolve("later.yaml")
                                + ": there is no folder "
                                + saves,
                        "the law library nowhere was asked for and " + "refused: ")
                .doesNotContain("Exception");
        // A busy machine may cause lines about other things.
        assertThat(
                        log.lines()
                                .filter(
                                        line ->
                                                line.contains("cannot be saved")
                                                        || line.contains("was asked for")))
                .hasSizeLessThanOrEqualTo(2);
    }

    @Test
    void lawsHaveADeadlineAndALimitOfMemory() throws Exception {
        Outcome outcome =
                Reve.run(
                        "run",
                        WORLD,
                        "--seconds",
                        "0.1",
                        "--law-deadline",
                        "5000",
                        "--law-memory",
                        "512");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        refused("--law-memory is -1", "run", WORLD, "--law-memory", "-1");
        refused("--law-deadline is 0", "run", WORLD, "--law-deadline", "0");
    }

    @Test
    void theJvmTakesOptionsFromTheEnvironment() throws Exception {
        List<String> command = Reve.command("--version");
        command.add(2, "REVE_JAVA_OPTIONS=-Dx=y -XX:NoSuchOption=1");
        Reve.Outcome outcome = Reve.run(command);
        assertThat(outcome.code()).isOne();
        assertThat(outcome.out() + outcome.err()).contains("NoSuchOption=1");
    }
}
