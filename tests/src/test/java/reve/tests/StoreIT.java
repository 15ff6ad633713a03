// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.DisconnectedException;
import reve.agent.Join;
import reve.core.frame.Pacing;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.RunLog;
import reve.worlds.server.Replay;
import reve.worlds.server.Simulation;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.DirectoryStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.concurrent.atomic.AtomicLong;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/** Real servers with real agents. They are killed and resumed, recorded and replayed. */
@Tag("slow")
class StoreIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();
    private static final long SEED = Long.getLong("reve.test.seed", 20261121);

    /** Number of kills. A long run uses 200. */
    private static final int KILLS = Integer.getInteger("reve.test.kills", 6);

    /** Number of damages. A long run uses 100. */
    private static final int DAMAGES = Integer.getInteger("reve.test.served.damages", 1);

    private static final Pattern RESUMED = Pattern.compile("frame=\\d+ stateHash=[0-9a-f]{16}");

    /** Time between images [s], longer than a test. The frames of a store are then in one file. */
    private static final String NO_SECOND_IMAGE = "1000";

    @TempDir private Path folder;

    /**
     * The servers are killed at random moments. Every second kill is just after a frame was
     * announced. At most one of the frames that agents received is lost. Every resumed state equals
     * the result of a replay of the killed run's recording from its start. With {@code normal}, a
     * world may continue without a disk that is too slow, and reports this. Only then may it lose
     * more frames.
     */
    @ParameterizedTest
    @CsvSource({"full, 1", "normal, 2"})
    void aWorldThatIsKilledWhileItIsSavedGoesOnAsItWas(String durability, int share)
            throws Exception {
        Random random = new Random(SEED);
        Path store = folder.resolve("my.db");
        long announced = 0;
        long mostLost = 0;
        boolean slow = false;
        Map<Long, JournalRecord> stored = Map.of();
        int kills = KILLS / share;
        for (int kill = 0; kill <= kills; kill++) {
            String which = durability + ", kill " + kill + " of seed " + SEED;
            Path log = folder.resolve("run" + kill + ".log");
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
                            "0.3",
                            "--durability",
                            durability,
                            "--record",
                            log.toString())) {
                JsonNode ready = server.events().await("ready", event -> true);
                long frame = ready.path("frame").asLong();
                if (kill > 0) {
                    if (!slow) {
                        assertThat(announced - frame)
                                .as("frames lost by " + which)
                                .isLessThanOrEqualTo(1);
                    }
                    Path killed = folder.resolve("run" + (kill - 1) + ".log");
                    assertThat(ready.path("stateHash").asString())
                            .as(which)
                            .isEqualTo(replayedHash(killed, frame, stored));
                    Files.delete(killed);
                    mostLost = Math.max(mostLost, announced - frame);
                }
                announced = actUntilKilled(server, ready, random);
                slow =
                        server.events().untilEnd().stream()
                                .filter(event -> event.path("source").asString("").equals("store"))
                                .anyMatch(
                                        event -> event.toString().contains("the disk is too slow"));
                assertThat(slow && durability.equals("full"))
                        .as("gave up the disk: " + which)
                        .isFalse();
            }
            stored = storedFrames();
        }
        System.out.printf("%s: %d kills, %d frames lost at most%n", durability, kills, mostLost);
    }

    /**
     * This is also true while images wait for the disk, which happens often at this rate of images.
     */
    @Test
    void aWorldThatIsKilledAfterGoingBackLosesAtMostOneFrame() throws Exception {
        Random random = new Random(SEED);
        Path store = folder.resolve("my.db");
        long announced = 0;
        boolean slow = false;
        int kills = KILLS / 3;
        for (int kill = 0; kill <= kills; kill++) {
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
                            "0.05")) {
                JsonNode ready = server.events().await("ready", event -> true);
                if (!slow) {
                    assertThat(announced - ready.path("frame").asLong())
                            .as("frames lost by kill %s of seed %s", kill, SEED)
                            .isLessThanOrEqualTo(1);
                }
                announced = goBackUntilKilled(server, ready, random);
                slow =
                        server.events().untilEnd().stream()
                                .anyMatch(
                                        event -> event.toString().contains("the disk is too slow"));
            }
        }
    }

    @Test
    void whatAgentsDoIsReplayedToTheBit() throws Exception {
        Path log = folder.resolve("run.log");
        JsonNode end;
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--json",
                        "--record",
                        log.toString())) {
            JsonNode ready = server.events().await("ready", event -> true);
            String port = ready.path("agentPort").asString();
            Process python = curious(port);
            try (AgentClient agent = Agents.join(Integer.parseInt(port), "ada")) {
                Random random = new Random(SEED);
                for (int i = 0; i < 100; i++) {
                    act(agent, random);
                }
            }
            python.waitFor();
            server.process().toHandle().destroy();
            end = server.events().await("end", event -> true);
            assertThat(end.at("/agents/joined").asLong()).isEqualTo(2);
            assertThat(end.at("/agents/actsAccepted").asLong()).isGreaterThanOrEqualTo(100);
            assertThat(server.exitCode()).isZero();
        }
        Outcome replay = Reve.runAsProcess("replay", log.toString());
        assertThat(replay.code()).as(replay.out() + replay.err()).isZero();
        assertThat(replay.out())
                .contains(
                        "identical: " + end.path("frames").asLong() + " frames",
                        "state hash: " + end.path("stateHash").asString());
    }

    @Test
    void aKilledServerLeavesNothingBehindButItsStore() throws Exception {
        Path temporary = Files.createDirectory(folder.resolve("temporary"));
        Path errors = folder.resolve("server.err");
        ProcessBuilder builder =
                new ProcessBuilder(
                                Reve.command(
                                        "serve",
                                        WORLD,
                                        "--port",
                                        "0",
                                        "--json",
                                        "--store",
                                        folder.resolve("my.db").toString(),
                                        "--store-every",
                                        NO_SECOND_IMAGE))
                        .redirectError(errors.toFile());
        builder.environment().put("TMPDIR", temporary.toString());
        builder.environment().put("JDK_JAVA_OPTIONS", "-Djava.io.tmpdir=" + temporary);
        Process process = builder.start();
        try (Server server = new Server(process, new Server.Events(process, errors))) {
            try (AgentClient agent = Agents.join(Integer.parseInt(server.port()), "ada")) {
                act(agent, new Random(SEED));
            }
            server.process().destroyForcibly().onExit().join();
        }
        assertThat(temporary).isEmptyDirectory();
        try (Stream<Path> left = Files.list(folder)) {
            assertThat(left.map(file -> file.getFileName().toString()))
                    .containsOnly(
                            "temporary",
                            "server.err",
                            "my.db",
                            "my.db-wal",
                            "my.db-frames-1",
                            "my.db-manifest");
        }
    }

    @Test
    void aStoreOfAnotherWorldIsRefused() throws Exception {
        Path store = folder.resolve("my.db");
        Outcome first =
                Reve.run(
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--store",
                        store.toString(),
                        "--seconds",
                        "0.1",
                        "--fast");
        assertThat(first.code()).as(first.err()).isZero();
        Outcome other =
                Reve.run(
                        "serve",
                        Project.WORLDS.resolve("icosahedron").toString(),
                        "--port",
                        "0",
                        "--store",
                        store.toString(),
                        "--seconds",
                        "0.1",
                        "--fast");
        assertThat(other.code()).isEqualTo(1);
        assertThat(other.err())
                .contains("my.db", "is called spring-orbit", "the world file's icosahedron");
    }

    @Test
    void aStoreWithoutItsDatabaseIsRefusedAndNothingOfItIsTouched() throws Exception {
        Path store = killedStore();
        Path gone = folder.resolve("gone.db");
        Files.move(store, gone);
        Map<String, Long> left = files();

        Outcome refused = serve(store);
        assertThat(refused.code()).isEqualTo(1);
        assertThat(refused.err())
                .contains(
                        "my.db is missing, but",
                        "my.db-frames-1",
                        "belong to a store",
                        "nothing was changed")
                .doesNotContain("\tat ");
        Outcome lost = Reve.run("store", "repair", store.toString());
        assertThat(lost.code()).isEqualTo(1);
        assertThat(files()).isEqualTo(left);

        Files.move(gone, store);
        assertThat(serve(store).code()).isZero();
    }

    @Test
    void aStoreThatLostFramesIsRefusedThenCheckedAndRepaired() throws Exception {
        Path store = killedStore();
        Path frames = folder.resolve("my.db-frames-1");
        byte[] whole = Files.readAllBytes(frames);
        byte[] half = Arrays.copyOf(whole, whole.length / 2);
        Files.write(frames, half);

        Outcome refused = serve(store);
        assertThat(refused.code()).isEqualTo(1);
        assertThat(refused.err())
                .contains(
                        "my.db-frames-1 ends at frame",
                        "would be lost",
                        "./reve store repair " + store);
        Outcome checked = Reve.run("store", "check", store.toString(), "--json");
        assertThat(checked.code()).as(checked.err()).isEqualTo(1);
        JsonNode found = new JsonMapper().readTree(checked.out());
        assertThat(found.path("whole").asBoolean()).isFalse();
        assertThat(found.path("frame").asLong())
                .isPositive()
                .isLessThan(found.path("knownFrame").asLong());
        assertThat(frames).hasBinaryContent(half);
        Outcome laws = Reve.run("store", "laws", store.toString(), "--json");
        assertThat(laws.code()).as(laws.err()).isEqualTo(1);
        JsonNode listed = new JsonMapper().readTree(laws.out());
        assertThat(listed.path("frame")).isEqualTo(found.path("frame"));
        assertThat(listed.path("laws").path(0).path("kind").asString()).isEqualTo("native");
        assertThat(listed.path("laws").path(0).path("sha256").asString()).hasSize(64);
        assertThat(Reve.run("store", "laws", store.toString()).out())
                .contains(
                        listed.path("laws").path(0).path("library").asString() + ": native, ",
                        ", SHA-256 "
                                + listed.path("laws")
                                        .path(0)
                                        .path("sha256")
                                        .asString()
                                        .substring(0, 12)
                                + "…",
                        "to continue without a law: ./reve serve WORLD --store "
                                + store
                                + " --without-law NAME");
        assertThat(frames).hasBinaryContent(half);

        Outcome repaired = Reve.runAsProcess("store", "repair", store.toString());
        assertThat(repaired.code()).as(repaired.err()).isZero();
        assertThat(repaired.out()).contains("continues from frame " + found.path("frame").asLong());
        assertThat(folder.resolve("my.db.damaged-1/my.db-frames-1")).hasBinaryContent(half);
        Outcome again = Reve.run("store", "check", store.toString(), "--json");
        assertThat(again.code()).as(again.out()).isZero();
        assertThat(again.out()).contains(found.path("stateHash").asString());

        // A repair that was killed has moved the old files away, and the new ones not yet in place.
        Files.createDirectory(folder.resolve("my.db.damaged-1/repaired"));
        Files.move(store, folder.resolve("my.db.damaged-1/repaired/my.db"));
        for (String command : List.of("check", "repair")) {
            Outcome interrupted = Reve.run("store", command, store.toString());
            assertThat(interrupted.code()).isEqualTo(1);
            assertThat(interrupted.err())
                    .contains(
                            "`store repair` was interrupted",
                            "Move the files (not the folder repaired) of " + folder);
        }
    }

    /**
     * Flips bits of, truncates, empties or removes one file of a store at a time, and starts a
     * server on it.
     */
    @Test
    void aServerGoesOnAsItWasOrNamesTheDamagedFileAndLeavesItAlone() throws Exception {
        killedStore();
        Map<String, byte[]> whole = contents(folder);
        Outcome sound = serve(copy(whole, "whole"));
        List<String> names =
                whole.keySet().stream()
                        .filter(name -> whole.get(name).length > 0)
                        .sorted()
                        .toList();
        Random random = new Random(SEED);
        int wentOn = 0;
        for (int i = 0; i < DAMAGES; i++) {
            String name = names.get(i % names.size());
            Map<String, byte[]> damaged = new HashMap<>(whole);
            byte[] bytes = damaged.remove(name).clone();
            int kind = random.nextInt(8);
            if (kind == 1) {
                damaged.put(name, new byte[0]);
            } else if (kind < 4) {
                damaged.put(name, Arrays.copyOf(bytes, random.nextInt(bytes.length)));
            } else if (kind > 3) {
                bytes[random.nextInt(bytes.length)] ^= (byte) (1 << random.nextInt(8));
                damaged.put(name, bytes);
            }
            String which = "damage " + i + " of kind " + kind + " to " + name + ", seed " + SEED;
            Path store = copy(damaged, "damage" + i);
            Outcome outcome = serve(store);
            if (outcome.code() == 0) {
                wentOn++;
                assertThat(resumedAt(outcome)).as(which).isEqualTo(resumedAt(sound));
                continue;
            }
            assertThat(outcome.err()).as(which).contains(name);
            Map<String, byte[]> left = contents(store.getParent());
            assertThat(left.keySet()).as(which).isEqualTo(damaged.keySet());
            damaged.forEach(
                    (file, content) ->
                            assertThat(left.get(file)).as(which + ": " + file).isEqualTo(content));
            if (Reve.run("store", "repair", store.toString()).code() == 0) {
                assertThat(serve(store).code()).as(which + ", repaired").isZero();
            } else {
                assertThat(name).as(which + ", not repaired").isEqualTo("my.db");
            }
        }
        System.out.println("of " + DAMAGES + " damages, servers went on after " + wentOn);
    }

    private Path copy(Map<String, byte[]> files, String to) throws IOException {
        Path place = Files.createDirectory(folder.resolve(to));
        for (Map.Entry<String, byte[]> file : files.entrySet()) {
            Files.write(place.resolve(file.getKey()), file.getValue());
        }
        return place.resolve("my.db");
    }

    private static Map<String, byte[]> contents(Path place) throws IOException {
        Map<String, byte[]> contents = new HashMap<>();
        try (DirectoryStream<Path> files = Files.newDirectoryStream(place, "my.db*")) {
            for (Path file : files) {
                contents.put(file.getFileName().toString(), Files.readAllBytes(file));
            }
        }
        return contents;
    }

    /** Returns the frame and state hash from which a server resumed. */
    private static String resumedAt(Outcome served) {
        Matcher ready = RESUMED.matcher(served.out());
        assertThat(ready.find()).as(served.out()).isTrue();
        return ready.group();
    }

    /** Makes a store with one image. Its server was killed after some acts. */
    private Path killedStore() throws Exception {
        Path store = folder.resolve("my.db");
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
                                NO_SECOND_IMAGE);
                AgentClient agent = Agents.join(Integer.parseInt(server.port()), "ada")) {
            for (int i = 0; i < 10; i++) {
                act(agent, new Random(SEED + i));
            }
            server.process().destroyForcibly().onExit().join();
        }
        return store;
    }

    private static Outcome serve(Path store) throws Exception {
        return Reve.run(
                "serve",
                WORLD,
                "--port",
                "0",
                "--store",
                store.toString(),
                "--seconds",
                "0.1",
                "--fast");
    }

    /** Sizes of the files of the store, by name. */
    private Map<String, Long> files() throws IOException {
        Map<String, Long> sizes = new HashMap<>();
        try (DirectoryStream<Path> files = Files.newDirectoryStream(folder, "my.db*")) {
            for (Path file : files) {
                sizes.put(file.getFileName().toString(), Files.size(file));
            }
        }
        return sizes;
    }

    private Process curious(String port) throws IOException {
        Path agents = Project.ROOT.resolve("agents/python");
        ProcessBuilder python =
                new ProcessBuilder(
                                "python3",
                                agents.resolve("examples/curious.py").toString(),
                                "--port",
                                port,
                                "--seconds",
                                "2")
                        .redirectErrorStream(true)
                        .redirectOutput(folder.resolve("python.out").toFile());
        python.environment().put("PYTHONPATH", agents.toString());
        return python.start();
    }

    /**
     * Pushes and paints until the server is killed. Returns the last frame that a client received.
     */
    private static long actUntilKilled(Server server, JsonNode ready, Random random)
            throws Exception {
        long moment = System.nanoTime() + 50_000_000L + random.nextInt(900) * 1_000_000L;
        boolean atAnnouncement = random.nextBoolean();
        var announced = new AtomicLong(ready.path("frame").asLong());
        int port = ready.path("agentPort").asInt();
        Thread watcher = Thread.ofVirtual().start(() -> watch(port, announced));
        try (AgentClient agent = Agents.join(port, "ada")) {
            while (System.nanoTime() < moment) {
                act(agent, random)
                        .frame()
                        .ifPresent(frame -> announced.accumulateAndGet(frame, Math::max));
            }
            long before = announced.get();
            while (atAnnouncement && announced.get() == before && watcher.isAlive()) {
                Thread.onSpinWait();
            }
            server.process()
                    .toHandle()
                    .destroyForcibly(); // the server's last output can still be read
            server.process().onExit().join();
        } catch (AgentException gone) {
            assertThat(gone).isInstanceOf(DisconnectedException.class);
        }
        watcher.join();
        return announced.get();
    }

    /**
     * Rewinds and changes laws until the server is killed, which happens a few frames after a
     * rewind. Returns the last frame that was perceived.
     */
    private static long goBackUntilKilled(Server server, JsonNode ready, Random random)
            throws Exception {
        var perceived = new AtomicLong(ready.path("frame").asLong());
        int port = ready.path("agentPort").asInt();
        Thread watcher = Thread.ofVirtual().start(() -> watch(port, perceived));
        try (AgentClient boss = Agents.join(port, Join.as("boss").withRole("control"))) {
            long back = 0;
            for (int left = 10 + random.nextInt(10); left > 0; left--) {
                boss.command(
                        random.nextBoolean() ? "load-law" : "unload-law",
                        Map.of("library", "gravity_field")); // may be refused
                back = boss.command("rewind", Map.of()).frame().orElseThrow();
                awaitPerceived(perceived, back + random.nextInt(12), watcher);
            }
            awaitPerceived(perceived, back + random.nextInt(4), watcher);
            server.process()
                    .toHandle()
                    .destroyForcibly(); // the server's last output can still be read
            server.process().onExit().join();
        }
        watcher.join();
        return perceived.get();
    }

    private static void awaitPerceived(AtomicLong newest, long frame, Thread watcher) {
        while (newest.get() < frame && watcher.isAlive()) {
            Thread.onSpinWait();
        }
    }

    /** Keeps the newest perceived frame until the server ends. */
    private static void watch(int port, AtomicLong newest) {
        try (AgentClient agent = Agents.join(port, "eve")) {
            agent.perceiveEvery(1);
            while (true) {
                long frame = agent.nextPerception().frame();
                newest.accumulateAndGet(frame, Math::max);
            }
        } catch (AgentException | IOException gone) {
            // The test has ended the server.
        }
    }

    /**
     * Returns the state that the recording of a killed run gives at a frame. If the recording lacks
     * the last frames of the store, their inputs are taken from the store.
     */
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

    /** Returns the numbers of the store's frames. */
    private Map<Long, JournalRecord> storedFrames() throws IOException {
        Map<Long, JournalRecord> frames = new HashMap<>();
        try (DirectoryStream<Path> files = Files.newDirectoryStream(folder, "my.db-frames-*")) {
            for (Path file : files) {
                if (Files.size(file) == 0) {
                    continue; // the server was killed as it began this one
                }
                try (RunLog.Reader records = RunLog.open(file)) {
                    records.forEachRemaining(
                            record -> {
                                if (record instanceof JournalRecord.Frame frame) {
                                    frames.put(frame.frame(), record);
                                }
                            });
                }
            }
        }
        return frames;
    }

    private static ActResult act(AgentClient agent, Random random) {
        return random.nextInt(4) == 0
                ? agent.act(
                        "red",
                        "paint",
                        Map.of("colour", String.format("#%06x", random.nextInt(1 << 24))))
                : agent.act(
                        "blue",
                        "push",
                        Map.of(
                                "impulse",
                                List.of(
                                        random.nextGaussian(),
                                        random.nextGaussian(),
                                        random.nextGaussian())));
    }
}
