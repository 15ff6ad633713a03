// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Item;
import reve.core.world.WorldEvent;
import reve.pe.LedgerLine;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.SimulationImage;
import reve.worlds.server.Simulation;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;

/** The world of the page on levels: with real laws, on a server, recorded, stored and saved. */
@Tag("slow")
class LevelsIT {
    private static final int FRAMES = 180;

    @TempDir private Path folder;
    private Path world = Path.of("");

    @BeforeEach
    void write() throws Exception {
        world = folder.resolve("drop.yaml");
        Document page = Document.read(Project.ROOT.resolve("docs/levels.md"));
        Files.writeString(
                world,
                page.blocks().stream()
                        .filter(block -> block.text().startsWith("# drop.yaml"))
                        .findFirst()
                        .orElseThrow()
                        .text());
    }

    private static double[] numbers(Object text) {
        return Arrays.stream(text.toString().replaceAll("[\\[\\] ]", "").split(","))
                .mapToDouble(Double::parseDouble)
                .toArray();
    }

    private static double number(WorldEvent event, String field) {
        return ((Number) event.fields().get(field)).doubleValue();
    }

    /** The conditions turn the ball into a soft body before it hits the floor, and back. */
    @Test
    void aFastFallMakesTheDropSoftAndItsCalmMakesItABallAgain() throws Exception {
        assertThat(Reve.run("check", "--strict", world.toString()).out()).contains("valid");
        List<WorldEvent> changes = new ArrayList<>();
        try (Simulation simulation = new Simulation(WorldFile.load(world), Pacing.FAST)) {
            simulation.onPublish(
                    "changes",
                    frame ->
                            frame.world().events().stream()
                                    .filter(event -> event.type().equals("level-changed"))
                                    .forEach(changes::add));
            simulation.physics().setLedger(true);
            simulation.loop().run(FRAMES);
            assertThat(changes)
                    .extracting(event -> event.fields().get("to"))
                    .startsWith("soft", "ball");
            WorldEvent soft = changes.getFirst();
            // The speed of a free fall from rest first exceeds 5 m/s after this many whole frames.
            long fall = (long) Math.ceil(5 / 9.81 * 60) + 1;
            assertThat(soft.frame()).isBetween(fall - 1, fall + 1);
            assertThat(number(soft, "energyLost")).isCloseTo(0, within(1e-12));
            for (WorldEvent change : changes) {
                double[] before = numbers(change.fields().get("momentumBefore"));
                double[] after = numbers(change.fields().get("momentumAfter"));
                double[] spin = numbers(change.fields().get("angularMomentumBefore"));
                double[] spinAfter = numbers(change.fields().get("angularMomentumAfter"));
                for (int axis = 0; axis < 3; axis++) {
                    assertThat(after[axis]).isCloseTo(before[axis], within(1e-13));
                    assertThat(spinAfter[axis]).isCloseTo(spin[axis], within(1e-13));
                }
            }
            // The engine's ledger is an independent count of what the changes gave and took.
            LedgerLine client =
                    simulation.physics().ledger().stream()
                            .filter(line -> line.name().equals("client"))
                            .findFirst()
                            .orElseThrow();
            double lost = changes.stream().mapToDouble(each -> number(each, "energyLost")).sum();
            assertThat(lost).isPositive();
            assertThat(client.energy()).isCloseTo(-lost, within(1e-10));
            for (int axis = 0; axis < 3; axis++) {
                assertThat(client.momentum().get(axis)).isCloseTo(0, within(1e-10));
                assertThat(client.angularMomentum().get(axis)).isCloseTo(0, within(1e-10));
            }
            Item drop = simulation.world().find("drop").orElseThrow();
            assertThat(drop.physics().scalar("mass")).isCloseTo(1, within(1e-12));
            assertThat(drop.physical().location()[1]).isGreaterThan(0);
        }
    }

