// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.adapter.LawLibrary;
import reve.worlds.Product;
import reve.worlds.journal.Journal;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** New versions of a law in a recording and in its replay. */
class ReplacementReplayNativeTest {
    private static final int FRAMES = 30;

    private static final String WORLD =
            """
            reve: 1
            name: versions
            frame: {rate: 60, steps: 4}
            laws:
            - gravity_field
            - text: |
                law push
                  parameter strength = 2 N
                  each body:
                    force += strength (1, 0, 0)
            - newton_motion
            constants: {gravity: [0, -9.81, 0]}
            items:
            - name: ball
              physical: {shape: sphere, radius: 0.1, location: [0, 5, 0]}
              physics: {mass: 1, velocity: [3, 0, 0]}
            """;

    @TempDir private Path folder;

    @Test
    void aReplayReplacesTheSameLawsInTheirPlaces() throws Exception {
        Path log = folder.resolve("run.log");
        WorldDescription description =
                WorldFile.parse("versions.yaml", WORLD.getBytes(StandardCharsets.UTF_8));
        long hash;
        List<String> texts;
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                folder,
                                Map.of(),
                                new Journal.Plan(0, true),
                                new Recording(RecordingPlan.of(log)),
                                problem -> {
                                    throw new AssertionError(problem);
                                })) {
            simulation.loop().run(FRAMES);
            replace(simulation, "force += 3 N (0, 0, 1)");
            simulation.loop().run(FRAMES);
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> replace(simulation, "force += velocity"));
            simulation.loop().run(FRAMES);
            replace(simulation, "force += -1 N (1, 0, 0)");
            simulation.loop().run(FRAMES);
            hash = simulation.physics().stateHash();
            texts = libraries(simulation);
            assertThat(texts).element(1).asString().contains("-1 N");
        }
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next())) {
                // until the end
            }
            assertThat(replay.divergence()).isEmpty();
            assertThat(replay.frames()).isEqualTo(4 * FRAMES);
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(hash);
                assertThat(libraries(again)).isEqualTo(texts);
            }
        }
    }

    /**
     * The file of the library changes while the world runs. Then the client loads the library again
     * by its name.
     */
    @Test
    void aFileOfNativeCodeReplacesTheLoadedLibraryOfItsNameAlsoInAReplay() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("laws"));
        Path log = folder.resolve("run.log");
        put(laws, "wind"); // 1 N
        WorldDescription description =
                WorldFile.parse(
                        "versions.yaml",
                        WORLD.replaceAll("(?s)- text:.*?- newton", "- wind\n- newton")
                                .getBytes(StandardCharsets.UTF_8));
        LawPath path =
                new LawPath(
                        Product.nativeFolder().resolve("laws"),
                        Optional.of(laws),
                        Optional.empty(),
                        true);
        long hash;
        try (Simulation simulation = new Simulation(description, Pacing.FAST, path);
                Journal _ =
                        simulation.journal(
                                folder,
                                Map.of(),
                                new Journal.Plan(0, true),
                                new Recording(RecordingPlan.of(log)),
                                problem -> {
                                    throw new AssertionError(problem);
                                })) {
            simulation.loop().run(FRAMES);
            assertThat(speed(simulation)).isCloseTo(3 + FRAMES / 60.0, within(1e-12));
            assertThatExceptionOfType(PhysicsException.class)
                    .as("the same bytes are loaded already")
                    .isThrownBy(() -> load(simulation, "wind"));
            put(laws, "strong_wind"); // 2 N, in a library of the same name
            load(simulation, "wind");
            assertThat(libraries(simulation)).hasSize(3);
            simulation.loop().run(FRAMES);
            assertThat(speed(simulation)).isCloseTo(3 + 3 * FRAMES / 60.0, within(1e-12));
            hash = simulation.physics().stateHash();
        }
        put(laws, "wind"); // the recording contains both versions
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST, path);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next())) {
                // until the end
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(hash);
            }
        }
    }

    private static void put(Path laws, String library) throws IOException {
        Path made =
                Product.nativeFolder()
                        .resolve("adapter-test-laws")
                        .resolve("libvesper_law_" + library + ".so");
        Path next = laws.resolve("next");
        Files.copy(made, next);
        Files.move(
                next,
                laws.resolve("libvesper_law_wind.so"),
                StandardCopyOption.REPLACE_EXISTING,
                StandardCopyOption.ATOMIC_MOVE);
    }

    private static void load(Simulation simulation, String library) {
        try (PreparedLibrary prepared = simulation.prepare(library)) {
            ServerControl.loadOrReplace(
                    simulation.physics().laws(),
                    simulation.loop().frame(),
                    prepared,
                    Map.of(),
                    simulation.fileOf(library));
        }
    }

    private static double speed(Simulation simulation) {
        return simulation.world().find("ball").orElseThrow().physics().vector("velocity")[0];
    }

    private static void replace(Simulation simulation, String statement) {
        byte[] text =
                ("law push\n  each body:\n    " + statement + "\n")
                        .getBytes(StandardCharsets.UTF_8);
        try (PreparedLibrary next = simulation.engine().prepareText("push.law", text)) {
            ServerControl.loadOrReplace(
                    simulation.physics().laws(),
                    simulation.loop().frame(),
                    next,
                    Map.of(),
                    Path.of("push.law"));
        }
    }

    private static List<String> libraries(Simulation simulation) {
        return simulation.physics().laws().libraries().stream()
                .map(LawLibrary::bytes)
                .map(bytes -> new String(bytes, StandardCharsets.ISO_8859_1))
                .toList();
    }
}
