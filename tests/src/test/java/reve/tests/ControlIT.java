// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.Join;
import reve.agent.Perception;
import reve.core.agent.AgentServerConfig;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.Replay;
import reve.worlds.server.RunReport;
import reve.worlds.server.ServerReport;
import reve.worlds.server.Simulation;
import reve.worlds.server.WorldPlan;
import reve.worlds.server.WorldServer;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionException;
import java.util.concurrent.atomic.AtomicReference;

/** Commands of the role control on a world with a real engine, over the protocol. */
@Tag("slow")
class ControlIT {
    private static final Path WORLD = Project.WORLDS.resolve("spring-orbit");
    private static final double GRAVITY = -1.62;
    private static final int RATE = 60;

    private final Path folder;
    private WorldDescription description;
    private Optional<Path> recording = Optional.empty();
    private Optional<Path> store = Optional.empty();
    private List<Event> events = new ArrayList<>();

    private record Event(String type, Map<String, Object> fields) {
        boolean isFault() {
            return Server.isFault(type, String.valueOf(fields.get("message")));
        }
    }

    /** An action of an operator. */
    private interface Script {
        void run(AgentClient boss) throws Exception;
    }

    ControlIT(@TempDir Path folder) {
        this.folder = folder;
    }

    @BeforeEach
    void read() throws Exception {
        description = WorldFile.load(WORLD.resolve("world.yaml"));
    }

    @Test
    void aLawThatIsLoadedActsFromThenOnUntilItIsUnloaded() throws Exception {
        serve(
                boss -> {
                    accepted(boss, "pause", Map.of());
                    long start = accepted(boss, "rewind", Map.of());
                    double free = heightAt(boss, start + 2 * RATE);
                    start = accepted(boss, "rewind", Map.of());
                    long loaded = whileItRuns(boss, "load-law", Map.of("library", "gravity_field"));
                    heightAt(boss, start + RATE);
                    long unloaded =
                            whileItRuns(boss, "unload-law", Map.of("library", "gravity_field"));
                    double pulled = heightAt(boss, start + 2 * RATE) - free;
                    double seconds = (unloaded - loaded) / (double) RATE;
                    double coasting = (start + 2 * RATE - unloaded + 1) / (double) RATE;
                    assertThat(pulled)
                            .isCloseTo(
                                    GRAVITY * seconds * (0.5 * seconds + coasting), within(0.02));
                });
        assertThat(events)
                .extracting(Event::type)
                .contains("law-loaded", "law-unloaded", "rewound");
    }