    /** Two runs, one of which is saved and loaded in the soft state, have the same bits. */
    @Test
    void aWorldThatIsSavedWhileItIsSoftContinuesToTheBit() throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation first = new Simulation(WorldFile.load(world), Pacing.FAST)) {
            first.loop().run(38);
            assertThat(first.world().find("drop.core")).isPresent();
            WorldFile.save(saved, first.descriptionNow());
            try (Simulation second = new Simulation(WorldFile.load(saved), Pacing.FAST)) {
                for (int frame = 39; frame <= FRAMES; frame++) {
                    first.loop().step();
                    second.loop().step();
                    assertThat(second.physics().stateHash())
                            .as("frame %d", frame)
                            .isEqualTo(first.physics().stateHash());
                }
                assertThat(second.world().find("drop").orElseThrow().semantic().get("level"))
                        .isEqualTo(
                                first.world().find("drop").orElseThrow().semantic().get("level"));
            }
        }
    }

    /** A copy of the world evaluates the conditions of its own, from the state of the image. */
    @Test
    void aForkAndARewindMakeTheSameChanges() throws Exception {
        try (Simulation first = new Simulation(WorldFile.load(world), Pacing.FAST)) {
            first.loop().run(20);
            try (SimulationImage image = new SimulationImage(first.world())) {
                image.copyFrom(first.world(), first.physics(), first.loop().frame());
                List<Long> hashes = new ArrayList<>();
                for (int frame = 21; frame <= FRAMES; frame++) {
                    first.loop().step();
                    hashes.add(first.physics().stateHash());
                }
                first.rewind(image);
                assertThat(first.world().find("drop.core")).isEmpty();
                try (Simulation fork = first.fork(image)) {
                    for (long hash : hashes) {
                        first.loop().step();
                        fork.loop().step();
                        assertThat(first.physics().stateHash()).isEqualTo(hash);
                        assertThat(fork.physics().stateHash()).isEqualTo(hash);
                    }
                }
            }
        }
    }

    @Test
    void aRecordedRunIsReplayedToTheBit() throws Exception {
        Path log = folder.resolve("run.log");
        Outcome run =
                Reve.run("run", world.toString(), "--seconds", "3", "--record", log.toString());
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(Reve.run("replay", log.toString()).out())
                .startsWith("identical: " + FRAMES + " frames");
    }

    @Test
    void operatorsAndAgentsChangeTheLevelOfAServedWorldThatIsStored() throws Exception {
        // Without gravity and conditions, the drop keeps the level that is chosen for it.
        Path quiet = folder.resolve("quiet.yaml");
        Files.writeString(
                quiet,
                Files.readString(world)
                        .replace("gravity: [0, -9.81, 0]", "gravity: [0, 0, 0]")
                        .replaceAll(" +when: .*\n", ""));
        Path store = folder.resolve("worlds.db");
        Path log = folder.resolve("served.log");
        String hash;
        try (Server server = serve(quiet, store, log)) {
            String port = server.port();
            Outcome soft = control(port, "change", "item=drop", "semantic.level=soft");
            assertThat(soft.code()).as(soft.err()).isZero();
            JsonNode event = server.events().await("level-changed", one -> true);
            assertThat(event.path("to").asString()).isEqualTo("soft");
            assertThat(inspect(port).at("/semantic/level").asString()).isEqualTo("soft");
            assertThat(inspect(port).at("/levels").toString()).isEqualTo("[\"ball\",\"soft\"]");
            assertThat(control(port, "inspect", "item=drop.core").code()).isZero();
            Outcome wrong =
                    control(port, "edit", "item=drop", "property=semantic.level", "value=sofft");
            assertThat(wrong.code()).isEqualTo(1);
            assertThat(wrong.err()).contains("edit-refused", "did you mean `soft`?");
            Outcome ball =
                    control(port, "edit", "item=drop", "property=semantic.level", "value=ball");
            assertThat(ball.code()).as(ball.err()).isZero();
            server.events().await("level-changed", one -> one.path("to").asString().equals("ball"));
            assertThat(control(port, "inspect", "item=drop.core").err()).contains("no-such-item");
            assertThat(control(port, "change", "item=drop", "semantic.level=soft").code()).isZero();
            assertThat(control(port, "shut-down").code()).isZero();
            hash = server.events().await("end", one -> true).path("stateHash").asString();
            assertThat(server.exitCode()).isZero();
        }
        assertThat(Reve.run("replay", log.toString()).out()).startsWith("identical");
        try (Server server = serve(quiet, store, folder.resolve("again.log"))) {
            JsonNode ready = server.events().await("ready", one -> true);
            assertThat(ready.path("stateHash").asString()).isEqualTo(hash);
            String port = server.port();
            assertThat(inspect(port).at("/semantic/level").asString()).isEqualTo("soft");
            assertThat(control(port, "change", "item=drop", "semantic.level=ball").code()).isZero();
            server.events().await("level-changed", one -> true);
            assertThat(inspect(port).at("/semantic/level").asString()).isEqualTo("ball");
            assertThat(control(port, "shut-down").code()).isZero();
        }
    }

    private Server serve(Path file, Path store, Path log) throws Exception {
        return Server.start(
                folder,
                "serve",
                file.toString(),
                "--port",
                "0",
                "--json",
                "--store",
                store.toString(),
                "--record",
                log.toString());
    }

    private static Outcome control(String port, String... command) throws Exception {
        List<String> arguments = new ArrayList<>(List.of("control"));
        arguments.addAll(List.of(command));
        arguments.addAll(List.of("--port", port));
        return Reve.run(arguments.toArray(String[]::new));
    }

    private static JsonNode inspect(String port) throws Exception {
        Outcome report = control(port, "inspect", "item=drop", "--json");
        assertThat(report.code()).as(report.err()).isZero();
        return JsonMapper.shared().readTree(report.out());
    }
}
