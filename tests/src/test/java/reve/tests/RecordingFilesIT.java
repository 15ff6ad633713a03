// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/** Files of long-running servers and runs: restarts, second servers, and moved files. */
@Tag("slow")
class RecordingFilesIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();

    @TempDir private Path folder;

    private Server serve(String... options) throws IOException {
        List<String> command = new ArrayList<>(List.of("serve", WORLD, "--port", "0", "--json"));
        command.addAll(List.of(options));
        return Server.start(folder, command.toArray(String[]::new));
    }

    private static Outcome serveToEnd(String option, Path file) throws Exception {
        return Reve.run(
                "serve",
                WORLD,
                "--port",
                "0",
                "--json",
                "--seconds",
                "0.1",
                option,
                file.toString());
    }

    private static void replays(Path recording) throws Exception {
        Outcome outcome = Reve.run("replay", recording.toString());
        assertThat(outcome.out()).as(outcome.err()).contains("identical: ");
    }

    /** Changes the world, so that a recording contains more than its image. */
    private static void join(Server server) throws Exception {
        try (AgentClient ada = Agents.join(Integer.parseInt(server.port()), Join.as("ada"))) {
            ada.perceive();
        }
    }

    @Test
    void aServerThatIsKilledAndStartedAgainKeepsTheRecordingOfTheCrash() throws Exception {
        Path log = folder.resolve("run.log");
        Path crash = folder.resolve("run.log.1");
        try (Server server = serve("--record", log.toString())) {
            join(server);
            assertThat(server.events().await("ready", any -> true).has("olderRecording")).isFalse();
            server.process().destroyForcibly().waitFor();
        }
        byte[] recorded = Files.readAllBytes(log);
        try (Server server = serve("--record", log.toString(), "--record-keep", "2")) {
            JsonNode ready = server.events().await("ready", any -> true);
            assertThat(ready.path("olderRecording").asString()).isEqualTo(crash.toString());
            join(server);
            server.process().destroyForcibly().waitFor();
        }
        assertThat(Files.readAllBytes(crash)).isEqualTo(recorded);
        for (int i = 0; i < 2; i++) {
            assertThat(
                            Reve.run(
                                            "serve",
                                            WORLD,
                                            "--port",
                                            "0",
                                            "--seconds",
                                            "0.1",
                                            "--record",
                                            log.toString(),
                                            "--record-keep",
                                            "2")
                                    .code())
                    .isZero();
        }
        assertThat(folder.resolve("run.log.2")).isRegularFile();
        assertThat(folder.resolve("run.log.3")).doesNotExist();
        replays(log);
        replays(crash);
    }

    @Test
    void aRunMovesAnOlderRecordingAwayAndSaysWhere() throws Exception {
        Path log = folder.resolve("run.log");
        assertThat(Reve.run("run", WORLD, "--seconds", "1", "--record", log.toString()).err())
                .doesNotContain("is now");
        Outcome second = Reve.run("run", WORLD, "--seconds", "2", "--record", log.toString());
        assertThat(second.err())
                .contains("reve: the recording that was in " + log + " is now " + log + ".1");
        assertThat(Reve.run("replay", log + ".1").out()).startsWith("identical: 60 frames");
        assertThat(Reve.run("replay", log.toString()).out()).startsWith("identical: 120 frames");
    }

    @Test
    void aStartThatFailsBeforeItsFirstFrameMovesNothing() throws Exception {
        Path log = folder.resolve("run.log");
        try (Server server = serve()) {
            for (int i = 0; i < 2; i++) {
                Outcome refused =
                        Reve.run(
                                "serve",
                                WORLD,
                                "--port",
                                server.port(),
                                "--record",
                                log.toString());
                assertThat(refused.code()).isEqualTo(5);
            }
        }
        assertThat(log).isRegularFile();
        assertThat(folder.resolve("run.log.1")).doesNotExist();
    }

    @Test
    void aRecordingStaysIfItCannotBeMovedAndWhatIsNoRecordingIsNotReplaced() throws Exception {
        Path log = folder.resolve("run.log");
        String[] run = {
            "run", WORLD, "--seconds", "1", "--record", log.toString(), "--record-keep", "1"
        };
        assertThat(Reve.run(run).code()).isZero();
        byte[] recorded = Files.readAllBytes(log);
        Path older = Files.writeString(folder.resolve("run.log.1"), "a letter to a friend");

        Outcome refused = Reve.run(run);
        assertThat(refused.code()).isEqualTo(1);
        assertThat(refused.err()).contains(older + " is there already and holds no recording");

        Files.delete(older);
        Files.createDirectories(older.resolve("full"));
        Outcome blocked = Reve.run(run);
        assertThat(blocked.code()).isEqualTo(1);
        assertThat(blocked.err()).contains(log.toString(), "could not be moved to " + older);
        assertThat(Files.readAllBytes(log)).isEqualTo(recorded);
    }

    @Test
    void noFileIsNamedAsAnOlderOneOfAnotherOption() throws Exception {
        Path log = folder.resolve("run");
        for (List<String> options :
                List.of(
                        List.of("--record", log.toString(), "--audit", log + ".1"),
                        List.of("--store", log + ".2", "--audit", log.toString()))) {
            List<String> command = new ArrayList<>(List.of("serve", WORLD, "--port", "0"));
            command.addAll(options);
            Outcome refused = Reve.run(command.toArray(String[]::new));
            assertThat(refused.code()).isEqualTo(2);
            assertThat(refused.err()).contains("give each a file of its own");
        }
    }

    @Test
    void noAuditRecordIsAddedToAFileOfAnotherKind() throws Exception {
        Path tokens = folder.resolve("tokens.json");
        Path world = Files.copy(Path.of(WORLD, "world.yaml"), folder.resolve("world.yaml"));
        Path key = Files.writeString(folder.resolve("server.key"), "-----BEGIN PRIVATE KEY-----");
        Path link = Files.createSymbolicLink(folder.resolve("link"), world);
        assertThat(Reve.run("token", "new", "ada", "--file", tokens.toString()).code()).isZero();
        for (Path file : List.of(tokens, world, key, link)) {
            String before = Files.readString(file);
            Outcome refused =
                    Reve.run(
                            "serve",
                            world.toString(),
                            "--port",
                            "0",
                            "--seconds",
                            "0.1",
                            "--tokens",
                            tokens.toString(),
                            "--audit",
                            file.toString());
            assertThat(refused.code()).as(refused.err()).isEqualTo(file.equals(key) ? 1 : 2);
            assertThat(refused.err())
                    .contains(
                            file.toString(),
                            file.equals(key)
                                    ? "holds something else than an audit record"
                                    : "give each a file of its own");
            assertThat(Files.readString(file)).isEqualTo(before);
        }
        Files.writeString(tokens, Files.readString(tokens) + "{}");
        Outcome damaged = Reve.run("token", "list", "--file", tokens.toString());
        assertThat(damaged.err())
                .contains(tokens + " is no file of tokens: it is not JSON: line ")
                .doesNotContain("Jackson", "Deserialization", "JsonToken");
    }

    @Test
    void aSecondServerOnARecordingOrAnAuditFileIsRefusedAndTheFirstGoesOn() throws Exception {
        Path log = folder.resolve("run.log");
        Path audit = folder.resolve("audit.jsonl");
        try (Server server = serve("--record", log.toString(), "--audit", audit.toString())) {
            join(server);
            for (Outcome second :
                    List.of(
                            serveToEnd("--record", log),
                            Reve.run("run", WORLD, "--record", log.toString()),
                            serveToEnd("--audit", audit))) {
                assertThat(second.code()).isEqualTo(1);
                assertThat(second.err())
                        .contains(
                                "could not be opened: it is in use by another "
                                        + "process; end that one first, or name another file");
            }
            join(server);
            server.process().toHandle().destroy();
            server.events().await("end", any -> true);
            assertThat(server.exitCode()).isZero();
        }
        replays(log);
        assertThat(Files.readString(audit)).contains("\"welcome\"").endsWith("}\n");
        assertThat(serveToEnd("--record", log).code()).isZero();
        assertThat(serveToEnd("--audit", audit).code()).isZero();
    }

    @Test
    void aRecordingThatIsMovedBeginsAnewAndBothPartsReplay() throws Exception {
        Path log = folder.resolve("run.log");
        Path moved = folder.resolve("moved.log");
        try (Server server = serve("--record", log.toString())) {
            join(server);
            Files.move(log, moved);
            JsonNode fault = server.events().await("fault", Server::isFault);
            assertThat(fault.path("source").asString()).isEqualTo("recording");
            assertThat(fault.path("message").asString())
                    .startsWith(log + " was moved or removed; " + "a new recording begins there");
            join(server);
            server.process().toHandle().destroy();
            server.events().await("end", any -> true);
        }
        assertThat(Files.readString(folder.resolve("server.err")))
                .contains("recording: " + log + " was moved or removed");
        replays(moved);
        replays(log);
    }

    @Test
    void aRecordingThatCannotBeginAnewIsReportedAndBeginsWhenItCan() throws Exception {
        Path place = Files.createDirectory(folder.resolve("place"));
        Path log = place.resolve("run.log");
        try (Server server = serve("--record", log.toString())) {
            join(server);
            Files.move(place, folder.resolve("elsewhere"));
            JsonNode fault = server.events().await("fault", Server::isFault);
            assertThat(fault.path("message").asString())
                    .contains(
                            log + " was moved or removed, and no new recording can begin there",
                            "there is no folder " + place);
            Files.createDirectory(place);
            server.events()
                    .await(
                            "fault",
                            any ->
                                    any.path("message")
                                            .asString()
                                            .contains("a new recording begins there"));
            join(server);
            server.process().toHandle().destroy();
            server.events().await("end", any -> true);
        }
        replays(log);
        replays(folder.resolve("elsewhere/run.log"));
    }

    @Test
    void aRunWhoseRecordingIsRemovedFails() throws Exception {
        Path log = folder.resolve("run.log");
        Process run =
                new ProcessBuilder(
                                Reve.command(
                                        "run",
                                        WORLD,
                                        "--seconds",
                                        "1e6",
                                        "--real-time",
                                        "--record",
                                        log.toString()))
                        .redirectErrorStream(true)
                        .start();
        try (var output = run.inputReader()) {
            String line = output.readLine();
            while (!line.startsWith("frame ")) {
                line = output.readLine();
            }
            Files.delete(log);
            run.toHandle().destroy();
            assertThat(output.lines())
                    .anyMatch(
                            each ->
                                    each.startsWith(
                                            "reve: recording: " + log + " was moved or removed"));
        }
        assertThat(run.waitFor()).isEqualTo(1);
    }

    /** The shell does this with `> FILE`, and logrotate does it with copytruncate. */
    @Test
    void aRecordingThatIsCutBeginsAnew() throws Exception {
        Path log = folder.resolve("run.log");
        Path audit = folder.resolve("audit.jsonl");
        Path copy = folder.resolve("copy.log");
        try (Server server = serve("--record", log.toString(), "--audit", audit.toString())) {
            join(server);
            Files.copy(log, copy);
            Files.write(log, new byte[0]);
            Files.write(audit, new byte[0]);
            for (String source : List.of("recording", "audit")) {
                JsonNode fault =
                        server.events()
                                .await(
                                        "fault",
                                        any ->
                                                Server.isFault(any)
                                                        && any.path("source")
                                                                .asString()
                                                                .equals(source));
                assertThat(fault.path("message").asString())
                        .contains(source.equals("audit") ? audit.toString() : log.toString())
                        .containsPattern(
                                "was cut to [0-9]+ of [0-9]+ bytes; a new (one|recording) begins"
                                        + " there");
            }
            join(server);
            server.process().toHandle().destroy();
            server.events().await("end", any -> true);
        }
        replays(copy);
        replays(log);
        assertThat(Files.readString(audit)).contains("\"welcome\"");
        assertThat(folder.resolve("run.log.1")).doesNotExist();
    }

    @Test
    void theStoreOfAnotherServerIsNoOlderAuditFile() throws Exception {
        Path store = folder.resolve("z.1");
        try (Server server = serve("--store", store.toString())) {
            join(server);
            Outcome refused = serveToEnd("--audit", folder.resolve("z"));
            assertThat(refused.code()).isEqualTo(1);
            assertThat(refused.err())
                    .contains(store + " is there already and holds something else than an audit");
            join(server);
        }
    }

    @Test
    void anAuditFileThatIsMovedBeginsAnew() throws Exception {
        Path audit = folder.resolve("audit.jsonl");
        Path moved = folder.resolve("moved.jsonl");
        try (Server server = serve("--audit", audit.toString())) {
            join(server);
            Files.move(audit, moved);
            JsonNode fault = server.events().await("fault", Server::isFault);
            assertThat(fault.path("source").asString()).isEqualTo("audit");
            assertThat(fault.path("message").asString())
                    .contains(audit + " was moved or removed; a new one begins there");
            join(server);
        }
        assertThat(Files.readString(moved)).contains("\"welcome\"");
        assertThat(Files.readString(audit)).contains("\"welcome\"");
    }
}
