// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.withinPercentage;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Set;
import java.util.concurrent.TimeUnit;

/** The output, the messages and the exit codes that a new user gets from the commands. */
@Tag("slow")
class CommandLineIT {
    private static final String SPRING_ORBIT = Project.WORLDS.resolve("spring-orbit").toString();

    @TempDir private Path folder;

    @Test
    void aCommandLeavesNoProcessBehind() throws Exception {
        Reve.Outcome check =
                Reve.run("check", Project.ROOT.resolve("worlds/spring-orbit").toString());
        assertThat(check.code()).as(check.err()).isZero();
        for (ProcessHandle child : ProcessHandle.current().children().toList()) {
            if (child.info().command().orElse("").endsWith("vesper-host")) {
                child.onExit().get(300, TimeUnit.SECONDS); // it is about to end
            }
        }
    }

    @Test
    void helpNamesEveryCommandAndExitCode() throws Exception {
        Outcome help = Reve.runAsProcess("--help");
        assertThat(help.code()).isZero();
        assertThat(help.out())
                .contains(
                        "serve", "run", "picture", "check", "demo", "build", "test", "Exit codes");
        for (String command : new String[] {"serve", "run", "picture", "check", "demo"}) {
            assertThat(Reve.run(command, "--help").code()).as(command).isZero();
        }
    }

    @Test
    void wrongUsageIsExitCode2AndSaysWhatIsWrongAndWhereToReadMore() throws Exception {
        Outcome unknown = Reve.runAsProcess("pictures");
        assertThat(unknown.code()).isEqualTo(2);
        assertThat(unknown.err())
                .contains("pictures")
                .contains("did you mean `picture`?")
                .endsWith("`./reve --help` says more\n");
        assertThat(unknown.err().lines()).hasSizeLessThanOrEqualTo(4);
        assertThat(Reve.run("run", SPRING_ORBIT, "--seconds", "-1").code()).isEqualTo(2);
        Outcome port = Reve.run("serve", SPRING_ORBIT, "--port", "70000");
        assertThat(port.code()).isEqualTo(2);
        assertThat(port.err()).contains("--port is 70000").contains("65535");
        Outcome waiting = Reve.run("serve", SPRING_ORBIT, "--waiting", "never");
        assertThat(waiting.code()).isEqualTo(2);
        assertThat(waiting.err()).contains("--waiting is 'never', expected off or 0.001 to 86400");
        Outcome size =
                Reve.run(
                        "picture",
                        SPRING_ORBIT,
                        "--out",
                        folder.resolve("x.png").toString(),
                        "--size",
                        "huge");
        assertThat(size.code()).isEqualTo(2);
        assertThat(size.err().lines()).hasSize(2);
        assertThat(size.err()).contains("'huge' is no size", "`./reve picture --help` says more");
        Outcome jpeg =
                Reve.run("picture", SPRING_ORBIT, "--out", folder.resolve("x.jpg").toString());
        assertThat(jpeg.code()).isEqualTo(2);
        assertThat(jpeg.err()).contains("x.jpg: pictures are PNG");
        assertThat(folder.resolve("x.jpg")).doesNotExist();
    }

    @Test
    void threadsAndValidationLeaveTheBitsAsTheyAre() throws Exception {
        String world = Project.WORLDS.resolve("icosahedron").toString();
        JsonMapper mapper = new JsonMapper();
        Set<String> hashes = new HashSet<>();
        for (List<String> options :
                List.of(
                        List.of("--threads", "1"),
                        List.of("--threads", "3"),
                        List.of("--validate"))) {
            List<String> command =
                    new ArrayList<>(List.of("run", world, "--seconds", "0.2", "--json"));
            command.addAll(options);
            Outcome run = Reve.run(command.toArray(String[]::new));
            assertThat(run.code()).as(run.err()).isZero();
            hashes.add(mapper.readTree(run.out()).get("stateHash").asString());
        }
        assertThat(hashes).hasSize(1);
        Outcome none = Reve.run("run", world, "--threads", "0");
        assertThat(none.code()).isEqualTo(2);
        assertThat(none.err()).contains("--threads is 0, expected 1 to 256");
    }

