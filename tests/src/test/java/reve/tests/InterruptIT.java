// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import tools.jackson.databind.JsonNode;

import java.io.BufferedReader;
import java.io.IOException;
import java.net.InetAddress;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;

/**
 * Ctrl-C and SIGTERM end a server after its frame. It prints its report and ends with exit code 0.
 */
class InterruptIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();

    @TempDir private Path folder;

    @ParameterizedTest
    @ValueSource(strings = {"INT", "TERM"})
    void aSignalEndsTheServerCleanlyAndTellsItsAgents(String signal) throws Exception {
        try (Server server = Server.start(folder, "serve", WORLD, "--port", "0", "--json")) {
            JsonNode ready = server.events().await("ready", line -> true);
            try (Socket agent =
                    new Socket(InetAddress.getLoopbackAddress(), ready.get("agentPort").asInt())) {
                agent.setSoTimeout(300_000);
                send(agent, "{\"t\":\"hello\",\"protocol\":1,\"name\":\"ada\"}\n");
                server.events().await("joined", line -> true);
                signal(server, signal);
                JsonNode end = server.events().await("end", line -> true);
                assertThat(end.get("frames").asLong()).isPositive();
                assertThat(server.exitCode()).isZero();
                assertThat(
                                new String(
                                        agent.getInputStream().readAllBytes(),
                                        StandardCharsets.UTF_8))
                        .contains("{\"t\":\"bye\"")
                        .contains("closing");
            }
        }
    }

    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void aSignalEndsALongRunWithItsReport() throws Exception {
        Process run =
                new ProcessBuilder(
                                Reve.command(
                                        "run",
                                        WORLD,
                                        "--seconds",
                                        "1e6",
                                        "--real-time",
                                        "--save",
                                        folder.resolve("saved.yaml").toString()))
                        .start();
        BufferedReader errors = run.errorReader();
        String line = errors.readLine();
        while (!line.startsWith("frame ")) { // the first progress line shows that the loop runs
            line = errors.readLine();
        }
        assertThat(new ProcessBuilder("kill", "-INT", Long.toString(run.pid())).start().waitFor())
                .isZero();
        String out = new String(run.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        assertThat(run.waitFor()).isEqualTo(130);
        assertThat(errors.lines()).anyMatch(said -> said.startsWith("reve: cut short after "));
        assertThat(out).contains("spring-orbit:").contains("state hash");
        assertThat(Reve.run("check", folder.resolve("saved.yaml").toString()).code()).isZero();
        assertThat(folder).isDirectoryNotContaining("glob:**.part*");
    }

    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void aSignalEndsAnExperimentWhichThenWritesNothing() throws Exception {
        Files.copy(Path.of(WORLD, "world.yaml"), folder.resolve("world.yaml"));
        Path file =
                Files.writeString(
                        folder.resolve("long.yaml"),
                        """
                        experiment: 1
                        name: long
                        world: world.yaml
                        seconds: 1e7
                        measures: {energy: {energy: kinetic}}
                        """);
        Path out = folder.resolve("out");
        Process run =
                new ProcessBuilder(
                                Reve.command(
                                        "experiment", file.toString(), "--out", out.toString()))
                        .start();
        BufferedReader errors = run.errorReader();
        String line = errors.readLine();
        while (!line.startsWith("0 of 1 runs")) { // the progress shows that the run is under way
            line = errors.readLine();
        }
        assertThat(new ProcessBuilder("kill", "-INT", Long.toString(run.pid())).start().waitFor())
                .isZero();
        assertThat(run.waitFor()).isEqualTo(130);
        assertThat(errors.lines())
                .anyMatch(
                        said ->
                                said.startsWith(
                                        "reve: cut short after 0 of 1 runs; nothing was written"));
        assertThat(out).isEmptyDirectory();
    }

    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void aSignalKeepsTheFinishedRunsOfAnExperiment() throws Exception {
        Files.copy(Path.of(WORLD, "world.yaml"), folder.resolve("world.yaml"));
        Path file =
                Files.writeString(
                        folder.resolve("long.yaml"),
                        """
                        experiment: 1
                        name: long
                        world: world.yaml
                        seconds: "{t}"
                        sweep: {t: [0.1, 1e7]}
                        measures: {energy: {energy: kinetic}}
                        """);
        Path out = folder.resolve("out");
        Process run =
                new ProcessBuilder(
                                Reve.command(
                                        "experiment", file.toString(), "--out", out.toString()))
                        .start();
        BufferedReader errors = run.errorReader();
        String line = errors.readLine();
        while (!line.startsWith("1 of 2 runs")) {
            line = errors.readLine();
        }
        assertThat(new ProcessBuilder("kill", "-INT", Long.toString(run.pid())).start().waitFor())
                .isZero();
        assertThat(run.waitFor()).isEqualTo(130);
        Path journal = out.resolve("unfinished.jsonl");
        assertThat(errors.lines())
                .contains(
                        "reve: cut short after 1 of 2 runs; "
                                + journal
                                + " contains 1 of them, and the same command continues");
        assertThat(out).isDirectoryContaining(journal::equals);
    }

    private static void signal(Server server, String name)
            throws IOException, InterruptedException {
        assertThat(
                        new ProcessBuilder(
                                        "kill", "-" + name, Long.toString(server.process().pid()))
                                .start()
                                .waitFor())
                .isZero();
    }

    private static void send(Socket socket, String line) throws IOException {
        socket.getOutputStream().write(line.getBytes(StandardCharsets.UTF_8));
    }
}