    @Test
    void aTextActsIsReplacedAndIsReplayedToTheBit() throws Exception {
        recording = Optional.of(folder.resolve("run.log"));
        RunReport report =
                serve(
                        boss -> {
                            accepted(boss, "pause", Map.of());
                            accepted(boss, "rewind", Map.of());
                            whileItRuns(boss, "load-law", text("each body: force += mass gravity"));
                            after(boss, 5);
                            ActResult refused =
                                    boss.command("load-law", text("each body: force += velocity"));
                            assertThat(refused.code()).contains("law-refused");
                            assertThat(refused.reason().orElseThrow())
                                    .contains("fall.law:2:23: 'velocity' is a vector in m/s")
                                    .contains("  each body: force += velocity\n")
                                    .contains("^~~~~~~~");
                            whileItRuns(boss, "load-law", text("each body: force -= mass gravity"));
                            after(boss, 5);
                        });
        assertThat(events)
                .filteredOn(event -> event.type().equals("law-loaded"))
                .extracting(event -> event.fields().get("library"))
                .endsWith("fall", "fall");
        assertThat(events).noneMatch(Event::isFault);
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(recording.get())) {
            while (records.hasNext() && replay.take(records.next())) {
                // each record is made as it is read
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(report.stateHash());
            }
        }
    }

    private static Map<String, Object> text(String block) {
        return Map.of("library", "fall.law", "text", "law fall\n  " + block + "\n");
    }

    private static String reason(AgentClient boss, String command, Map<String, Object> fields) {
        return boss.command(command, fields).reason().orElseThrow();
    }

    @Test
    void aLawThatIsNotThereIsRefusedAndNothingElseHappens() throws Exception {
        serve(
                boss -> {
                    ActResult refused =
                            boss.command("load-law", Map.of("library", "perpetual_motion"));
                    assertThat(refused.code()).contains("law-refused");
                    assertThat(refused.reason().orElseThrow())
                            .startsWith("no law is called \"perpetual_motion\"; known are ")
                            .as("files of the server")
                            .doesNotContain("/");
                    assertThat(reason(boss, "load-law", Map.of("library", "gravity_feld")))
                            .isEqualTo(
                                    "no law is called \"gravity_feld\"; did you mean"
                                            + " `gravity_field`?");
                    accepted(boss, "load-law", Map.of("library", "gravity_field"));
                    for (String command : List.of("set-law", "unload-law")) {
                        Map<String, Object> wrong =
                                command.equals("set-law")
                                        ? Map.of("library", "gravity_feld", "parameters", Map.of())
                                        : Map.of("library", "gravity_feld");
                        assertThat(reason(boss, command, wrong))
                                .isEqualTo(
                                        "no library \"gravity_feld\" is loaded; did you mean"
                                                + " `gravity_field`?");
                    }
                    assertThat(reason(boss, "rewind", Map.of("image", "calm")))
                            .endsWith("; none is kept: keep one with the command snapshot");
                    accepted(boss, "snapshot", Map.of("image", "calm"));
                    assertThat(reason(boss, "rewind", Map.of("image", "clam")))
                            .endsWith("; kept are calm; did you mean `calm`?");
                    assertThat(
                                    boss.command("load-law", Map.of("library", "../../etc/passwd"))
                                            .code())
                            .contains("law-refused");
                });
    }

    @Test
    void aLookAheadAtMoreThanIsToldAtOnceIsRefused() throws Exception {
        var file = new StringBuilder("reve: 1\nname: crowd\nitems:\n");
        for (int i = 0; i < 200; i++) {
            file.append("  - {name: item")
                    .append(i)
                    .append(", semantic: {note: ")
                    .append("x".repeat(4000))
                    .append("}}\n");
        }
        description = WorldFile.load(Files.writeString(folder.resolve("crowd.yaml"), file));
        serve(
                boss ->
                        assertThatExceptionOfType(AgentException.class)
                                .isThrownBy(() -> boss.foresee(1))
                                .withMessageContaining("more than is sent at once")
                                .extracting(AgentException::code)
                                .isEqualTo("fork-refused"));
    }

    @Test
    void aPictureIsTakenOfTheFrameThatItsResultNames() throws Exception {
        AtomicReference<ActResult> result = new AtomicReference<>();
        long frame = serve(boss -> result.set(boss.command("picture", Map.of()))).frames();
        Event taken =
                events.stream()
                        .filter(event -> event.type().equals("picture"))
                        .findFirst()
                        .orElseThrow();
        Path file = Path.of((String) taken.fields().get("file"));
        assertThat((Long) taken.fields().get("frame")).isBetween(1L, frame);
        assertThat(Files.readAllBytes(file)).startsWith(0x89, 'P', 'N', 'G');
        assertThat(result.get().frame()).hasValue((Long) taken.fields().get("frame"));
        assertThat(result.get().value().orElseThrow())
                .isEqualTo(Map.of("file", file.getFileName().toString()));
    }

    @Test
    void whatFollowsARewindIsToTheBitWhatFollowsTheBeginning() throws Exception {
        long hash;
        try (Simulation fresh = new Simulation(description, Pacing.FAST)) {
            fresh.loop().run(2 * RATE);
            hash = fresh.physics().stateHash();
        }
        RunReport report =
                serve(
                        boss -> {
                            accepted(boss, "pause", Map.of());
                            accepted(boss, "rewind", Map.of());
                            Perception first = after(boss, RATE);
                            accepted(boss, "snapshot", Map.of("image", "second"));
                            whileItRuns(
                                    boss,
                                    "edit",
                                    Map.of(
                                            "item",
                                            "blue",
                                            "property",
                                            "physics.velocity",
                                            "value",
                                            new double[] {0, 9, 0}));
                            whileItRuns(boss, "load-law", Map.of("library", "gravity_field"));
                            after(boss, 5);
                            long frame = accepted(boss, "rewind", Map.of("image", "second"));
                            Perception again = until(boss, frame);
                            assertThat(again.time()).isEqualTo(first.time());
                            assertThat(again.items()).isEqualTo(first.items());
                            after(boss, RATE);
                        });
        assertThat(report.stateHash()).isEqualTo(hash);
    }

    @Test
    void aRecordingOfARunThatWasRewoundIsReplayedIdentically() throws Exception {
        recording = Optional.of(folder.resolve("run.log"));
        RunReport report = serve(this::wander);
        requireIdentical(report);
    }

    private void requireIdentical(RunReport report) throws Exception {
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(recording.get())) {
            while (records.hasNext() && replay.take(records.next())) {
                // the list stays open for further records
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation again = replay.release()) {
                assertThat(again.loop().frame()).isEqualTo(report.frames());
                assertThat(again.physics().stateHash()).isEqualTo(report.stateHash());
            }
        }
    }

    @Test
    void aWorldThatIsRebuiltByMessagesIsReplayedIdentically() throws Exception {
        recording = Optional.of(folder.resolve("run.log"));
        store = Optional.of(folder.resolve("world.db"));
        RunReport report = serve(this::rebuild);
        assertThat(report.items()).isEqualTo(description.items().size() + 2);
        requireIdentical(report);
        events = new ArrayList<>();
        serve(boss -> {});
        assertThat(events.getFirst().fields())
                .containsEntry("stateHash", "%016x".formatted(report.stateHash()));
    }

    /** Changes everything in a world that a message can change. */
    private void rebuild(AgentClient boss) throws Exception {
        after(boss, 3);
        edited(
                boss,
                "add",
                Map.of(
                        "items",
                        List.of(
                                Map.of(
                                        "name",
                                        "moon {i}",
                                        "repeat",
                                        2,
                                        "like",
                                        "ball",
                                        "physical",
                                        Map.of("location", List.of("{3 + i}", 9, 0)),
                                        "physics",
                                        Map.of("mass", "200 g")),
                                Map.of(
                                        "name", "rope",
                                        "kind", "spring",
                                        "physics",
                                                Map.of(
                                                        "end1", "moon 0",
                                                        "end2", "moon 1",
                                                        "length", 2,
                                                        "springConstant", "3 N/m"))),
                        "prefabs",
                        Map.of(
                                "ball",
                                Map.of("physical", Map.of("shape", "sphere", "radius", "30 cm")))));
        edited(boss, "change", Map.of("item", "rope", "to", physics("end2", "red")));
        edited(
                boss,
                "change",
                Map.of(
                        "item",
                        "moon 1",
                        "to",
                        Map.of(
                                "name", "crate",
                                "physical", Map.of("shape", "box", "size", List.of(1, 1, 1)),
                                "physics", Map.of("mass", 0),
                                "parent", "blue",
                                "semantic", Map.of("class", "toy", "worn", true))));
        edited(boss, "rule", Map.of("name", "heavy", "rule", Map.of("is", "physics.mass > 100.0")));
        Perception seen = after(boss, 2);
        assertThat(seen.find("red").orElseThrow().symbols()).containsEntry("heavy", true);
        assertThat(seen.find("crate").orElseThrow().symbols())
                .containsEntry("class", "toy")
                .containsEntry("heavy", false);
        accepted(boss, "run", Map.of());
        ActResult refused =
                boss.command(
                        "batch",
                        Map.of(
                                "changes",
                                List.of(
                                        Map.of("t", "remove", "item", "crate"),
                                        Map.of("t", "rule", "name", "heavy"),
                                        Map.of("t", "remove", "item", "red"))));
        accepted(boss, "pause", Map.of());
        assertThat(refused.code()).contains("edit-refused");
        assertThat(refused.reason().orElseThrow()).startsWith("edit 2 of 2: item red");
        seen = after(boss, 1);
        assertThat(seen.find("crate")).isPresent();
        assertThat(seen.find("red").orElseThrow().symbols()).containsKey("heavy");
        edited(
                boss,
                "batch",
                Map.of(
                        "changes",
                        List.of(
                                Map.of("t", "remove", "item", "moon 0", "cascade", true),
                                Map.of("t", "rule", "name", "heavy"),
                                Map.of(
                                        "t",
                                        "add",
                                        "items",
                                        List.of(
                                                Map.of(
                                                        "name",
                                                        "light",
                                                        "physics",
                                                        Map.of(
                                                                "mass",
                                                                1,
                                                                "velocity",
                                                                List.of(1, 0, 0))))),
                                Map.of(
                                        "t",
                                        "change",
                                        "item",
                                        "light",
                                        "to",
                                        Map.of(
                                                "access",
                                                Map.of(
                                                        "stop",
                                                        Map.of(
                                                                "effects",
                                                                List.of(
                                                                        Map.of(
                                                                                "set",
                                                                                "physics.velocity",
                                                                                "to",
                                                                                List.of(
                                                                                        0, 0,
                                                                                        0))))))))));
        seen = after(boss, 5);
        assertThat(seen.find("rope")).isEmpty();
        assertThat(seen.find("red").orElseThrow().symbols()).doesNotContainKey("heavy");
        assertThat(seen.find("light").orElseThrow().actions()).containsKey("stop");
    }

    /** Makes an edit while the world makes at least one frame, and returns that frame. */
    private static void edited(AgentClient boss, String command, Map<String, ?> fields) {
        whileItRuns(boss, command, fields);
        after(boss, 2);
    }

    private static Map<String, Object> physics(String property, Object value) {
        return Map.of("physics", Map.of(property, value));
    }

    @Test
    void theBodyOfAnAgentIsNotRemoved() throws Exception {
        serve(
                boss -> {
                    try (AgentClient ada = Agents.join(port, "ada")) {
                        ActResult refused = boss.command("remove", Map.of("item", "ada"));
                        assertThat(refused.code()).contains("cannot-remove");
                        assertThat(ada.act("blue", "push", Map.of("impulse", List.of(0, 0, 3))))
                                .matches(ActResult::accepted);
                    }
                });
    }

    @Test
    void aStoredWorldThatWasRewoundGoesOnAsItWasLeft() throws Exception {
        store = Optional.of(folder.resolve("world.db"));
        RunReport report = serve(this::wander);
        events = new ArrayList<>();
        serve(boss -> {});
        Event ready =
                events.stream()
                        .filter(event -> event.type().equals("ready"))
                        .findFirst()
                        .orElseThrow();
        assertThat(ready.fields())
                .containsEntry("frame", report.frames())
                .containsEntry("stateHash", "%016x".formatted(report.stateHash()));
        assertThat(events).noneMatch(Event::isFault);
    }

    @Test
    void whatIsForeseenHappensIfNobodyInterferesAndTheWorldDoesNotNotice() throws Exception {
        serve(
                boss -> {
                    accepted(boss, "pause", Map.of());
                    long start = accepted(boss, "rewind", Map.of());
                    Perception foreseen = boss.foresee(2 * RATE);
                    assertThat(foreseen.frame()).isEqualTo(start + 2 * RATE);
                    assertThat(accepted(boss, "pause", Map.of())).isEqualTo(start);
                    Perception lived = after(boss, 2 * RATE);
                    assertThat(foreseen.items()).isEqualTo(lived.items());
                    assertThat(foreseen.time()).isEqualTo(lived.time());
                });
    }

    @Test
    void aForkIsLookedAtWhileTheWorldGoesOn() throws Exception {
        serve(
                boss -> {
                    long before = boss.nextPerception().frame();
                    assertThat(boss.foresee(10 * RATE).frame())
                            .isGreaterThanOrEqualTo(before + 10 * RATE);
                    assertThat(boss.nextPerception().frame()).isLessThan(before + 10 * RATE);
                    assertThatExceptionOfType(AgentException.class)
                            .isThrownBy(() -> boss.foresee(1_000_001));
                });
    }

    @Test
    void aSavedWorldGoesOnAsThisOneAndHasNoBodiesThatWereMadeForAgents() throws Exception {
        serve(
                boss -> {
                    try (AgentClient ada = Agents.join(port, "ada")) {
                        assertThat(
                                        ada.act("blue", "push", Map.of("impulse", List.of(0, 0, 3)))
                                                .accepted())
                                .isTrue();
                        accepted(boss, "pause", Map.of());
                        accepted(boss, "save", Map.of("file", "later"));
                        Perception lived = after(boss, RATE);
                        WorldDescription saved = WorldFile.load(folder.resolve("later.yaml"));
                        assertThat(saved.items()).noneMatch(item -> item.name().equals("ada"));
                        try (Simulation again = new Simulation(saved, Pacing.FAST)) {
                            again.loop().run(RATE);
                            double[] at =
                                    again.world().find("blue").orElseThrow().physical().location();
                            var location =
                                    lived.find("blue").orElseThrow().location().orElseThrow();
                            assertThat(at)
                                    .containsExactly(location.x(), location.y(), location.z());
                        }
                    }
                });
        assertThat(events).extracting(Event::type).contains("saved");
    }

    @Test
    void nothingIsSavedOutsideTheFolder() throws Exception {
        serve(
                boss -> {
                    for (String name : List.of("../x", "/tmp/x", "a/b", ".hidden", "x.yaml")) {
                        assertThat(boss.command("save", Map.of("file", name)).code())
                                .contains("save-refused");
                    }
                });
        assertThat(folder).isEmptyDirectory();
    }

    @Test
    void whyNothingCanBeSavedIsForWhoRunsTheServer() throws Exception {
        Files.createDirectory(folder.resolve("later.yaml"));
        serve(
                boss -> {
                    ActResult refused = boss.command("save", Map.of("file", "later"));
                    assertThat(refused.code()).contains("save-refused");
                    assertThat(refused.reason().orElseThrow())
                            .contains("later")
                            .doesNotContain("/");
                });
    }

    /** Rewinds several times, with an agent that joins after the restored frame. */
    private void wander(AgentClient boss) throws Exception {
        after(boss, 7);
        accepted(boss, "snapshot", Map.of("image", "early"));
        accepted(boss, "run", Map.of());
        try (AgentClient ada = Agents.join(port, "ada")) {
            for (int i = 0; i < 3; i++) {
                assertThat(ada.act("blue", "push", Map.of("impulse", List.of(0, 0, i))).accepted())
                        .isTrue();
                accepted(boss, "rewind", Map.of("image", "early"));
                accepted(
                        boss,
                        "edit",
                        Map.of(
                                "item",
                                "blue",
                                "property",
                                "physics.velocity",
                                "value",
                                new double[] {0, i, 0}));
            }
            accepted(boss, "rewind", Map.of());
            assertThat(ada.act("blue", "push", Map.of("impulse", List.of(0, 0, 1))).accepted())
                    .isTrue();
        }
        accepted(boss, "load-law", Map.of("library", "gravity_field"));
        after(boss, 5);
    }

    private int port;

    /** Serves the world on this thread while an operator works on another. */
    private RunReport serve(Script script) throws Exception {
        WorldPlan plan =
                new WorldPlan(
                        description,
                        Long.MAX_VALUE,
                        new Persistence(
                                WORLD,
                                recording.map(RecordingPlan::of),
                                store.map(StoreAddress.InFile::new),
                                Optional.of(folder),
                                10,
                                SqliteStore.Durability.NORMAL),
                        new Pictures(folder, List.of()));
        try (WorldServer server =
                new WorldServer(
                        List.of(plan),
                        Pacing.REAL_TIME,
                        AgentServerConfig.onPort(0),
                        Optional.empty(),
                        (type, fields) -> note(new Event(type, fields)))) {
            server.start();
            port = server.port();
            CompletableFuture<Void> operator =
                    CompletableFuture.runAsync(
                            () -> {
                                try (AgentClient boss =
                                        Agents.join(port, Join.as("boss").withRole("control"))) {
                                    boss.perceiveEvery(1);
                                    script.run(boss);
                                    boss.command("pause", Map.of());
                                } catch (Exception e) {
                                    throw new CompletionException(e);
                                } finally {
                                    server.stop();
                                }
                            });
            ServerReport report = server.run();
            operator.join();
            return report.runs().getFirst();
        }
    }

    private synchronized void note(Event event) {
        events.add(event);
    }

    private static long accepted(AgentClient boss, String command, Map<String, ?> fields) {
        ActResult result = boss.command(command, fields);
        assertThat(result.accepted()).as("%s %s: %s", command, fields, result).isTrue();
        return result.frame().orElseThrow();
    }

    /** Executes a command that takes a frame, in a paused world. */
    private static long whileItRuns(AgentClient boss, String command, Map<String, ?> fields) {
        accepted(boss, "run", Map.of());
        long frame = accepted(boss, command, fields);
        accepted(boss, "pause", Map.of());
        return frame;
    }

    /** Returns the perception of the last of that many frames. */
    private static Perception after(AgentClient boss, int frames) {
        return until(boss, accepted(boss, "step", Map.of("frames", frames)));
    }

    private static Perception until(AgentClient boss, long frame) {
        Perception seen = boss.nextPerception();
        while (seen.frame() < frame) {
            seen = boss.nextPerception();
        }
        return seen;
    }

    /** Returns the height of the red ball in a later frame of a paused world [m]. */
    private static double heightAt(AgentClient boss, long frame) {
        long now = accepted(boss, "pause", Map.of());
        return after(boss, (int) (frame - now))
                .find("red")
                .orElseThrow()
                .location()
                .orElseThrow()
                .y();
    }
}