    @Test
    void helpIsACommandToo() throws Exception {
        assertThat(Reve.launch("help").out()).contains("serve", "new", "Exit codes");
        assertThat(Reve.launch("help", "run").out()).startsWith("Usage: ./reve run");
        assertThat(Reve.launch("help", "clean").out()).startsWith("Usage: ./reve clean");
    }

    @Test
    void aNewWorldRunsWithoutAWarning() throws Exception {
        Path world = folder.resolve("my world");
        Outcome made = Reve.runAsProcess("new", "world", world.toString());
        assertThat(made.code()).as(made.err()).isZero();
        assertThat(made.out()).contains("serve '" + world + "'");
        assertThat(Reve.runAsProcess("check", "--strict", world.toString()).code()).isZero();
        Outcome again = Reve.run("new", "world", world.toString());
        assertThat(again.code()).isEqualTo(1);
        assertThat(again.err()).contains("is there already; nothing was written");
        Outcome near = Reve.run("check", folder.resolve("my wrld").toString());
        assertThat(near.err()).contains("did you mean `" + world + "`?");
        assertThat(Reve.run("check", folder.resolve("pendulum").toString()).err())
                .contains("in " + folder + " are my world");
    }

    @Test
    void theLaunchersOwnCommandsHaveHelpAndTakeNothingElse() throws Exception {
        for (String command : new String[] {"build", "test", "format", "docs", "clean"}) {
            Outcome help = Reve.launch(command, "--help");
            assertThat(help.code()).as(command).isZero();
            assertThat(help.out()).startsWith("Usage: ./reve " + command);
            Outcome wrong = Reve.launch(command, "everything");
            assertThat(wrong.code()).as(command).isEqualTo(2);
            assertThat(wrong.err()).contains(command, "found: everything");
        }
    }

    @Test
    void foldersThatServeIsToldAreMadeButNotWhatTheyAreIn() throws Exception {
        Path folders = folder.resolve("new");
        String[] options = {"--pictures", "--saves"};
        for (String option : options) {
            Outcome outcome = serveWith(option, folders.resolve("within"));
            assertThat(outcome.code()).as(option).isEqualTo(2);
            assertThat(outcome.err()).contains(option, "there is no folder " + folders);
        }
        Path file = write("no folder");
        for (String option : options) {
            Path made = folder.resolve("made-for" + option);
            assertThat(serveWith(option, made).code()).as(option).isZero();
            assertThat(made).isDirectory();
            Outcome outcome = serveWith(option, file);
            assertThat(outcome.code()).as(option).isEqualTo(2);
            assertThat(outcome.err()).contains(option + " " + file + ": is a file");
        }
    }

    private static Outcome serveWith(String option, Path folder) throws Exception {
        return Reve.run(
                "serve",
                SPRING_ORBIT,
                "--port",
                "0",
                "--fast",
                "--seconds",
                "0.1",
                option,
                folder.toString());
    }

    @Test
    void runReportsTheSameStateTwice() throws Exception {
        JsonNode first = json(Reve.runAsProcess("run", SPRING_ORBIT, "--seconds", "1", "--json"));
        JsonNode second = json(Reve.run("run", SPRING_ORBIT, "--seconds", "1", "--json"));
        assertThat(first.get("frames").asLong()).isEqualTo(60);
        assertThat(first.get("stateHash").asString())
                .matches("[0-9a-f]{16}")
                .isEqualTo(second.get("stateHash").asString());
        assertThat(first.get("faults").size()).isZero();
    }

    @Test
    void profileShowsEachPartPerBody() throws Exception {
        Outcome profile = Reve.run("run", SPRING_ORBIT, "--seconds", "1", "--profile");
        assertThat(profile.code()).isZero();
        assertThat(profile.out())
                .contains(
                        "ns/body",
                        "PHYSICS advance",
                        "PHYSICS rollback copy",
                        "DERIVE",
                        "PUBLISH snapshot copy",
                        "PUBLISH readers",
                        "rest",
                        "p50 ns/frame",
                        "p99 ns/frame")
                .containsPattern("\\nhooke_spring +[1-9][0-9]* +[1-9][0-9]* +[0-9.]+%\\n")
                .containsPattern("\\nnewton_motion +[1-9][0-9]* +[1-9][0-9]* +[0-9.]+%\\n");
    }

