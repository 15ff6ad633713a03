// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;

/** The command {@code import}, and the robots of sample worlds, which agents drive. */
@Tag("slow")
class RobotIT {
    private static final Path ARM = Project.WORLDS.resolve("robot-arm");

    @TempDir private Path folder;

    @Test
    void theSampleWorldContainsTheRobotAsItIsImported() throws Exception {
        Path out = folder.resolve("arm");
        String urdf = ARM.resolve("arm.urdf").toString();
        Outcome imported = Reve.run("import", urdf, "--hold", "--out", out.toString());
        assertThat(imported.code()).as(imported.err()).isZero();
        assertThat(imported.err()).isEmpty();
        assertThat(imported.out())
                .startsWith(out + "/world.yaml: robot-arm, 4 bodies, 3 joints, 0 meshes\n");
        assertThat(out.resolve("robot.yaml")).hasSameTextualContentAs(ARM.resolve("robot.yaml"));

        Outcome again = Reve.run("import", urdf, "--out", out.toString());
        assertThat(again.code()).isEqualTo(2);
        assertThat(again.err()).contains("--out " + out + " is there already");
        Path other = folder.resolve("other");
        Outcome json = Reve.run("import", urdf, "--json", "--out", other.toString());
        JsonNode result = new JsonMapper().readTree(json.out());
        assertThat(result.path("bodies").asInt()).isEqualTo(4);
        assertThat(result.path("notes").size()).isZero();
        Outcome run = Reve.run("run", other.toString(), "--seconds", "0.2");
        assertThat(run.code()).as(run.err()).isZero();
    }

    @Test
    void whatIsNoRobotIsRefusedAtItsLineAndNothingIsWritten() throws Exception {
        Path file = Files.writeString(folder.resolve("wrong.urdf"), "<robot>\n<link/>\n</robot>");
        Path out = folder.resolve("out");
        Outcome refused = Reve.run("import", file.toString(), "--out", out.toString());
        assertThat(refused.code()).isEqualTo(3);
        assertThat(refused.err())
                .isEqualTo(
                        "reve: " + file + ":2: <link> has no attribute name, which it must have\n");
        assertThat(out).doesNotExist();
        Outcome missing =
                Reve.run("import", folder.resolve("none.urdf").toString(), "--out", out.toString());
        assertThat(missing.code()).isEqualTo(1);
        assertThat(missing.err()).contains("none.urdf");
    }

    /** The same inputs give the same frames: the agent is in lock-step. */
    @Test
    void anAgentPushesTheBallsOffByInverseKinematics() throws Exception {
        assertThat(push()).isEqualTo(push());
    }

    /** The car passes four gates on its way of a few metres between them. */
    @Test
    void anAgentDrivesTheCarThroughItsGates() throws Exception {
        String summary = drive("car", "drive.py");
        JsonNode drive = new JsonMapper().readTree(summary);
        assertThat(drive.path("gates").size()).as(summary).isEqualTo(4);
        assertThat(drive.path("metres").asDouble()).as(summary).isBetween(14.0, 20.0);
        // The agents join in different frames, and a car that stands still creeps a little.
        int rounds = drive.path("rounds").asInt();
        JsonNode again = new JsonMapper().readTree(drive("car", "drive.py"));
        assertThat(again.path("rounds").asInt()).as(summary).isBetween(rounds - 2, rounds + 2);
    }

    @Test
    void theCarIsAsItIsImportedFromMjcf() throws Exception {
        Path car = Project.WORLDS.resolve("car");
        Path out = folder.resolve("car");
        Outcome imported =
                Reve.run("import", car.resolve("car.xml").toString(), "--out", out.toString());
        assertThat(imported.code()).as(imported.err()).isZero();
        assertThat(imported.out()).startsWith(out + "/world.yaml: car, 7 bodies, 6 joints");
        assertThat(out.resolve("robot.yaml")).hasSameTextualContentAs(car.resolve("robot.yaml"));
    }

    @Test
    void theWalkerIsAsItIsImportedFromMjcf() throws Exception {
        Path walker = Project.WORLDS.resolve("walker");
        Path out = folder.resolve("walker");
        Outcome imported =
                Reve.run(
                        "import", walker.resolve("walker.xml").toString(), "--out", out.toString());
        assertThat(imported.code()).as(imported.err()).isZero();
        assertThat(imported.err()).isEmpty();
        assertThat(imported.out()).startsWith(out + "/world.yaml: walker, 9 bodies, 8 joints");
        assertThat(out.resolve("robot.yaml")).hasSameTextualContentAs(walker.resolve("robot.yaml"));
        // Agents perceive the joints of imported robots.
        assertThat(out.resolve("world.yaml"))
                .content()
                .contains("angle: {is: physics.jointAngle, kind: joint");
        Outcome run = Reve.run("run", out.toString(), "--seconds", "0.2");
        assertThat(run.code()).as(run.err()).isZero();
    }

    /**
     * The agent also perceives the angles of its joints. The servos follow to within a fifth of a
     * rad.
     */
    @Test
    void anAgentWalksTheWalkerAheadWithoutFalling() throws Exception {
        String summary = drive("walker", "walk.py");
        JsonNode walk = new JsonMapper().readTree(summary);
        assertThat(walk.path("rounds").asInt()).as(summary).isEqualTo(900);
        assertThat(walk.path("metres").asDouble()).as(summary).isBetween(3.0, 10.0);
        assertThat(walk.path("aside").asDouble()).as(summary).isBetween(-0.5, 0.5);
        assertThat(walk.path("lowest").asDouble()).as(summary).isGreaterThan(0.3);
        assertThat(walk.path("missed").asDouble()).as(summary).isBetween(0.001, 0.5);
    }

    private String push() throws IOException, InterruptedException {
        String summary = drive("robot-arm", "reach.py");
        JsonNode reach = new JsonMapper().readTree(summary);
        assertThat(reach.path("pushed").size()).as(summary).isEqualTo(3);
        assertThat(reach.path("rounds").asInt()).as(summary).isLessThan(600);
        return summary;
    }

    /** Runs an example against a sample world and returns its summary. */
    private String drive(String world, String example) throws IOException, InterruptedException {
        var shell = new Shell(folder);
        try (Server server =
                shell.serve(
                        "\"$REVE/reve\" serve \"$REVE/worlds/"
                                + world
                                + "\" --fast --waiting off --deadline 600")) {
            return shell.run(
                    "PYTHONPATH=\"$REVE/agents/python\" python3"
                            + " \"$REVE/agents/python/examples/"
                            + example
                            + "\" --port "
                            + server.port());
        }
    }
}
