// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;

import reve.core.frame.TimeBudget;
import reve.core.frame.TimeBudget.Response;
import reve.core.world.OffHeapArena;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.SpringOrbit;
import reve.pe.Status;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The times of laws and their budgets. Each law needs more than a nanosecond and less than 10 s.
 */
class LawBudgetNativeTest {
    private static final String SPRINGS = "hooke_spring";
    private static final int PATIENCE = 3;
    private static final int FRAMES = 12;
    private static final int ENOUGH_FRAMES = 1_500;

    @Test
    void aLibraryOverItsBudgetIsUnloadedBeforeTheNextFrame() {
        List<LawChange> changes = new ArrayList<>();
        try (AdapterFixture clean = AdapterFixture.springOrbit(false);
                AdapterFixture slow = enforced()) {
            slow.adapter.laws().addListener(changes::add);
            slow.adapter.laws().setBudget(SPRINGS, budget(1, Response.UNLOAD));
            for (int frame = 1; frame <= FRAMES; frame++) {
                if (frame == PATIENCE + 1) {
                    clean.adapter.laws().unload(frame, idOf(clean, SPRINGS));
                }
                clean.run(1);
                slow.run(1);
                assertThat(slow.bytes()).as("frame %d", frame).isEqualTo(clean.bytes());
                assertThat(changes)
                        .filteredOn(LawChange.Unloaded.class::isInstance)
                        .hasSize(frame > PATIENCE ? 1 : 0);
            }
            assertThat(slow.events("over-budget"))
                    .singleElement()
                    .satisfies(
                            event -> {
                                assertThat(event.frame()).isEqualTo(PATIENCE + 1);
                                assertThat(event.fields())
                                        .containsEntry("library", SPRINGS)
                                        .containsKeys("sha256", "milliseconds")
                                        .containsEntry("budgetMilliseconds", 1e-6)
                                        .containsEntry("frames", PATIENCE)
                                        .containsEntry("then", "unload");
                                assertThat(event.fields().get("message"))
                                        .asString()
                                        .contains(
                                                "library hooke_spring exceeded its budget",
                                                "in 3 frames in a row",
                                                "it is unloaded");
                            });
            assertThat(slow.events("law-unloaded")).hasSize(1);
        }
    }

    /**
     * The same budget applies to the old version that returns. Therefore this version is unloaded
     * as well.
     */
    @Test
    void aVersionThatSoonExceedsItsBudgetIsReplacedByTheOneBefore() {
        List<LawChange> changes = new ArrayList<>();
        byte[] heavy =
                "law pull\n  each body: force -= 2 N (0, 1, 0)\n".getBytes(StandardCharsets.UTF_8);
        byte[] light =
                "law pull\n  each body: force -= 1 N (0, 1, 0)\n".getBytes(StandardCharsets.UTF_8);
        try (AdapterFixture slow = enforced()) {
            Laws laws = slow.adapter.laws();
            laws.keepPreviousFor(FRAMES);
            int pull;
            try (PreparedLibrary first = slow.engine.prepareText("pull.law", light)) {
                pull = laws.load(0, first, Map.of());
            }
            String old = library(slow, "pull").sha256();
            slow.run(1);
            try (PreparedLibrary second = slow.engine.prepareText("pull.law", heavy)) {
                laws.replace(1, pull, second, Map.of(), Path.of("pull.law"), made -> {});
            }
            laws.setBudget("pull", budget(1, Response.UNLOAD));
            laws.addListener(changes::add);
            slow.run(PATIENCE + 1);
            assertThat(library(slow, "pull").sha256()).isEqualTo(old);
            assertThat(changes)
                    .containsExactly(
                            new LawChange.Replaced(
                                    laws.libraries().size() - 1, library(slow, "pull")));
            assertThat(laws.quarantined()).isEmpty();
            assertThat(slow.events("over-budget"))
                    .singleElement()
                    .satisfies(
                            event ->
                                    assertThat(event.fields().get("message"))
                                            .asString()
                                            .endsWith(
                                                    "; the version before it is back, SHA-256 "
                                                            + old));
            slow.run(PATIENCE);
            assertThat(laws.libraries()).extracting(LawLibrary::name).doesNotContain("pull");
        }
    }