    @Test
    void ledgerSaysWhatEachLawGave() throws Exception {
        Outcome outcome = Reve.run("run", SPRING_ORBIT, "--seconds", "1", "--ledger", "--json");
        JsonNode ledger = json(outcome).get("ledger");
        assertThat(
                        ledger.valueStream()
                                .map(
                                        line ->
                                                line.path("law")
                                                        .asString(line.path("line").asString())))
                .containsExactly("hooke_spring", "newton_motion", "total");
        JsonNode spring = ledger.get(0);
        JsonNode total = ledger.get(2);
        assertThat(spring.get("momentum").valueStream().mapToDouble(JsonNode::asDouble))
                .as("the two ends are pulled alike")
                .allMatch(p -> Math.abs(p) < 1e-9);
        assertThat(spring.get("potentialEnergy").has("present")).isTrue();
        assertThat(total.get("energy").asDouble())
                .as("the spring does all the work")
                .isNotZero()
                .isCloseTo(spring.get("energy").asDouble(), withinPercentage(1e-6));
        Outcome table = Reve.run("run", SPRING_ORBIT, "--seconds", "1", "--ledger");
        assertThat(
                        table.out()
                                .lines()
                                .filter(line -> line.startsWith("  "))
                                .map(line -> line.strip().split(" ")[0]))
                .containsExactly("ledger", "hooke_spring", "newton_motion", "total");
    }

    @Test
    void snapshotWritesThePictureItNames() throws Exception {
        Path picture = folder.resolve("orbit.png");
        Outcome outcome =
                Reve.runAsProcess(
                        "picture",
                        SPRING_ORBIT,
                        "--at",
                        "1",
                        "--out",
                        picture.toString(),
                        "--size",
                        "320x200");
        assertThat(outcome.messages()).isEmpty();
        assertThat(outcome.out().strip()).isEqualTo(picture.toString());
        var image = javax.imageio.ImageIO.read(picture.toFile());
        assertThat(image.getWidth()).isEqualTo(320);
        assertThat(image.getHeight()).isEqualTo(200);
        assertThat(hasPixelLike(image, 0xc0392b)).as("the red ball").isTrue();
        assertThat(hasPixelLike(image, 0x3498db)).as("the blue ball").isTrue();
    }

    @Test
    void everyPictureOfAFastServerIsTaken() throws Exception {
        Path pictures = folder.resolve("pictures");
        Outcome outcome =
                Reve.runAsProcess(
                        "serve",
                        SPRING_ORBIT,
                        "--port",
                        "0",
                        "--fast",
                        "--seconds",
                        "6",
                        "--json",
                        "--pictures",
                        pictures.toString(),
                        "--picture-at",
                        "0,1,2,3,4,5,5.1");
        assertThat(outcome.code()).isZero();
        assertThat(outcome.out()).doesNotContain("picture-failed");
        try (var files = Files.list(pictures)) {
            assertThat(files.map(file -> file.getFileName().toString()).sorted())
                    .containsExactly(
                            "spring-orbit-000000.png",
                            "spring-orbit-000060.png",
                            "spring-orbit-000120.png",
                            "spring-orbit-000180.png",
                            "spring-orbit-000240.png",
                            "spring-orbit-000300.png",
                            "spring-orbit-000306.png");
        }
    }

    /** Returns whether a pixel has the hue of a colour, in any light. */
    private static boolean hasPixelLike(java.awt.image.BufferedImage image, int rgb) {
        float hue = hue(rgb)[0];
        for (int y = 0; y < image.getHeight(); y++) {
            for (int x = 0; x < image.getWidth(); x++) {
                float[] pixel = hue(image.getRGB(x, y));
                if (Math.abs(pixel[0] - hue) < 0.03 && pixel[1] > 0.5) {
                    return true;
                }
            }
        }
        return false;
    }

    private static float[] hue(int rgb) {
        return java.awt.Color.RGBtoHSB(rgb >> 16 & 0xff, rgb >> 8 & 0xff, rgb & 0xff, null);
    }

