// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.tests.Reve.Outcome;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/** Results that standard output does not accept, because of a full disk or a closed pipe. */
@Tag("slow")
class OutputIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();
    private static final int CLOSED_PIPE = 128 + 13;

    @TempDir private Path folder;

    private List<List<String>> commands() throws Exception {
        String log = folder.resolve("run.log").toString();
        String store = folder.resolve("my.db").toString();
        Reve.run("run", WORLD, "--seconds", "0.1", "--record", log);
        Reve.run("serve", WORLD, "--port", "0", "--seconds", "0.1", "--store", store);
        return List.of(
                List.of("--help"),
                List.of("--version"),
                List.of("check", WORLD),
                List.of("check", WORLD, "--json"),
                List.of("run", WORLD, "--seconds", "0.1", "--profile", "--ledger"),
                List.of("run", WORLD, "--seconds", "0.1", "--json"),
                List.of("replay", log),
                List.of("store", "check", store),
                List.of("picture", WORLD, "--out", folder.resolve("a.png").toString()),
                List.of("token", "new", "ada", "--file", folder.resolve("tokens").toString()),
                List.of("serve", WORLD, "--port", "0", "--seconds", "0.1", "--json"));
    }

    /**
     * @param script where {@code "$@"} is the command
     */
    private static Outcome shell(String script, List<String> arguments) throws Exception {
        List<String> command = new ArrayList<>(List.of("bash", "-c", script, "bash"));
        command.addAll(Reve.command(arguments.toArray(String[]::new)));
        return Reve.run(command);
    }

    @Test
    void resultsThatAFullDiskDoesNotTakeEndEachCommandWithAMessageAndCode1() throws Exception {
        for (List<String> command : commands()) {
            Outcome outcome = shell("\"$@\" > /dev/full", command);
            assertThat(outcome.code()).as("%s: %s", command, outcome.err()).isEqualTo(1);
            assertThat(outcome.err())
                    .as("%s", command)
                    .contains(
                            "reve: standard output could not "
                                    + "be written: No space left on device; results are lost");
        }
    }

    @Test
    void aReaderThatHasGoneEndsEachCommandQuietly() throws Exception {
        for (List<String> command : commands()) {
            Outcome outcome = shell("\"$@\" | true; exit ${PIPESTATUS[0]}", command);
            assertThat(outcome.code()).as("%s: %s", command, outcome.err()).isEqualTo(CLOSED_PIPE);
            if (!command.getFirst().equals("serve") && !command.getFirst().equals("token")) {
                assertThat(outcome.messages()).as("%s", command).isEmpty();
            }
        }
    }

    @Test
    void theCodeOfACommandThatFailedIsItsOwn() throws Exception {
        Path world = Files.writeString(folder.resolve("world.yaml"), "reve: 1\n");
        List<String> check = List.of("check", world.toString(), "--json");
        assertThat(shell("\"$@\" | true; exit ${PIPESTATUS[0]}", check).code()).isEqualTo(3);
        assertThat(shell("\"$@\" > /dev/full", check).code()).isEqualTo(3);
        assertThat(shell("\"$@\" >&-", List.of("check", WORLD)).code()).isEqualTo(1);
    }

    @Test
    void theCommandOfTheEngineSaysSoToo() throws Exception {
        Outcome outcome =
                Reve.run(
                        List.of(
                                "bash",
                                "-c",
                                "\"$1\" laws > /dev/full",
                                "bash",
                                Project.NATIVE.resolve("vesper").toString()));
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err())
                .contains("vesper: standard output could not be written")
                .contains("results are lost");
    }

    @Test
    void aServerGoesOnWhenTheReaderOfItsEventsHasGone() throws Exception {
        try (Server server = Server.start(folder, "serve", WORLD, "--port", "0", "--json")) {
            int port = Integer.parseInt(server.port());
            server.process().getInputStream().close();
            for (int i = 0; i < 2; i++) {
                try (AgentClient ada = Agents.join(port, Join.as("ada"))) {
                    assertThat(ada.perceive().items()).isNotEmpty();
                }
            }
            server.process().toHandle().destroy();
            assertThat(server.exitCode()).isEqualTo(CLOSED_PIPE);
        }
        assertThat(Files.readString(folder.resolve("server.err")))
                .containsOnlyOnce(
                        "reve: standard output cannot be written: Broken pipe; the worlds continue");
    }
}