    @Test
    void aForceLawOverItsBudgetActsInEveryNthStep() {
        List<LawChange> changes = new ArrayList<>();
        try (AdapterFixture slow = enforced();
                AdapterFixture replayed = AdapterFixture.springOrbit(false)) {
            slow.adapter.laws().addListener(changes::add);
            slow.adapter.laws().setBudget(SPRINGS, budget(1, Response.SKIP_STEPS));
            for (int frame = 1; frame <= FRAMES; frame++) {
                slow.run(1);
                for (LawChange change : List.copyOf(changes)) {
                    replayed.adapter.laws().apply(frame, change);
                }
                changes.clear();
                replayed.run(1);
                assertThat(replayed.bytes()).as("frame %d", frame).isEqualTo(slow.bytes());
            }
            assertThat(replayed.events("over-budget")).isEmpty();
            assertThat(library(slow, SPRINGS).interval()).isEqualTo(2);
            assertThat(library(replayed, SPRINGS))
                    .usingRecursiveComparison()
                    .isEqualTo(library(slow, SPRINGS));
            assertThat(calls(slow, SPRINGS))
                    .as("4 steps a frame at first, then 2")
                    .isEqualTo(4 * PATIENCE + 2 * (FRAMES - PATIENCE));
            assertThat(slow.events("over-budget")).extracting(WorldEvent::frame).contains(4L);

            slow.adapter.laws().setBudget(SPRINGS, Optional.empty());
            long before = calls(slow, SPRINGS);
            slow.run(1);
            assertThat(calls(slow, SPRINGS)).isEqualTo(before + 4);
        }
    }

    @Test
    void aWarningChangesNothingAndIsRare() {
        try (AdapterFixture clean = AdapterFixture.springOrbit(false);
                AdapterFixture slow = enforced()) {
            slow.adapter.laws().setBudget(SPRINGS, budget(1, Response.WARN));
            clean.run(FRAMES);
            slow.run(FRAMES);
            assertThat(slow.bytes()).isEqualTo(clean.bytes());
            assertThat(slow.events("over-budget")).hasSize(1);
            slow.run(ENOUGH_FRAMES - FRAMES);
            assertThat(slow.events("over-budget"))
                    .extracting(WorldEvent::frame)
                    .containsExactly(4L, 604L, 1204L);
        }
    }

    @Test
    void nothingHappensWithinABudgetNorWithoutEnforcement() {
        try (AdapterFixture within = enforced();
                AdapterFixture free = AdapterFixture.springOrbit(false)) {
            within.adapter.laws().setBudget(SPRINGS, budget(10_000_000_000L, Response.UNLOAD));
            free.adapter.laws().setBudget(SPRINGS, budget(1, Response.UNLOAD));
            for (AdapterFixture world : List.of(within, free)) {
                world.run(FRAMES);
                assertThat(world.events("over-budget")).isEmpty();
                assertThat(world.adapter.laws().loaded()).hasSize(SpringOrbit.LAWS.length);
            }
        }
    }