    @Test
    void checkAcceptsTheSamples() throws Exception {
        try (var worlds = Files.list(Project.WORLDS)) {
            for (Path world : worlds.filter(w -> Files.exists(w.resolve("world.yaml"))).toList()) {
                Outcome outcome = Reve.run("check", world.toString());
                assertThat(outcome.code()).as(outcome.err()).isZero();
                assertThat(outcome.out()).as(world.toString()).contains(": valid, ");
            }
        }
    }

    @Test
    void checkNamesEveryProblemWithItsPlace() throws Exception {
        Path world =
                write(
                        """
                        reve: 1
                        name: broken
                        items:
                          - name: a
                            physical: {shape: sphere, radius: 1}
                            physics: {mass: 1 kg, velocty: [0, 1, 0]}
                          - name: b
                            physics: {mass: 3 m, velocity: [0, .nan, 0]}
                          - name: a
                            physics: {mass: 1}
                          - name: s
                            kind: spring
                            physics: {springConstant: 1, end1: a, end2: nobody}
                        """);
        Outcome outcome = Reve.runAsProcess("check", world.toString());
        assertThat(outcome.code()).isEqualTo(3);
        assertThat(outcome.out()).isEmpty();
        assertThat(outcome.err().lines()).hasSize(5).allMatch(line -> line.startsWith(world + ":"));
        assertThat(outcome.err().lines().toList())
                .satisfiesExactly(
                        line ->
                                assertThat(line)
                                        .contains(":6:")
                                        .contains("velocty")
                                        .contains("velocity"),
                        line -> assertThat(line).contains(":8:").contains("mass").contains("kg"),
                        line ->
                                assertThat(line)
                                        .contains(":8:")
                                        .contains("`.nan`")
                                        .contains("finite"),
                        line -> assertThat(line).contains(":9:").contains("`a`").contains("line 4"),
                        line -> assertThat(line).contains(":13:").contains("nobody"));
        JsonNode json =
                new JsonMapper().readTree(Reve.run("check", "--json", world.toString()).out());
        assertThat(json.get("valid").asBoolean()).isFalse();
        assertThat(json.get("problems").size()).isEqualTo(5);
        assertThat(json.at("/problems/0/line").asInt()).isEqualTo(6);
    }

    @Test
    void checkRunAndServeWarnOfAWorldInWhichNothingMoves() throws Exception {
        Path world =
                write(
                        """
                        reve: 1
                        name: silent
                        constants: {gravity: [0, -9.81, 0]}
                        laws: [gravity_field]
                        items: [{name: ball, physics: {mass: 1}}]
                        """);
        String warning =
                world
                        + ":4:8: warning: law gravity_field: exerts forces, but nothing moves,"
                        + " because no law of this world moves bodies; add a law that moves bodies"
                        + " to `laws`, for example newton_motion";
        Outcome checked = Reve.run("check", world.toString());
        assertThat(checked.code()).isZero();
        assertThat(checked.err()).isEqualTo(warning + "\n");
        assertThat(checked.out()).endsWith("valid, 1 items, 1 laws, warnings: 1\n");
        Outcome strict = Reve.run("check", "--strict", "--json", world.toString());
        assertThat(strict.code()).isEqualTo(3);
        JsonNode json = new JsonMapper().readTree(strict.out());
        assertThat(json.get("valid").asBoolean()).isFalse();
        assertThat(json.at("/warnings/0/line").asInt()).isEqualTo(4);
        Outcome run = Reve.run("run", world.toString(), "--seconds", "0.1", "--json");
        assertThat(run.code()).isZero();
        assertThat(run.err()).startsWith(warning + "\n");
        assertThat(new JsonMapper().readTree(run.out()).at("/warnings/0/column").asInt())
                .isEqualTo(8);
        Outcome served =
                Reve.run("serve", world.toString(), "--port", "0", "--seconds", "0.1", "--json");
        assertThat(served.code()).isZero();
        assertThat(served.err()).startsWith(warning + "\n");
        JsonNode ready = new JsonMapper().readTree(served.out().lines().findFirst().orElseThrow());
        assertThat(ready.at("/warnings/0").asString()).isEqualTo(warning);
    }

