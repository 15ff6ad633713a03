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

/** The command {@code import}, and {@code worlds/robot-arm}: a robot that an agent drives. */
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

    private String push() throws IOException, InterruptedException {
        var shell = new Shell(folder);
        try (Server server =
                shell.serve(
                        "\"$REVE/reve\" serve \"$REVE/worlds/robot-arm\" --fast --waiting off")) {
            String summary =
                    shell.run(
                            "PYTHONPATH=\"$REVE/agents/python\" python3"
                                    + " \"$REVE/agents/python/examples/reach.py\" --port "
                                    + server.port());
            JsonNode reach = new JsonMapper().readTree(summary);
            assertThat(reach.path("pushed").size()).as(summary).isEqualTo(3);
            assertThat(reach.path("rounds").asInt()).as(summary).isLessThan(600);
            return summary;
        }
    }
}