    /** The engine waits for a processor if the machine is busy with other work. */
    @Test
    void theTimeInWhichTheEngineWaitedForAProcessorCountsForNoLaw() {
        var engines = new ArrayList<FailingEngine>();
        try (AdapterFixture busy =
                new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        AdapterFixture.springOrbitItems(),
                        new OffHeapArena(),
                        false,
                        engine -> {
                            engines.add(new FailingEngine(engine));
                            return engines.getFirst();
                        })) {
            busy.load(SpringOrbit.LAWS);
            busy.adapter.enforceBudgets(true);
            busy.adapter.laws().setBudget(SPRINGS, budget(1, Response.UNLOAD));
            engines.getFirst().waited = 60_000_000_000L;
            busy.run(FRAMES);
            assertThat(busy.events("over-budget")).isEmpty();
            engines.getFirst().waited = 0;
            busy.run(FRAMES);
            assertThat(busy.events("over-budget")).hasSize(1);
        }
    }

    /** The time of this law is less than the time of the exchange with its process. */
    @Test
    void aHostedLawOfLessThanAMicrosecondExceedsANanosecond() {
        try (HostedFixture hosted = new HostedFixture()) {
            AdapterFixture world = hosted.world.load("newton_motion", "wind");
            world.adapter.enforceBudgets(true);
            world.adapter.laws().setBudget("wind", budget(1, Response.UNLOAD));
            for (int frame = 0; frame < ENOUGH_FRAMES && world.events("over-budget").isEmpty(); ) {
                frame++; // a busy machine may make a frame too long to count
                world.run(1);
            }
            assertThat(world.events("over-budget")).hasSize(1);
            assertThat(world.adapter.laws().libraries())
                    .extracting(LawLibrary::name)
                    .containsExactly("newton_motion");
        }
    }

    @Test
    void aBudgetLastsThroughParametersReplacementsAndImages() {
        try (AdapterFixture world = enforced()) {
            Laws laws = world.adapter.laws();
            int wind = laws.load(0, "wind", Map.of());
            Optional<TimeBudget> budget = budget(1, Response.SKIP_STEPS);
            laws.setBudget("wind", budget);
            world.run(PATIENCE + 1);
            assertThat(library(world, "wind").interval()).isEqualTo(2);
            PhysicsImage image = world.adapter.save();

            laws.setParameters(4, "wind", Map.of("force", 3.0));
            assertThat(library(world, "wind").budget()).isEqualTo(budget);
            assertThat(library(world, "wind").interval()).isEqualTo(2);
            wind = laws.latest().orElseThrow().getKey();
            laws.unload(4, wind);
            laws.load(4, "wind", Map.of());
            assertThat(library(world, "wind").budget()).isEqualTo(budget);
            assertThat(library(world, "wind").interval()).isEqualTo(1);

            laws.setBudget("wind", Optional.empty());
            world.adapter.restore(4, image, () -> {});
            assertThat(library(world, "wind").budget()).isEqualTo(budget);
            assertThat(library(world, "wind").interval()).isEqualTo(2);
        }
    }

    @Test
    void lawsThatWritePropertiesCannotSkipSteps() {
        try (AdapterFixture world = enforced()) {
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(
                            () ->
                                    world.adapter
                                            .laws()
                                            .setBudget(
                                                    "newton_motion",
                                                    budget(1, Response.SKIP_STEPS)))
                    .satisfies(
                            refused ->
                                    assertThat(refused.status()).isEqualTo(Status.ACCESS_CONFLICT))
                    .withMessageContaining("newton_motion is no force law");
            assertThat(library(world, "newton_motion").budget()).isEmpty();
            assertThatExceptionOfType(IllegalArgumentException.class)
                    .isThrownBy(() -> world.adapter.laws().setBudget("no_law", Optional.empty()))
                    .withMessageContaining("no library \"no_law\" is loaded");
        }
    }

    @Test
    void timesCoverTheLastFramesOfEachLaw() {
        try (AdapterFixture world = AdapterFixture.springOrbit(false)) {
            world.adapter.measureFrames(world.loop::busyNanoseconds);
            assertThat(world.adapter.lawTimes()).extracting(LawTime::frames).containsOnly(0);
            world.run(FRAMES);
            world.adapter.laws().load(FRAMES, "wind", Map.of());
            world.run(PATIENCE);
            List<LawTime> times = world.adapter.lawTimes();
            assertThat(times)
                    .extracting(LawTime::frames)
                    .containsExactly(FRAMES + PATIENCE, FRAMES + PATIENCE, PATIENCE);
            for (LawTime time : times) {
                assertThat(time.medianNanoseconds()).isPositive();
                assertThat(time.p99Nanoseconds()).isGreaterThanOrEqualTo(time.medianNanoseconds());
                assertThat(time.share()).isBetween(0.0, 1.0);
            }
            world.run(ENOUGH_FRAMES);
            assertThat(world.adapter.lawTimes()).extracting(LawTime::frames).containsOnly(1024);
        }
    }

    private static AdapterFixture enforced() {
        AdapterFixture fixture = AdapterFixture.springOrbit(false);
        fixture.adapter.enforceBudgets(true);
        return fixture;
    }

    private static Optional<TimeBudget> budget(long nanoseconds, Response response) {
        return Optional.of(new TimeBudget(nanoseconds, PATIENCE, response, 2));
    }

    private static LawLibrary library(AdapterFixture world, String name) {
        return world.adapter.laws().libraries().stream()
                .filter(library -> library.name().equals(name))
                .findFirst()
                .orElseThrow();
    }

    private static int idOf(AdapterFixture world, String library) {
        return law(world, library).libraryId();
    }

    private static long calls(AdapterFixture world, String library) {
        return law(world, library).calls();
    }

    private static PhysicsLaw law(AdapterFixture world, String library) {
        return world.adapter.laws().loaded().stream()
                .filter(law -> law.library().equals(library))
                .findFirst()
                .orElseThrow();
    }
}
