// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.core.frame.Pacing;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.RunLog;
import reve.worlds.server.Replay;
import reve.worlds.server.Simulation;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.sql.Connection;
import java.sql.ResultSet;
import java.sql.Statement;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.concurrent.TimeUnit;

import javax.imageio.ImageIO;

/** Real servers that share a database. They are killed or paused, or they lose the database. */
@Tag("slow")
class SharedStoreIT {
    private static final String NAME = "spring-orbit";
    private static final String WORLD = Project.WORLDS.resolve(NAME).toString();
    private static final long SEED = Long.getLong("reve.test.seed", 20261128);

    /** Number of kills. A long run uses 100. */
    private static final int KILLS = Integer.getInteger("reve.test.takeover.kills", 1);

    /** Number of pauses. A long run uses 100. */
    private static final int PAUSES = Integer.getInteger("reve.test.takeover.pauses", 1);

    private static Postgres postgres;
    private static int databases;

    @TempDir private Path folder;

    @BeforeAll
    static void start() throws Exception {
        postgres = new Postgres();
    }

    @AfterAll
    static void stop() throws Exception {
        postgres.close();
    }

    private String database() throws Exception {
        String name = "worlds" + ++databases;
        postgres.create(name);
        return name;
    }

    private Server serve(String world, String database, String... more) throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of(
                                "serve",
                                world,
                                "--port",
                                "0",
                                "--json",
                                "--store",
                                postgres.url(database)));
        arguments.addAll(List.of(more));
        return Server.start(folder, arguments.toArray(String[]::new));
    }

    private static JsonNode ready(Server server) throws IOException {
        return server.events().await("ready", event -> true);
    }

    private static void signal(Server server, String name) throws Exception {
        assertThat(
                        new ProcessBuilder(
                                        "kill", "-" + name, Long.toString(server.process().pid()))
                                .start()
                                .waitFor())
                .isZero();
    }

    /**
     * Paints an item again and again for a random time. Returns the last frame that an answer
     * named.
     */
    private static long act(JsonNode ready, Random random) throws IOException {
        long announced = ready.path("frame").asLong();
        long end = System.nanoTime() + TimeUnit.MILLISECONDS.toNanos(300 + random.nextInt(900));
        try (AgentClient agent = Agents.join(ready.path("agentPort").asInt(), "ada")) {
            do {
                String colour = String.format("#%06x", random.nextInt(1 << 24));
                announced =
                        Math.max(
                                announced,
                                agent.act("red", "paint", Map.of("colour", colour))
                                        .frame()
                                        .orElse(0L));
            } while (System.nanoTime() < end);
        }
        return announced;
    }

    /**
     * A server is killed. A second server takes its world when the lease has ended, and loses at
     * most one announced frame. Its state is the one that the recording of the first server gives.
     */
    @Test
    void aSecondServerContinuesTheWorldOfAKilledOne() throws Exception {
        String database = database();
        Random random = new Random(SEED);
        long announced = 0;
        for (int kill = 0; kill <= KILLS; kill++) {
            Path log = folder.resolve("run" + kill + ".log");
            String world = kill == 0 ? WORLD : NAME; // later servers have nothing but the database
            String[] recorded =
                    kill == 0 ? new String[] {"--record", log.toString()} : new String[0];
            try (Server server = serve(world, database, recorded)) {
                JsonNode ready = ready(server);
                long frame = ready.path("frame").asLong();
                String which = "kill " + kill + " of seed " + SEED;
                assertThat(ready.path("epoch").asLong()).as(which).isEqualTo(kill + 1);
                if (kill > 0) {
                    assertThat(announced - frame).as(which).isLessThanOrEqualTo(1);
                }
                if (kill == 1) {
                    assertThat(ready.path("stateHash").asString())
                            .as(which)
                            .isEqualTo(
                                    replayedHash(
                                            folder.resolve("run0.log"),
                                            frame,
                                            storedFrames(database)));
                }
                announced = act(ready, random);
                server.process().destroyForcibly().onExit().join();
            }
        }
        Outcome checked = Reve.run("store", "check", postgres.url(database), "--json");
        assertThat(checked.code()).as(checked.out() + checked.err()).isZero();
        assertThat(new JsonMapper().readTree(checked.out()).path("frame").asLong())
                .isGreaterThanOrEqualTo(announced - 1);
    }

    /**
     * A server is paused, loses its world, and continues. Nothing that it then writes is accepted.
     */
    @Test
    void aPausedServerWritesNothingAfterItsWorldWasTaken() throws Exception {
        for (int pause = 0; pause < PAUSES; pause++) {
            pausedServerWritesNothing(new Random(SEED + pause));
        }
    }

    private void pausedServerWritesNothing(Random random) throws Exception {
        String database = database();
        String old =
                "SELECT 'i', number, frame FROM reve.image WHERE epoch = 1 UNION SELECT 'f',"
                        + " image, frame FROM reve.frame WHERE epoch = 1 ORDER BY 1, 2, 3";
        try (Server first = serve(WORLD, database, "--store-every", "0.5")) {
            long announced = act(ready(first), random);
            signal(first, "STOP");
            List<String> before;
            String hash;
            try (Server second = serve(NAME, database, "--store-every", "1000")) {
                JsonNode ready = ready(second);
                assertThat(announced - ready.path("frame").asLong()).isLessThanOrEqualTo(1);
                assertThat(ready.path("epoch").asLong()).isEqualTo(2);
                act(ready, random);
                before = postgres.query(database, old);
                assertThat(before).isNotEmpty();
                signal(first, "CONT");
                JsonNode fault =
                        first.events()
                                .await(
                                        "fault",
                                        event ->
                                                event.path("message")
                                                        .asString()
                                                        .contains(" was taken by "));
                assertThat(fault.path("source").asString()).isEqualTo("store");
                assertThat(fault.path("message").asString())
                        .contains(
                                postgres.url(database) + " (" + NAME + ")",
                                ", process " + second.process().pid() + " (epoch 2)",
                                "wrote in epoch 1 and can store nothing after frame ",
                                "it stops the world");
                assertThat(first.exitCode()).isEqualTo(1);
                List<JsonNode> events = first.events().untilEnd();
                assertThat(events)
                        .filteredOn(text -> text.toString().contains(" was taken by "))
                        .as("the loss is reported once")
                        .hasSize(1);
                assertThat(events.getLast().at("/unkept/0").asString())
                        .contains("its last image could not be written; it continues from frame ");
                assertThat(postgres.query(database, old)).isEqualTo(before);
                act(ready, random); // the second server was not disturbed
                second.process().toHandle().destroy();
                JsonNode end = second.events().await("end", event -> true);
                assertThat(second.exitCode()).isZero();
                hash = end.path("stateHash").asString();
            }
            Outcome checked = Reve.run("store", "check", postgres.url(database), "--json");
            assertThat(checked.code()).as(checked.out() + checked.err()).isZero();
            assertThat(new JsonMapper().readTree(checked.out()).path("stateHash").asString())
                    .isEqualTo(hash);
        }
    }

    @Test
    void aWorldWithMeshesStartsByItsNameWithNothingLocal() throws Exception {
        String database = database();
        Path here = folder.resolve("t-handle");
        Files.createDirectory(here);
        try (var files = Files.list(Project.WORLDS.resolve("t-handle"))) {
            for (Path file : files.filter(Files::isRegularFile).toList()) {
                Files.copy(file, here.resolve(file.getFileName()));
            }
        }
        String url = postgres.url(database);
        Outcome first = serveFast(here.toString(), url, "1");
        assertThat(first.code()).as(first.err()).isZero();
        Files.move(here, folder.resolve("gone"));

        Outcome second = serveFast("t-handle", url, "1");
        assertThat(second.code()).as(second.err()).isZero();
        Outcome undisturbed =
                Reve.run(
                        "run",
                        Project.WORLDS.resolve("t-handle").toString(),
                        "--seconds",
                        "2",
                        "--json");
        Outcome checked = Reve.run("store", "check", url, "--json");
        assertThat(undisturbed.out())
                .contains(new JsonMapper().readTree(checked.out()).path("stateHash").asString());

        Outcome laws = Reve.run("store", "laws", url, "--world", "t-handle");
        assertThat(laws.code()).as(laws.err()).isZero();
        assertThat(laws.out()).contains("laws at frame ", "serve WORLD --store " + url + " --with");
        Outcome other = serveFast("t-hand", url, "1");
        assertThat(other.code()).isEqualTo(1);
        assertThat(other.err())
                .contains(
                        "there is no world file t-hand, and " + url,
                        "it has t-handle",
                        "name a world file, or a world of the database");
        Outcome repair = Reve.run("store", "repair", url);
        assertThat(repair.code()).isEqualTo(2);
        assertThat(repair.err()).contains("store repair takes a store file", "from a backup");
        assertThat(serveFast(WORLD, url, "0.1").code()).isZero();
        assertThat(Reve.run("store", "check", url).err())
                .contains("has the worlds spring-orbit, t-handle; name one with --world NAME");
        assertThat(Reve.run("store", "check", url, "--world", NAME).code()).isZero();
    }

    private static Outcome serveFast(String world, String url, String seconds) throws Exception {
        return Reve.run(
                "serve", world, "--port", "0", "--store", url, "--seconds", seconds, "--fast");
    }

    /** The server in standby needs no file of the world, and clients find it in the database. */
    @Test
    void aServerInStandbyContinuesTheWorldOfALostOne() throws Exception {
        String database = database();
        String url = postgres.url(database);
        try (Server first = serve(WORLD, database)) {
            JsonNode ready = ready(first);
            try (Server second = serve(NAME, database, "--standby")) {
                JsonNode waits = second.events().await("standby", event -> true);
                assertThat(waits.path("world").asString()).isEqualTo(NAME);
                assertThat(waits.path("epoch").asLong()).isEqualTo(1);
                assertThat(waits.path("owner").asString())
                        .endsWith(", process " + first.process().pid());
                assertThat(world(url).path("agents")).isEqualTo(ready.path("agents"));
                long announced = act(ready, new Random(SEED));
                first.process().destroyForcibly().onExit().join();

                JsonNode continued = ready(second);
                assertThat(continued.path("epoch").asLong()).isEqualTo(2);
                assertThat(announced - continued.path("frame").asLong()).isLessThanOrEqualTo(1);
                JsonNode found = world(url);
                assertThat(found.path("world").asString()).isEqualTo(NAME);
                assertThat(found.path("epoch").asLong()).isEqualTo(2);
                assertThat(found.path("running").asBoolean()).isTrue();
                assertThat(found.path("agents")).isEqualTo(continued.path("agents"));
                assertThat(act(continued, new Random(SEED)))
                        .isGreaterThan(continued.path("frame").asLong());
                second.process().toHandle().destroy();
                assertThat(second.exitCode()).isZero();
            }
        }
        assertThat(world(url).path("running").asBoolean()).isFalse();
        assertThat(Reve.run("store", "worlds", url).out())
                .startsWith(NAME + ": frame ")
                .contains(", epoch 2, run by no server")
                .doesNotContain("agents at");
    }

    private static JsonNode world(String url) throws Exception {
        Outcome listed = Reve.run("store", "worlds", url, "--json");
        assertThat(listed.code()).as(listed.err()).isZero();
        JsonNode worlds = new JsonMapper().readTree(listed.out()).path("worlds");
        assertThat(worlds).hasSize(1);
        return worlds.path(0);
    }

    @Test
    void aUrlWithAPasswordIsRefusedAndNotRepeated() throws Exception {
        Outcome refused =
                Reve.run("serve", WORLD, "--store", "postgresql://reve:secret@127.0.0.1/worlds");
        assertThat(refused.code()).isEqualTo(2);
        assertThat(refused.err())
                .contains("'--store'", "contains a password", "~/.pgpass")
                .doesNotContain("secret");
        Outcome other = Reve.run("store", "check", "mysql://reve@127.0.0.1/worlds");
        assertThat(other.code()).isEqualTo(2);
        assertThat(other.err()).contains("expected postgresql://USER@HOST:PORT/DATABASE");
    }

    @Test
    void aDatabaseThatIsNotThereIsReportedInOneLine() throws Exception {
        Outcome away = Reve.run("store", "check", "postgresql://reve@127.0.0.1:1/worlds");
        assertThat(away.code()).isEqualTo(1);
        assertThat(away.out() + away.err()).contains("see that the database runs").hasLineCount(1);
    }

    @Test
    void standbyTakesOneWorldAndADatabase() throws Exception {
        String url = "postgresql://reve@127.0.0.1/worlds";
        Outcome file = Reve.run("serve", WORLD, "--standby", "--store", "my.db");
        assertThat(file.code()).isEqualTo(2);
        assertThat(file.err()).contains("--standby takes one world and", "found --store my.db");
        Outcome several = Reve.run("serve", WORLD, WORLD, "--standby", "--store", url);
        assertThat(several.code()).isEqualTo(2);
        assertThat(several.err()).contains("found 2 worlds: start one server for each");
    }

    @Test
    void aSecondServerLeavesTheWorldOfAWorkingOneAlone() throws Exception {
        String database = database();
        try (Server first = serve(WORLD, database, "--seconds", "1000")) {
            ready(first);
            Outcome second = serveFast(WORLD, postgres.url(database), "1");
            assertThat(second.code()).isEqualTo(1);
            assertThat(second.err())
                    .contains(
                            postgres.url(database) + " (" + NAME + ") is in use by ",
                            ", process " + first.process().pid() + " (epoch 1)");
            first.process().toHandle().destroy();
            assertThat(first.exitCode()).isZero();
            assertThat(first.events().untilEnd()).noneMatch(Server::isFault);
        }
    }

    /**
     * The rule is the same as for a full disk. The world continues, and the next image makes the
     * store whole.
     */
    @Test
    void aWorldContinuesWhileTheDatabaseIsAway() throws Exception {
        String database = database();
        JsonNode end;
        try (Server server = serve(WORLD, database, "--store-every", "2")) {
            act(ready(server), new Random(SEED));
            postgres.stop();
            JsonNode fault = server.events().await("fault", Server::isFault);
            assertThat(fault.path("source").asString()).isEqualTo("store");
            assertThat(fault.path("message").asString())
                    .contains(
                            postgres.url(database) + " could not be written: ",
                            "loses the frames from ");
            act(ready(server), new Random(SEED)); // the world continued
            postgres.start();
            server.events()
                    .await(
                            "fault",
                            event ->
                                    event.path("message")
                                            .asString()
                                            .startsWith(
                                                    "the store is complete again from the image of"
                                                            + " frame "));
            server.process().toHandle().destroy();
            end = server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
        }
        Outcome checked = Reve.run("store", "check", postgres.url(database), "--json");
        assertThat(checked.code()).as(checked.out() + checked.err()).isZero();
        assertThat(new JsonMapper().readTree(checked.out()).path("stateHash").asString())
                .isEqualTo(end.path("stateHash").asString());
    }

    /**
     * The frames of two servers, of which the first one was killed, are repeated, exported and
     * shown from the database alone, also while a server runs the world.
     */
    @Test
    void whatServersWroteIsRepeatedAndShownFromTheDatabase() throws Exception {
        String database = database();
        String url = postgres.url(database);
        Random random = new Random(SEED);
        try (Server first = serve(WORLD, database, "--store-every", "1000")) {
            act(ready(first), random);
            first.process().destroyForcibly().onExit().join();
        }
        long takenOver;
        JsonNode end;
        try (Server second = serve(NAME, database, "--store-every", "1000")) {
            JsonNode ready = ready(second);
            takenOver = ready.path("frame").asLong();
            act(ready, random);
            JsonNode live = json("replay", NAME, "--store", url);
            assertThat(live.path("identical").asBoolean()).isTrue();
            assertThat(live.path("frame").asLong()).isGreaterThan(takenOver);
            second.process().toHandle().destroy();
            end = second.events().await("end", event -> true);
            assertThat(second.exitCode()).isZero();
        }
        JsonNode replay = json("replay", NAME, "--store", url);
        assertThat(replay.path("stateHash").asString()).isEqualTo(end.path("stateHash").asString());
        long last = replay.path("frame").asLong();
        JsonNode early = json("replay", NAME, "--store", url, "--until", Long.toString(takenOver));
        assertThat(early.path("frame").asLong()).isEqualTo(takenOver);

        json("export", NAME, "--store", url, "--csv", folder.resolve("csv").toString());
        List<Long> frames = frames(folder.resolve("csv/body.csv"));
        assertThat(frames.getFirst()).as("a frame of the first server").isLessThan(takenOver);
        assertThat(frames.getLast()).isEqualTo(last);
        assertThat(frames).as("no frame twice").doesNotHaveDuplicates();
        assertThat(frames).hasSize((int) (last - frames.getFirst() + 1));

        JsonNode newest = picture(url, "newest");
        assertThat(newest.path("frame").asLong()).isEqualTo(last);
        JsonNode oldest = picture(url, "oldest", "--at", "0");
        assertThat(oldest.path("frame").asLong()).isEqualTo(frames.getFirst());
        assertThat(pixels(folder.resolve("newest.png")))
                .as("the bodies have moved")
                .isNotEqualTo(pixels(folder.resolve("oldest.png")));
        Path pictures = folder.resolve("frames");
        json(
                with(
                        new String[] {"video", NAME, "--store", url, "--seconds", "0.2"},
                        "--out",
                        pictures.toString(),
                        "--size",
                        "96x64"));
        assertThat(pixels(pictures.resolve("000000.png")))
                .as("with the camera of the world in the database")
                .isEqualTo(pixels(folder.resolve("oldest.png")));
        requireRefusals(url);
    }

    private static JsonNode json(String... command) throws Exception {
        List<String> arguments = new ArrayList<>(List.of(command));
        arguments.add("--json");
        Outcome outcome = Reve.run(arguments.toArray(String[]::new));
        assertThat(outcome.code()).as(outcome.out() + outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private JsonNode picture(String url, String name, String... more) throws Exception {
        List<String> command =
                new ArrayList<>(List.of("picture", NAME, "--store", url, "--size", "96x64"));
        command.addAll(List.of("--out", folder.resolve(name + ".png").toString()));
        command.addAll(List.of(more));
        return json(command.toArray(String[]::new));
    }

    private static int[] pixels(Path picture) throws IOException {
        BufferedImage image = ImageIO.read(picture.toFile());
        int width = image.getWidth();
        return image.getRGB(0, 0, width, image.getHeight(), null, 0, width);
    }

    /** Returns the frames in which a table has its first item. */
    private static List<Long> frames(Path table) throws IOException {
        List<String> lines = Files.readAllLines(table);
        String first = lines.get(1).split(",")[2];
        return lines.stream()
                .skip(1)
                .map(line -> line.split(","))
                .filter(cells -> cells[2].equals(first))
                .map(cells -> Long.valueOf(cells[0]))
                .toList();
    }

    private void requireRefusals(String url) throws Exception {
        Outcome unknown = Reve.run("replay", "w0", "--store", url);
        assertThat(unknown.code()).isEqualTo(1);
        assertThat(unknown.err())
                .contains(url + " has no world 'w0', expected one of spring-orbit");
        Outcome file = Reve.run("replay", NAME, "--store", "my.db");
        assertThat(file.code()).isEqualTo(2);
        assertThat(file.err()).contains("--store is my.db, expected postgresql://USER@HOST:PORT/");
        String out = folder.resolve("refused.png").toString();
        String[] snapshot = {"picture", NAME, "--store", url, "--out", out};
        Outcome late = Reve.run(with(snapshot, "--at", "1e6"));
        assertThat(late.code()).isEqualTo(2);
        assertThat(late.err()).contains("--at is 1000000, but ", " s after its first state");
        Outcome sheet = Reve.run(with(snapshot, "--at", "1", "--sheet", "2x1"));
        assertThat(sheet.code()).isEqualTo(2);
        assertThat(sheet.err()).contains("--sheet runs a world from its beginning");
        Outcome camera = Reve.run(with(snapshot, "--camera", "nowhere"));
        assertThat(camera.code()).isEqualTo(2);
        assertThat(camera.err()).contains("--camera: the world has no camera `nowhere`");
    }

    private static String[] with(String[] command, String... more) {
        List<String> all = new ArrayList<>(List.of(command));
        all.addAll(List.of(more));
        return all.toArray(String[]::new);
    }

    /** Returns the hash of a recorded run at a frame; the last frame may be only in the store. */
    private static String replayedHash(Path log, long frame, Map<Long, JournalRecord> stored)
            throws IOException {
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader recorded = RunLog.open(log)) {
            boolean going = true;
            while (going && recorded.hasNext()) {
                going = replay.take(recorded.next(), frame);
            }
            while (going && replay.frame() < frame) {
                going = replay.take(stored.get(replay.frame() + 1), frame);
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation replayed = replay.release()) {
                assertThat(replayed.loop().frame()).isEqualTo(frame);
                return String.format("%016x", replayed.physics().stateHash());
            }
        }
    }

    private static Map<Long, JournalRecord> storedFrames(String database) throws Exception {
        Map<Long, JournalRecord> frames = new HashMap<>();
        try (Connection connection = postgres.connect(database);
                Statement statement = connection.createStatement();
                ResultSet rows =
                        statement.executeQuery(
                                "SELECT frame, bytes FROM reve.frame WHERE epoch = 1")) {
            while (rows.next()) {
                frames.put(
                        rows.getLong(1),
                        new JournalRecord.Frame(rows.getLong(1), rows.getBytes(2)));
            }
        }
        return frames;
    }
}
