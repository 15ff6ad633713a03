// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.jspecify.annotations.Nullable;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.FramePhase;
import reve.core.frame.LawSwap;
import reve.core.frame.Pacing;
import reve.core.frame.TimeBudget;
import reve.core.world.Force;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Shape;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.pe.PhysicsLaw.Claim;
import reve.pe.PreparedLibrary;
import reve.pe.adapter.LawChange;
import reve.pe.adapter.LawFolder;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.Laws;
import reve.pe.adapter.NewVersion;
import reve.worlds.Product;
import reve.worlds.journal.Journal;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;
import reve.worlds.journal.SimulationImage;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** New versions of laws in the shadow of a world of 60 frames a second. */
@Timeout(value = 120, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class ShadowNativeTest {
    private static final double DT = 1.0 / 60;

    /** Number of frames of a trial. */
    private static final int TRIAL = 30;

    private static final SwapPlan PLAN = new SwapPlan(Optional.of(LawSwap.SHADOW), 0.5, 10);

    private static final String WORLD =
            """
            reve: 1
            name: shadows
            frame: {rate: 60, steps: 1}
            laws:
            - newton_motion
            - text: |
                law push
                  parameter f = 1 N, from -1000 N to 1000 N
                  each body:
                    force += f (1, 0, 0)
            items:
            - name: stone
              physical: {shape: sphere, radius: 0.1, location: [0, 5, 0]}
              physics: {mass: 1, velocity: [3, 0, 0]}
            - name: rock
              physical: {shape: sphere, radius: 0.1, location: [0, 9, 0]}
              physics: {mass: 4, velocity: [0, 0, 1]}
            """;

    /**
     * A force that is not finite for the stone when it moves faster. This is the case in the sixth
     * frame of a trial.
     */
    private static final String NOT_FINITE =
            "f * (1 + exp(1e5 * (velocity.x - 3.09 m/s) / (1 m/s))) * (1, 0, 0)";

    @TempDir private Path folder;
    private final List<WorldEvent> events = new ArrayList<>();
    private final List<LawChange> changes = new ArrayList<>();
    private @Nullable Simulation simulation;
    private @Nullable Shadows shadows;

    private void start(String world, SwapPlan plan) throws Exception {
        WorldDescription description =
                WorldFile.parse("shadows.yaml", world.getBytes(StandardCharsets.UTF_8));
        simulation = new Simulation(description, Pacing.FAST);
        shadows = new Shadows(simulation, plan);
        simulation.physics().laws().addListener(changes::add);
        simulation.onPublish("test", frame -> events.addAll(frame.world().events()));
        simulation.loop().run(0);
    }

    private void start() throws Exception {
        start(WORLD, PLAN);
        shadows.start();
    }

    @AfterEach
    void close() {
        if (shadows != null && simulation != null) {
            shadows.close();
            simulation.close();
        }
    }

    private static String push(String force) {
        return "law push\n  parameter f = 1 N, from -1000 N to 1000 N\n  each body:\n    force += "
                + force
                + "\n";
    }

    private int idOf(String library) {
        return simulation.physics().laws().byId().entrySet().stream()
                .filter(loaded -> loaded.getValue().name().equals(library))
                .mapToInt(Map.Entry::getKey)
                .findFirst()
                .orElseThrow();
    }

    private NewVersion version(String library, String text) {
        PreparedLibrary prepared =
                simulation
                        .engine()
                        .prepareText(library + ".law", text.getBytes(StandardCharsets.UTF_8));
        return simulation
                .physics()
                .laws()
                .newVersion(
                        idOf(library), prepared, Map.of(), Path.of(library + ".law"), made -> {});
    }

    private void tryText(String text) {
        shadows.begin(simulation.loop().frame(), List.of(version("push", text)));
    }

    /** Makes frames. Each frame waits until the copy has made all frames before. */
    private void run(int frames) throws InterruptedException {
        for (int i = 0; i < frames; i++) {
            simulation.loop().step();
            shadows.await();
        }
    }

    private List<WorldEvent> stages(String stage) {
        return events.stream()
                .filter(event -> event.type().equals(Shadows.EVENT))
                .filter(event -> stage.equals(event.fields().get("stage")))
                .toList();
    }

    private double[] vector(String item, String property) {
        return simulation.world().find(item).orElseThrow().physics().vector(property);
    }

    private LawLibrary loaded(String name) {
        return simulation.physics().laws().byId().get(idOf(name));
    }

    @Test
    void aVersionActsInACopyAndTakesOverWhenItsTrialEnds() throws Exception {
        start();
        tryText(push("3 f (1, 0, 0)"));
        run(1);
        assertThat(stages("begins")).as("events of PUBLISH belong to the next frame").isEmpty();
        for (int frame = 1; frame <= TRIAL; frame++) {
            run(1);
            assertThat(changes).as("the old version moves the world").isEmpty();
            Map<String, Object> report = shadows.report().getFirst();
            assertThat(report)
                    .containsEntry("library", "push")
                    .containsEntry("stage", "runs")
                    .containsEntry("frames", frame)
                    .containsEntry("of", TRIAL)
                    .containsEntry("positionItem", "stone")
                    .containsEntry("velocityItem", "stone");
            // newton_motion: v += F/m dt, then x += v dt; the stone of 1 kg feels 2 N more
            assertThat((double) report.get("velocity")).isCloseTo(2 * frame * DT, within(1e-12));
            assertThat((double) report.get("position"))
                    .isCloseTo(2 * DT * DT * frame * (frame + 1) / 2, within(1e-12));
            assertThat((List<?>) report.get("items")).hasSize(2);
            Map<?, ?> rock = (Map<?, ?>) ((List<?>) report.get("items")).get(1);
            assertThat((Double) rock.get("velocity"))
                    .as("the rock has 4 kg")
                    .isCloseTo(2 * frame * DT / 4, within(1e-12));
        }
        double before = vector("stone", "velocity")[0];
        assertThat(before).isCloseTo(3 + (TRIAL + 1) * DT, within(1e-12));
        run(1);
        assertThat(changes)
                .singleElement()
                .isInstanceOfSatisfying(
                        LawChange.Replaced.class,
                        replaced -> assertThat(replaced.place()).isEqualTo(1));
        assertThat(vector("stone", "velocity")[0] - before).isCloseTo(3 * DT, within(1e-12));
        assertThat(stages("begins")).hasSize(1);
        assertThat(stages("runs")).hasSizeBetween(9, 10);
        assertThat(stages("accepted"))
                .singleElement()
                .satisfies(
                        event -> {
                            assertThat(event.frame()).isEqualTo(TRIAL + 2);
                            assertThat(event.fields())
                                    .containsEntry("sha256", loaded("push").sha256())
                                    .containsKeys("energy", "mostEnergy");
                        });
        assertThat(shadows.report()).isEmpty();
    }

    /** If the copy receives these changes, it has the same bits as the world. */
    @Test
    void theCopyReceivesAllChangesThatLawsDoNotMake() throws Exception {
        start(WORLD, PLAN);
        simulation
                .bus()
                .subscribe(
                        FramePhase.ACT,
                        "edits",
                        frame -> {
                            World world = frame.world();
                            Item stone = world.find("stone").orElseThrow();
                            switch ((int) frame.frame()) {
                                case 5 -> stone.physics().set("velocity", 0.1, 7, -0.3);
                                case 7 -> stone.physical().setLocation(1, 2, 3);
                                case 9 -> stone.physics().set("mass", 0.7);
                                case 11 ->
                                        world.add(
                                                ItemDefinition.named("pebble")
                                                        .shape(Shape.sphere(0.1))
                                                        .physics("mass", 0.3)
                                                        .physics("velocity", 1, 1, 1)
                                                        .build());
                                case 13 -> world.remove(world.find("rock").orElseThrow().id());
                                case 15 ->
                                        world.forces()
                                                .add(
                                                        new Force(
                                                                stone.id(),
                                                                List.of(0.3, 11.0, 0.0),
                                                                4));
                                default -> {}
                            }
                        });
        shadows.start();
        tryText(push("f (1, 0, 0)") + "  # the same law\n");
        for (int frame = 0; frame <= TRIAL; frame++) {
            run(1);
            assertThat(shadows.report().getFirst()).containsEntry("frames", frame);
            assertThat(shadows.report().getFirst().get("position")).isEqualTo(0.0);
            assertThat(shadows.report().getFirst().get("velocity")).isEqualTo(0.0);
        }
        run(1);
        assertThat(stages("accepted")).hasSize(1);
    }

    @Test
    void aVersionWhoseNumbersAreNotFiniteIsRefused() throws Exception {
        start();
        tryText(push(NOT_FINITE));
        run(TRIAL);
        assertThat(stages("refused"))
                .singleElement()
                .satisfies(
                        event -> {
                            assertThat(event.fields())
                                    .containsEntry("status", "LAW_FAILED")
                                    .containsEntry("library", "push");
                            assertThat(String.valueOf(event.fields().get("message")))
                                    .startsWith(
                                            "library push stays as it is; its new version is"
                                                    + " refused: in frame 6 of 30 of its shadow:"
                                                    + " after 6 steps: law push:");
                        });
        assertThat(changes).isEmpty();
        assertThat(simulation.physics().laws().quarantined()).isEmpty();
        run(TRIAL);
        assertThat(vector("stone", "velocity")[0]).isCloseTo(3 + 2 * TRIAL * DT, within(1e-12));
    }

    @Test
    void aVersionThatMakesEnergyJumpIsRefusedWithTheFigures() throws Exception {
        start();
        tryText(push("900 f (1, 0, 0)"));
        run(TRIAL + 5);
        assertThat(stages("refused"))
                .singleElement()
                .satisfies(
                        event -> {
                            double energy = (double) event.fields().get("energy");
                            double most = (double) event.fields().get("mostEnergy");
                            assertThat(energy).isGreaterThan(most);
                            assertThat(most)
                                    .as("10 times the energies of the world and of 1 m/s")
                                    .isBetween(10 * (4.5 + 2 + 2.5), 10 * (6.5 + 2 + 2.5));
                            assertThat(String.valueOf(event.fields().get("message")))
                                    .contains("it gave the bodies", "more than the limit of");
                        });
        assertThat(changes).isEmpty();
    }

    private PreparedLibrary testLaw(String name) throws IOException {
        Path file =
                Product.nativeFolder()
                        .resolve("adapter-test-laws")
                        .resolve("libvesper_law_" + name + ".so");
        return simulation.engine().prepare(Files.readAllBytes(file));
    }

    /** Loads a wind, and returns a test law of this name as its new version. */
    private NewVersion wind(String law) throws IOException {
        Laws laws = simulation.physics().laws();
        try (PreparedLibrary wind = testLaw("wind")) {
            laws.load(simulation.loop().frame(), wind, Map.of());
        }
        changes.clear();
        return laws.newVersion(
                idOf("wind"), testLaw(law), Map.of(), Path.of(law + ".so"), made -> {});
    }

    private void tryWind(String law) throws Exception {
        shadows.begin(simulation.loop().frame(), List.of(wind(law)));
        run(TRIAL + 2);
    }

    @Test
    void aVersionThatDoesNotConserveTheMomentumThatItClaimsIsRefused() throws Exception {
        start();
        tryWind("balanced_wind");
        // The force is 1 N on each of two bodies. The new version is refused in the first of 30
        // frames.
        assertThat(stages("refused"))
                .singleElement()
                .satisfies(
                        event -> {
                            assertThat(event.fields()).containsEntry("status", "LAW_MISBEHAVED");
                            assertThat(String.valueOf(event.fields().get("message")))
                                    .contains(
                                            "in frame 1 of 30 of its shadow: law wind claims to"
                                                    + " conserve momentum, but its forces gave the"
                                                    + " bodies 0.0333 kg*m/s, more than the limit"
                                                    + " of 0.00503 kg*m/s");
                        });
        assertThat(changes).isEmpty();
    }

    /** The force along X acts at the heights of 5 m and 9 m. */
    @Test
    void aVersionThatTurnsBodiesAlthoughItClaimsOtherwiseIsRefused() throws Exception {
        start();
        tryWind("straight_wind");
        assertThat(stages("refused"))
                .singleElement()
                .satisfies(
                        event ->
                                assertThat(String.valueOf(event.fields().get("message")))
                                        .contains(
                                                "claims to conserve angular momentum, but its"
                                                        + " moments about the origin gave the"
                                                        + " bodies 0.233 kg*m^2/s"));
        assertThat(changes).isEmpty();
    }

    /** The claims of this version are derived from its text. */
    @Test
    void aVersionThatKeepsItsClaimsIsAccepted() throws Exception {
        start();
        tryText(
                "law push\n  parameter f = 1 N, from -1000 N to 1000 N\n"
                        + "  each pair of bodies, r apart: energy = 9 f * r\n");
        run(TRIAL + 2);
        assertThat(simulation.physics().laws().loaded())
                .filteredOn(law -> law.library().equals("push"))
                .singleElement()
                .satisfies(
                        law ->
                                assertThat(law.claims())
                                        .contains(Claim.MOMENTUM, Claim.ANGULAR_MOMENTUM));
        assertThat(stages("accepted")).hasSize(1);
        double pulled = vector("stone", "velocity")[1];
        assertThat(pulled).as("9 N towards the rock").isPositive();
    }

    @Test
    void versionsThatAreTriedTogetherTakeOverInOneFrame() throws Exception {
        start();
        NewVersion wind = wind("strong_wind");
        shadows.begin(
                simulation.loop().frame(), List.of(version("push", push("-f (1, 0, 0)")), wind));
        run(TRIAL + 1);
        assertThat(changes).isEmpty();
        double before = vector("stone", "velocity")[0];
        run(1);
        assertThat(changes).hasSize(2).hasOnlyElementsOfType(LawChange.Replaced.class);
        assertThat(stages("accepted"))
                .extracting(event -> event.fields().get("library"))
                .containsExactlyInAnyOrder("push", "wind");
        assertThat(vector("stone", "velocity")[0] - before)
                .as("a wind of 2 N, and 1 N against it")
                .isCloseTo(DT, within(1e-12));
    }

    /** One of the versions fails. Then none of them has passed the trial, and none takes over. */
    @Test
    void versionsThatAreTriedTogetherAreRefusedTogether() throws Exception {
        start();
        NewVersion wind = wind("strong_wind");
        shadows.begin(simulation.loop().frame(), List.of(version("push", push(NOT_FINITE)), wind));
        run(TRIAL);
        assertThat(stages("refused"))
                .extracting(event -> event.fields().get("library"))
                .containsExactlyInAnyOrder("push", "wind");
        assertThat(changes).isEmpty();
    }

    @Test
    void aVersionOverItsBudgetIsRefused() throws Exception {
        start();
        simulation
                .physics()
                .laws()
                .setBudget("push", Optional.of(new TimeBudget(1, 3, TimeBudget.Response.WARN, 2)));
        changes.clear();
        tryText(push("2 f (1, 0, 0)"));
        run(TRIAL);
        assertThat(stages("refused"))
                .singleElement()
                .satisfies(
                        event ->
                                assertThat(String.valueOf(event.fields().get("message")))
                                        .contains(
                                                "library push exceeded its budget of 1.00e-06 ms"));
        assertThat(changes).isEmpty();
    }

    @Test
    void otherParametersAreTriedToo() throws Exception {
        start();
        Laws laws = simulation.physics().laws();
        shadows.begin(0, List.of(laws.newParameters("push", Map.of("f", 5.0))));
        run(TRIAL + 1);
        assertThat((double) shadows.report().getFirst().get("velocity"))
                .isCloseTo(4 * TRIAL * DT, within(1e-12));
        run(1);
        assertThat(changes).containsExactly(new LawChange.ParametersSet(1, Map.of("f", 5.0)));
    }

    /** The laws folder with the law push, which has acted for one frame. */
    private LawFolder folderWithPush(Path laws) throws Exception {
        Files.createDirectory(laws);
        Files.writeString(laws.resolve("push.law"), push("f (1, 0, 0)"));
        LawFolder watched =
                new LawFolder(
                        LawFolder.ORIGIN,
                        laws,
                        simulation.engine(),
                        simulation.physics().laws(),
                        simulation.commands(),
                        LawParameters::inFile,
                        shadows);
        lookAndRun(watched, 1);
        changes.clear();
        return watched;
    }

    /**
     * Scans the folder twice, because a changed file counts as complete in the second scan. Then
     * makes frames.
     */
    private void lookAndRun(LawFolder watched, int frames) throws InterruptedException {
        watched.look();
        watched.look();
        run(frames);
    }

    private double push() {
        return simulation.physics().laws().loaded().stream()
                .filter(law -> law.library().equals("push"))
                .mapToDouble(
                        law ->
                                loaded("push")
                                        .parameters()
                                        .getOrDefault("f", law.parameters().getFirst().standard()))
                .findFirst()
                .orElseThrow();
    }

    private static final String WITHOUT_PUSH =
            WORLD.substring(0, WORLD.indexOf("- text:")) + WORLD.substring(WORLD.indexOf("items:"));

    @Test
    void parametersInAFileAreTriedWhereNewVersionsAre() throws Exception {
        start(WITHOUT_PUSH, PLAN);
        shadows.start();
        Path laws = folder.resolve("laws");
        try (LawFolder watched = folderWithPush(laws)) {
            Path file = laws.resolve("push.yaml");
            Files.writeString(file, "f: 5 N\n");
            lookAndRun(watched, TRIAL + 1);
            assertThat(changes).as("the old value moves the world").isEmpty();
            assertThat(shadows.report().getFirst())
                    .containsEntry("library", "push")
                    .containsEntry("parameters", "f = 5.0");
            assertThat((double) shadows.report().getFirst().get("velocity"))
                    .isCloseTo(4 * TRIAL * DT, within(1e-12));
            run(1);
            assertThat(changes).containsExactly(new LawChange.ParametersSet(1, Map.of("f", 5.0)));

            Files.writeString(file, "f: 900 N\n");
            lookAndRun(watched, 2 * TRIAL + 1);
            assertThat(push()).as("refused: the old value stays").isEqualTo(5.0);
            assertThat(stages("refused"))
                    .singleElement()
                    .satisfies(
                            event -> {
                                Map<String, Object> fields = event.fields();
                                assertThat(fields).containsEntry("parameters", "f = 900.0");
                                assertThat((double) fields.get("energy"))
                                        .isGreaterThan((double) fields.get("mostEnergy"));
                                assertThat(String.valueOf(fields.get("message")))
                                        .startsWith(
                                                "library push stays as it is; its new parameters"
                                                        + " are refused: in frame ")
                                        .contains("it gave the bodies", "more than the limit of");
                            });

            Files.delete(file);
            lookAndRun(watched, 2 * TRIAL + 1);
            assertThat(push()).as("the default, after another trial").isEqualTo(1.0);
            assertThat(stages("accepted")).hasSize(2);
        }
    }

    /** The file has the current values again. Therefore there is nothing to try. */
    @Test
    void aFileOfParametersThatIsPutBackEndsItsTrial() throws Exception {
        start(WITHOUT_PUSH, PLAN);
        shadows.start();
        Path laws = folder.resolve("laws");
        try (LawFolder watched = folderWithPush(laws)) {
            Files.writeString(laws.resolve("push.yaml"), "f: 5 N\n");
            lookAndRun(watched, 5);
            assertThat(shadows.report()).hasSize(1);
            Files.delete(laws.resolve("push.yaml"));
            lookAndRun(watched, TRIAL + 5);
            assertThat(shadows.report()).isEmpty();
            assertThat(stages("refused")).hasSize(1);
            assertThat(changes).isEmpty();
        }
    }

    @Test
    void parametersInAFileWithAWrongUnitAreRefusedWithTheirPlace() throws Exception {
        start(WITHOUT_PUSH, PLAN);
        shadows.start();
        Path laws = folder.resolve("laws");
        try (LawFolder watched = folderWithPush(laws)) {
            Files.writeString(laws.resolve("push.yaml"), "f: 5 m\n");
            lookAndRun(watched, 2);
            assertThat(shadows.report()).isEmpty();
            assertThat(events)
                    .filteredOn(event -> event.type().equals("fault"))
                    .singleElement()
                    .satisfies(
                            event ->
                                    assertThat(String.valueOf(event.fields().get("message")))
                                            .contains("push.yaml:1:", "unit m does not fit N"));
        }
    }

    @Test
    void parametersInAFileTakeEffectAtOnceByDefault() throws Exception {
        start(WITHOUT_PUSH, SwapPlan.STANDARD);
        shadows.start();
        Path laws = folder.resolve("laws");
        try (LawFolder watched = folderWithPush(laws)) {
            Files.writeString(laws.resolve("push.yaml"), "f: 5 N\n");
            lookAndRun(watched, 1);
            assertThat(changes).containsExactly(new LawChange.ParametersSet(1, Map.of("f", 5.0)));
        }
    }

    /** In these cases the running copy no longer has the laws or the past of the world. */
    @Test
    void aTrialBeginsAgainIfLawsChangeOrTheWorldIsRewound() throws Exception {
        start();
        run(1);
        try (SimulationImage image = simulation.keep()) {
            tryText(push("3 f (1, 0, 0)"));
            run(TRIAL / 2);
            assertThat(shadows.report().getFirst()).containsEntry("frames", TRIAL / 2 - 1);
            simulation.physics().laws().load(simulation.loop().frame(), "drag", Map.of());
            run(1);
            assertThat(shadows.report().getFirst()).containsEntry("frames", 0);
            run(TRIAL / 2 + 3);
            assertThat(shadows.report().getFirst())
                    .as("the next copy began a trial's time after the first one")
                    .containsEntry("frames", 3);
            simulation.rewind(image);
            run(4);
            assertThat(shadows.report().getFirst()).containsEntry("frames", 0);
            run(2 * TRIAL);
        }
        assertThat(stages("accepted")).hasSize(1);
        assertThat(stages("begins")).hasSize(1);
    }

    @Test
    void aNewerVersionEndsTheTrialOfTheOneBefore() throws Exception {
        start();
        tryText(push("3 f (1, 0, 0)"));
        run(5);
        tryText(push("4 f (1, 0, 0)"));
        run(2 * TRIAL);
        assertThat(stages("refused"))
                .singleElement()
                .satisfies(
                        event ->
                                assertThat(String.valueOf(event.fields().get("message")))
                                        .contains("another change of the law came first"));
        assertThat(stages("accepted")).hasSize(1);
        double before = vector("stone", "velocity")[0];
        run(1);
        assertThat(vector("stone", "velocity")[0] - before).isCloseTo(4 * DT, within(1e-12));
    }

    /** The new version can no longer take over. The next trial begins. */
    @Test
    void aTrialEndsIfItsLawFailsInTheWorldBeforeItTakesOver() throws Exception {
        start();
        tryText(push("2 f (1, 0, 0)"));
        run(TRIAL + 1);
        assertThat(shadows.report().getFirst()).containsEntry("frames", TRIAL);
        simulation.physics().laws().unload(simulation.loop().frame(), idOf("push"));
        run(1);
        assertThat(stages("refused"))
                .singleElement()
                .satisfies(
                        event -> assertThat(event.fields()).containsEntry("status", "NOT_FOUND"));
        assertThat(shadows.report()).isEmpty();
        assertThat(events).noneMatch(event -> event.type().equals("fault"));
    }

    /** The world arrests the item in the same frame, so the new version is not the cause. */
    @Test
    void anActThatNoLawCanComputeWithDoesNotRefuseAVersion() throws Exception {
        String drag =
                "law push\n  parameter f = 1 N, from -1000 N to 1000 N\n  each body:\n"
                        + "    force -= %s f |velocity / (1 m/s)|^3 * velocity / (1 m/s)\n";
        start(WORLD, PLAN);
        version("push", drag.formatted("1e-9")).take(0);
        simulation
                .bus()
                .subscribe(
                        FramePhase.ACT,
                        "edits",
                        frame -> {
                            if (frame.frame() == 8) {
                                Item stone = frame.world().find("stone").orElseThrow();
                                frame.world().arrests().suspect(stone.id());
                                stone.physics().set("velocity", 1e100, 0, 0);
                            }
                        });
        shadows.start();
        tryText(drag.formatted("2e-9"));
        run(TRIAL + 3);
        assertThat(events)
                .filteredOn(event -> event.type().equals("fault"))
                .singleElement()
                .satisfies(fault -> assertThat(fault.fields()).containsEntry("arrested", true));
        assertThat(stages("accepted")).hasSize(1);
        assertThat(stages("refused")).isEmpty();
    }

    /** Each copy needs the memory and the processor time of a world. */
    @Test
    void newVersionsInARowMakeOneCopyAtATime() throws Exception {
        start();
        for (int i = 1; i <= 2 * TRIAL; i++) {
            tryText(push(0.05 * i + " f (1, 0, 0)"));
            simulation.loop().step();
            assertThat(Thread.getAllStackTraces().keySet())
                    .filteredOn(thread -> thread.getName().equals("shadow of push"))
                    .hasSizeLessThanOrEqualTo(1);
        }
        run(2 * TRIAL);
        assertThat(stages("begins")).hasSizeLessThanOrEqualTo(4);
        assertThat(stages("accepted")).hasSize(1);
        double before = vector("stone", "velocity")[0];
        run(1);
        assertThat(vector("stone", "velocity")[0] - before)
                .as("the last version acts")
                .isCloseTo(0.05 * 2 * TRIAL * DT, within(1e-12));
    }

    @Test
    void aTrialEndsIfItsLibraryIsUnloaded() throws Exception {
        start();
        tryText(push("3 f (1, 0, 0)"));
        run(5);
        simulation.physics().laws().unload(simulation.loop().frame(), idOf("push"));
        run(3);
        assertThat(shadows.report()).isEmpty();
        assertThat(stages("refused")).hasSize(1);
    }

    /** The decisions depend on the copy and the clock. The recording contains the decisions. */
    @Test
    void aReplayNeedsNoCopy() throws Exception {
        Path log = folder.resolve("run.log");
        start(WORLD, PLAN);
        long hash;
        try (Journal _ =
                simulation.journal(
                        folder,
                        Map.of(),
                        new Journal.Plan(0, true),
                        new Recording(RecordingPlan.of(log)),
                        problem -> {
                            throw new AssertionError(problem);
                        })) {
            shadows.start();
            tryText(push("3 f (0, 1, 0)"));
            run(TRIAL + 10);
            tryText(push(NOT_FINITE));
            run(TRIAL);
            assertThat(stages("accepted")).hasSize(1);
            assertThat(stages("refused")).hasSize(1);
            Laws laws = simulation.physics().laws();
            for (double f : new double[] {5, 900}) {
                shadows.begin(
                        simulation.loop().frame(),
                        List.of(laws.newParameters("push", Map.of("f", f))));
                run(TRIAL + 10);
            }
            assertThat(loaded("push").parameters()).isEqualTo(Map.of("f", 5.0));
            hash = simulation.physics().stateHash();
        }
        assertThat(stages("accepted")).hasSize(2);
        assertThat(stages("refused")).hasSize(2);
        long taken = stages("accepted").getFirst().frame();
        long set = stages("accepted").getLast().frame();
        List<Long> frames = new ArrayList<>();
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext()) {
                assertThat(replay.take(records.next())).isTrue();
                if (replay.frame() >= 0 && frames.isEmpty()) {
                    replay.simulation()
                            .physics()
                            .laws()
                            .addListener(change -> frames.add(replay.frame() + 1));
                    frames.add(0L);
                }
            }
            assertThat(replay.frames()).as("after the image").isEqualTo(4 * TRIAL + 29);
            assertThat(frames).containsExactly(0L, taken, set);
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(hash);
                assertThat(again.events().count(Shadows.EVENT)).isZero();
            }
        }
    }

    /** The world has the same bits as a world in which the old version acted from that frame on. */
    @Test
    void aVersionThatFailsSoonIsRolledBackAndReplayed() throws Exception {
        Path log = folder.resolve("run.log");
        start(WORLD, PLAN);
        Laws laws = simulation.physics().laws();
        String old = loaded("push").sha256();
        long hash;
        try (Journal _ =
                simulation.journal(
                        folder,
                        Map.of(),
                        new Journal.Plan(0, true),
                        new Recording(RecordingPlan.of(log)),
                        problem -> {
                            throw new AssertionError(problem);
                        })) {
            shadows.start();
            run(2);
            version("push", push(NOT_FINITE)).take(3);
            String failing = loaded("push").sha256();
            run(10);
            assertThat(loaded("push").sha256()).isEqualTo(old);
            assertThat(laws.libraries())
                    .extracting(LawLibrary::name)
                    .containsExactly("newton_motion", "push");
            assertThat(laws.quarantined())
                    .singleElement()
                    .satisfies(bad -> assertThat(bad.sha256()).isEqualTo(failing));
            assertThat(events)
                    .filteredOn(event -> event.type().equals("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("rolledBackTo", old)
                                            .containsEntry("sha256", failing));
            assertThat(vector("stone", "velocity")[0])
                    .as("12 frames of 1 N on 1 kg")
                    .isCloseTo(3 + 12 * DT, within(1e-9));
            hash = simulation.physics().stateHash();
        }
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext()) {
                assertThat(replay.take(records.next())).as("%s", replay.divergence()).isTrue();
            }
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(hash);
                assertThat(again.events().count("fault")).isZero();
                assertThat(again.physics().laws().quarantined()).hasSize(1);
            }
        }
    }

    @Test
    void aVersionThatFailsLaterIsUnloaded() throws Exception {
        start(WORLD, PLAN);
        Laws laws = simulation.physics().laws();
        laws.keepPreviousFor(3);
        version("push", push(NOT_FINITE)).take(1);
        run(10);
        assertThat(laws.libraries()).extracting(LawLibrary::name).containsExactly("newton_motion");
        assertThat(laws.quarantined()).hasSize(1);
    }
}