    @Test
    void aWorldThatDivergesNamesItemLawAndStepAndSaysWhatToTry() throws Exception {
        Path world =
                write(
                        """
                        reve: 1
                        name: stiff
                        laws: [hooke_spring, newton_motion]
                        items:
                          - {name: a, physics: {mass: 1}}
                          - {name: b, physical: {location: [1.1, 0, 0]}, physics: {mass: 1}}
                          - name: s
                            kind: spring
                            physics: {end1: a, end2: b, length: 1, springConstant: 10 kN/m}
                        """);
        Outcome run = Reve.run("run", world.toString(), "--seconds", "10");
        assertThat(run.code()).isEqualTo(1);
        assertThat(run.out())
                .containsPattern(
                        "after [0-9]+ steps: law [a-z_]+: property .* of item [ab]; if the")
                .contains("make its steps shorter");
    }

    @Test
    void aLawThatDoesNotExistIsExitCode4() throws Exception {
        Path world =
                write(
                        """
                        reve: 1
                        name: lawless
                        laws: [newton_motoin]
                        items: []
                        """);
        Outcome outcome = Reve.run("check", world.toString());
        assertThat(outcome.code()).isEqualTo(4);
        assertThat(outcome.err()).startsWith(world + ":3:8: ").contains("newton_motoin");
    }

    @Test
    void allLawsThatDoNotLoadAreToldAtOnce() throws Exception {
        Path world =
                write(
                        """
                        reve: 1
                        name: lawless
                        laws:
                          - newton_motoin
                          - gravity_field
                          - {name: barnes_hut_gravitation, parameters: {brightness: 3}}
                        """);
        Outcome outcome = Reve.run("check", world.toString());
        assertThat(outcome.code()).isEqualTo(4);
        assertThat(outcome.err().lines().toList())
                .satisfiesExactly(
                        line ->
                                assertThat(line)
                                        .startsWith(world + ":4:5: ")
                                        .contains("newton_motoin"),
                        line ->
                                assertThat(line)
                                        .startsWith("  " + world + ":6:49: ")
                                        .contains("brightness"));
        JsonNode json =
                new JsonMapper().readTree(Reve.run("check", "--json", world.toString()).out());
        assertThat(json.get("problems").size()).isEqualTo(2);
    }

    @Test
    void whatIsNoRecordingIsNamedWithTheReason() throws Exception {
        Path none = folder.resolve("none.log");
        assertRefused(none, "there is no recording " + none);
        assertRefused(folder, folder + " is no file that could be a recording");
        Path text = write("hello\n");
        assertRefused(text, text + " is no recording of this version of REVE");
        Path begun = Files.writeString(folder.resolve("begun.log"), "REVE run log 2\n");
        assertRefused(begun, begun + " ends before the first image of the world");
        Outcome negative = Reve.run("replay", begun.toString(), "--until", "-1");
        assertThat(negative.code()).isEqualTo(2);
        assertThat(negative.err()).contains("--until is -1, expected a frame from 0 on");
    }

    private static void assertRefused(Path recording, String reason) throws Exception {
        Outcome outcome = Reve.run("replay", recording.toString());
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err()).startsWith("reve: " + reason);
    }

    @Test
    void aMissingFileIsNamed() throws Exception {
        Outcome outcome = Reve.run("run", folder.resolve("nowhere.yaml").toString());
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err()).contains("there is no world file").contains("nowhere.yaml");
    }

    @Test
    void aTakenPortIsExitCode5() throws Exception {
        try (var taken =
                new java.net.ServerSocket(0, 1, java.net.InetAddress.getLoopbackAddress())) {
            String port = Integer.toString(taken.getLocalPort());
            Outcome outcome = Reve.runAsProcess("serve", SPRING_ORBIT, "--port", port);
            assertThat(outcome.code()).isEqualTo(5);
            assertThat(outcome.err()).contains(port);
        }
    }

    private Path write(String text) throws IOException {
        return Files.writeString(folder.resolve("world.yaml"), text);
    }

    private static JsonNode json(Outcome outcome) {
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }
}
