// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
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
import java.nio.file.attribute.BasicFileAttributes;
import java.util.ArrayList;
import java.util.List;

/** Real servers whose store is on a disk that fails. */
@Tag("slow")
class DiskFaultIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();

    /**
     * Maximum size of each file [KiB]. A law library is smaller than this, and the frames of 300 s
     * are larger.
     */
    private static final int LIMIT = 1200;

    @TempDir private Path folder;
    private Path store;

    @BeforeEach
    void name() {
        store = folder.resolve("my.db");
    }

    @Test
    void aWorldGoesOnWithoutRoomOnItsDiskAndIsKeptAgainFromTheNextImageOn() throws Exception {
        JsonNode end;
        try (Server server = limited("--store-every", "150", "--seconds", "160")) {
            JsonNode fault = server.events().await("fault", event -> true);
            assertThat(fault.path("source").asString()).isEqualTo("store");
            assertThat(fault.path("message").asString())
                    .contains(store + "-frames-1", "could not be written: File too large");
            server.events()
                    .await(
                            "fault",
                            event ->
                                    event.path("message")
                                            .asString()
                                            .equals(
                                                    "the store is complete again from the image of"
                                                            + " frame 9000 on"));
            end = server.events().await("end", event -> true);
            assertThat(end.path("frames").asLong()).isEqualTo(160 * 60);
            assertThat(server.exitCode()).isZero();
        }
        JsonNode resumed = resumed();
        assertThat(resumed.path("frame").asLong()).isEqualTo(160 * 60);
        assertThat(resumed.path("stateHash").asString())
                .isEqualTo(end.path("stateHash").asString());
    }

    @Test
    void aCrashBeforeTheNextImageCostsWhatWasSaidAndNoMore() throws Exception {
        String fault;
        try (Server server = limited("--store-every", "10000")) {
            fault = server.events().await("fault", event -> true).path("message").asString();
        }
        JsonNode resumed = resumed();
        long frame = resumed.path("frame").asLong();
        assertThat(frame).isPositive();
        assertThat(fault).endsWith("loses the frames from " + (frame + 1) + " on");
        Outcome undisturbed =
                Reve.run("run", WORLD, "--seconds", Double.toString(frame / 60.0), "--json");
        assertThat(undisturbed.out())
                .contains("\"frames\" : " + frame, resumed.path("stateHash").asString());
    }

    @Test
    void aServerWhoseLastImageDoesNotFitFailsAndSaysWhatItsStoreContinuesFrom() throws Exception {
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--store",
                        store.toString())) {
            server.port();
            Path frames = Path.of(store + "-frames-1");
            while (!Files.exists(frames) || Files.size(frames) < 10_000) { // the image is kept
                pause(server);
            }
            String pid = String.valueOf(server.process().pid());
            assertThat(new ProcessBuilder("prlimit", "--pid", pid, "--fsize=64").start().waitFor())
                    .isZero();
            server.events()
                    .await(
                            "fault",
                            event ->
                                    event.path("message")
                                            .asString()
                                            .contains("loses the frames from"));
            server.process().toHandle().destroy();
            JsonNode fault =
                    server.events()
                            .await(
                                    "fault",
                                    event ->
                                            event.path("message")
                                                    .asString()
                                                    .contains(
                                                            "its last image could not be written"));
            JsonNode end = server.events().await("end", event -> true);
            assertThat(server.exitCode()).isEqualTo(1);
            String message = fault.path("message").asString();
            assertThat(end.at("/unkept/0").asString()).isEqualTo(message);
            long resumed = resumed().path("frame").asLong();
            assertThat(message)
                    .startsWith(store + ": ")
                    .contains(
                            "continues from frame "
                                    + resumed
                                    + ", frames "
                                    + (resumed + 1)
                                    + " to "
                                    + end.path("frames").asLong());
        }
    }

    @Test
    void aRunWhoseRecordingDoesNotFitOnTheDiskFails() throws Exception {
        Path recording = folder.resolve("run.log");
        Outcome outcome =
                Reve.run(
                        limited(
                                Reve.command(
                                        "run",
                                        WORLD,
                                        "--seconds",
                                        "160",
                                        "--record",
                                        recording.toString())));
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(1);
        assertThat(outcome.err()).contains("reve: recording: " + recording, "File too large");
        assertThat(outcome.out()).contains("state hash");
    }

    @Test
    void aWorldThatDoesNotFitOnTheDiskIsNotSavedAndTheMessageNamesTheFile() throws Exception {
        Path world = folder.resolve("many.yaml");
        Files.writeString(
                world,
                """
                reve: 1
                name: many
                laws: [newton_motion]
                items:
                  - name: ball-{i}
                    repeat: {i: 30000}
                    physical: {shape: sphere, radius: 0.1, location: ["{i}", 0, 0]}
                    physics: {mass: 1}
                """);
        Path saved = folder.resolve("saved.yaml");
        Outcome outcome =
                Reve.run(
                        limited(
                                Reve.command(
                                        "run",
                                        world.toString(),
                                        "--seconds",
                                        "0",
                                        "--save",
                                        saved.toString())));
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(1);
        assertThat(outcome.err()).contains("reve: " + saved + ": File too large");
        assertThat(saved).doesNotExist();
        assertThat(folder.resolve("saved.yaml.part")).doesNotExist();
    }

    @Test
    void aRecordingGoesOnInAnotherFileWhenThereIsRoomAgain() throws Exception {
        Path recording = folder.resolve("run.log");
        Path part = folder.resolve("run.log.1");
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--record",
                        recording.toString())) {
            server.port();
            awaitGrowth(recording, server);
            limit(server, "64:");
            assertThat(server.events().await("fault", Server::isFault).path("message").asString())
                    .startsWith(
                            recording
                                    + " could not be written: File too large; the frames "
                                    + "from")
                    .endsWith("on are not recorded, until a new recording can " + "begin");
            while (!Files.exists(part)) {
                pause(server);
            }
            limit(server, "unlimited:");
            assertThat(
                            server.events()
                                    .await(
                                            "fault",
                                            event ->
                                                    event.path("message")
                                                            .asString()
                                                            .startsWith("a new recording"))
                                    .path("message")
                                    .asString())
                    .startsWith("a new recording begins with frame ")
                    .contains(
                            " in " + recording + ", the recording before it is " + part,
                            "are not recorded");
            server.process().toHandle().destroy();
            JsonNode end = server.events().await("end", event -> true);
            assertThat(end.at("/gaps/0").asString())
                    .startsWith(recording + ": ")
                    .endsWith("are not recorded");
            assertThat(server.exitCode()).isEqualTo(1);
        }
        assertThat(folder.resolve("run.log.2")).doesNotExist();
        for (Path each : List.of(part, recording)) {
            assertThat(Reve.run("replay", each.toString()).out()).startsWith("identical: ");
        }
    }

    /**
     * Waits until the file has grown by some frames. Libraries and an image need a few writes, and
     * each frame needs one.
     */
    private static void awaitGrowth(Path file, Server server) throws Exception {
        long last = Files.size(file);
        for (int grown = 0; grown < 30; ) {
            long size = Files.size(file);
            grown += size > last ? 1 : 0;
            last = size;
            pause(server);
        }
    }

    /** Waits a little for something that the server does. */
    private static void pause(Server server) throws InterruptedException {
        assertThat(server.process().isAlive()).as("the server is running").isTrue();
        Thread.sleep(5);
    }

    /** Sets another maximum size of the files of the server [bytes]. */
    private static void limit(Server server, String bytes) throws Exception {
        assertThat(
                        new ProcessBuilder(
                                        "prlimit",
                                        "--pid",
                                        String.valueOf(server.process().pid()),
                                        "--fsize=" + bytes)
                                .start()
                                .waitFor())
                .isZero();
    }

    @Test
    void aRecordingEndsAtItsLimitAndTheRunGoesOn() throws Exception {
        Path recording = folder.resolve("run.log");
        JsonNode end;
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--fast",
                        "--seconds",
                        "160",
                        "--record",
                        recording.toString(),
                        "--record-limit",
                        "1")) {
            JsonNode fault = server.events().await("fault", event -> true);
            assertThat(fault.path("source").asString()).isEqualTo("recording");
            assertThat(fault.path("message").asString())
                    .contains(
                            recording.toString(),
                            "has its limit of 1048576 bytes; the recording ends before frame ");
            end = server.events().await("end", event -> true);
            assertThat(end.path("frames").asLong()).isEqualTo(160 * 60);
            assertThat(server.exitCode()).isZero();
        }
        assertThat(recording).isRegularFile();
        assertThat(Files.size(recording)).isBetween(1_000_000L, 1L << 20);
        assertThat(Reve.run("replay", recording.toString()).out()).startsWith("identical: ");
    }

    @Test
    void agentsGoOnWhenTheAuditDiskIsFullAndTheGapIsReported() throws Exception {
        try (Server server =
                Server.start(
                        folder, "serve", WORLD, "--port", "0", "--json", "--audit", "/dev/full")) {
            int port = Integer.parseInt(server.port());
            try (AgentClient ada = Agents.join(port, Join.as("ada"))) {
                assertThat(ada.perceive().items()).isNotEmpty();
            }
            JsonNode fault = server.events().await("fault", event -> true);
            assertThat(fault.path("source").asString()).isEqualTo("audit");
            assertThat(fault.path("message").asString())
                    .contains("/dev/full", "No space left on device", "without a record");
            new ProcessBuilder("kill", "-TERM", String.valueOf(server.process().pid()))
                    .start()
                    .waitFor();
            JsonNode end = server.events().await("end", event -> true);
            assertThat(end.at("/agents/unrecorded").asLong()).isPositive();
            assertThat(server.exitCode()).isEqualTo(1);
        }
    }

    @Test
    void filesOfAStoreAreWrittenOverByNothingElse() throws Exception {
        String[] serve = {
            "serve", WORLD, "--port", "0", "--fast", "--seconds", "0.2", "--store", store.toString()
        };
        assertThat(Reve.run(serve).code()).isZero();
        byte[] before = Files.readAllBytes(store);
        for (String option : List.of("--record", "--audit")) {
            for (String file : List.of(store.toString(), store + "-manifest")) {
                List<String> command = new ArrayList<>(List.of(serve));
                command.addAll(List.of(option, file));
                Outcome outcome = Reve.run(command.toArray(String[]::new));
                assertThat(outcome.code()).as(outcome.err()).isEqualTo(2);
                assertThat(outcome.err()).contains(option + " " + file + " is a file of --store");
            }
        }
        Path other = folder.resolve("other.yaml");
        Files.writeString(other, "reve: 1\nname: other\n");
        Path stores = folder.resolve("stores");
        Path audit = stores.resolve("other.db-manifest");
        Outcome ofFolder =
                Reve.run(
                        "serve",
                        WORLD,
                        other.toString(),
                        "--store",
                        stores.toString(),
                        "--audit",
                        audit.toString());
        assertThat(ofFolder.code()).as(ofFolder.err()).isEqualTo(2);
        assertThat(ofFolder.err()).contains("--audit " + audit + " is a file of --store");
        Outcome alone = Reve.run("run", WORLD, "--seconds", "0.1", "--record", store.toString());
        assertThat(alone.code()).isEqualTo(1);
        assertThat(alone.err()).contains(store + " is there already and holds no recording");
        Outcome saved = Reve.run("run", WORLD, "--seconds", "0.1", "--save", store.toString());
        assertThat(saved.code()).isEqualTo(2);
        assertThat(saved.err()).contains("--save " + store + ": exists and is not a world file");
        Path pack = folder.resolve("p.reve");
        assertThat(Reve.run("pack", WORLD, "--out", pack.toString()).code()).isZero();
        byte[] packed = Files.readAllBytes(pack);
        Outcome overPack = Reve.run("run", WORLD, "--seconds", "0.1", "--save", pack.toString());
        assertThat(overPack.code()).isEqualTo(2);
        assertThat(overPack.err()).contains("--save " + pack + ": exists and is not a world file");
        assertThat(pack).hasBinaryContent(packed);
        Outcome drawn = Reve.run("picture", WORLD, "--out", store.toString());
        assertThat(drawn.code()).isEqualTo(2);
        assertThat(drawn.err()).contains("--out " + store + ": exists and is not a PNG picture");
        assertThat(Files.readAllBytes(store)).isEqualTo(before);
    }

    @Test
    void aStoreThatIsRemovedIsMadeAnew() throws Exception {
        JsonNode end;
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--store",
                        store.toString(),
                        "--store-every",
                        "0.2")) {
            server.port();
            Files.delete(store);
            assertThat(server.events().await("fault", Server::isFault).path("message").asString())
                    .contains(store + " was removed; it was created again");
            server.process().toHandle().destroy();
            end = server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
        }
        assertThat(resumed().path("stateHash").asString())
                .isEqualTo(end.path("stateHash").asString());
    }

    @Test
    void placesThatNothingCanBeWrittenToAreRefusedByNameAndReason() throws Exception {
        Path nowhere = folder.resolve("none/my.db");
        refused("serve", "--store", nowhere, "there is no folder " + nowhere.getParent());
        refused("serve", "--store", folder, "is a folder, expected a file");
        refused("run", "--record", nowhere, "there is no folder " + nowhere.getParent());
        refused("run", "--record", Path.of("/dev/full"), "No space left on device");
    }

    @Test
    void pipesAndDevicesAreRefusedWhereAFileIsToStand() throws Exception {
        Path pipe = folder.resolve("pipe");
        assertThat(new ProcessBuilder("mkfifo", pipe.toString()).start().waitFor()).isZero();

        refused("run", "--record", pipe, "is a pipe, expected a file");
        refused("run", "--save", pipe, "is a device or a pipe, expected a file");
        refused("picture", "--out", pipe, "is a device or a pipe, expected a file");

        assertThat(Files.readAttributes(pipe, BasicFileAttributes.class).isOther()).isTrue();
    }

    @Test
    void whatIsSavedThroughALinkLeavesTheLink() throws Exception {
        Path saved = folder.resolve("saved.yaml");
        Path link = Files.createSymbolicLink(folder.resolve("link.yaml"), Files.createFile(saved));

        assertThat(Reve.run("run", WORLD, "--seconds", "0", "--save", link.toString()).code())
                .isZero();

        assertThat(link).isSymbolicLink();
        assertThat(saved).isNotEmptyFile();
    }

    private static void refused(String command, String option, Path file, String reason)
            throws Exception {
        Outcome outcome = Reve.run(command, WORLD, option, file.toString());
        assertThat(outcome.code()).as(outcome.err()).isNotZero();
        assertThat(outcome.err()).contains(file.toString(), reason).doesNotContain("\tat ");
    }

    /** Returns a command for which the disk is full as soon as a file has the size of the limit. */
    private static List<String> limited(List<String> command) {
        List<String> limited =
                new ArrayList<>(
                        List.of("bash", "-c", "ulimit -f " + LIMIT + " && exec \"$@\"", "bash"));
        limited.addAll(command);
        return limited;
    }

    /** Starts a server for which the disk is full as soon as a file has the size of the limit. */
    private Server limited(String... options) throws IOException {
        List<String> command =
                limited(
                        Reve.command(
                                "serve",
                                WORLD,
                                "--port",
                                "0",
                                "--json",
                                "--fast",
                                "--store",
                                store.toString()));
        command.addAll(List.of(options));
        Path errors = folder.resolve("server.err");
        Process process = new ProcessBuilder(command).redirectError(errors.toFile()).start();
        return new Server(process, new Server.Events(process, errors));
    }

    /** Returns the report of a server that resumes from the store. */
    private JsonNode resumed() throws IOException {
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--store",
                        store.toString())) {
            return server.events().await("ready", event -> true);
        }
    }
}
