// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.SpringOrbit;
import reve.pe.Status;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Random;

class RollbackNativeTest {
    private static final int BAD_STEP = 22; // the third of frame 6

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void aLawThatWritesNanLeavesAWorldThatNeverHadIt(boolean validate) {
        try (AdapterFixture clean = AdapterFixture.springOrbit(validate);
                AdapterFixture spoilt = AdapterFixture.springOrbit(validate)) {
            spoilt.adapter.laws().load(0, "writes_nan", badFrom(BAD_STEP));
            for (int frame = 0; frame < 20; frame++) {
                clean.run(1);
                spoilt.run(1);
                assertThat(spoilt.bytes()).isEqualTo(clean.bytes());
                assertThat(spoilt.adapter.stateHash()).isEqualTo(clean.adapter.stateHash());
            }
            assertThat(spoilt.adapter.profile().redoneFrames()).isOne();
        }
    }

    /** Number of values that the law writes. Each value causes a repeated frame. */
    private static final int EXTREMES = Integer.getInteger("reve.test.extremes", 60);

    private static final List<String> WRITTEN =
            List.of("position", "velocity", "orientation", "angularVelocity");

    @Test
    void aNumberThatIsNotFiniteNeverReachesTheStore() {
        List<ItemDefinition> bodies = new ArrayList<>();
        for (int i = 0; i < 10_000; i++) {
            bodies.add(AdapterFixture.body("b" + i, 1, i, 2 * i, 0, 0, 1, 0));
        }
        Random random = new Random(1904);
        try (AdapterFixture clean = inPlace(bodies).load("newton_motion", "wind");
                AdapterFixture spoilt = inPlace(bodies).load("newton_motion", "wind")) {
            for (int i = 1; i <= EXTREMES; i++) {
                int place = random.nextInt(12 * bodies.size());
                spoilt.adapter.laws().load(0, "writes_extreme", Map.of("place", (double) place));
                clean.run(1);
                spoilt.run(1);
                assertThat(spoilt.adapter.stateHash())
                        .as("place " + place)
                        .isEqualTo(clean.adapter.stateHash());
                assertThat(spoilt.events("fault")).hasSize(i);
                assertThat(spoilt.events("fault").getLast().fields())
                        .containsEntry("status", "LAW_MISBEHAVED")
                        .containsEntry("property", WRITTEN.get(place / 3 % 4))
                        .containsEntry("item", "b" + place / 12);
                Laws laws = spoilt.adapter.laws();
                laws.quarantined().forEach(out -> laws.release(out.sha256()));
            }
            assertThat(spoilt.adapter.profile().redoneFrames()).isEqualTo(EXTREMES);
        }
    }

    private static AdapterFixture inPlace(List<ItemDefinition> items) {
        return new AdapterFixture(
                WorldPrototype.standard("si-f64"),
                items,
                new OffHeapArena(),
                false,
                engine -> engine);
    }

    /** The law with an error is the cause, even if acts and edits changed the world. */
    @ParameterizedTest
    @ValueSource(strings = {"red", "blue"})
    void aLawThatFailsWithoutASuspectTooLeavesAWorldThatNeverHadIt(String changed) {
        try (AdapterFixture clean = AdapterFixture.springOrbit();
                AdapterFixture spoilt = AdapterFixture.springOrbit()) {
            for (String name : new String[] {"red", changed}) {
                spoilt.world.arrests().suspect(spoilt.world.find(name).orElseThrow().id());
            }
            spoilt.adapter.laws().load(0, "writes_nan", badFrom(BAD_STEP));
            for (int frame = 0; frame < 20; frame++) {
                clean.run(1);
                spoilt.run(1);
                assertThat(spoilt.bytes()).isEqualTo(clean.bytes());
                assertThat(spoilt.adapter.stateHash()).isEqualTo(clean.adapter.stateHash());
            }
            assertThat(spoilt.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("library", "writes_nan")
                                            .doesNotContainKey("arrested"));
        }
    }

    @Test
    void theFaultNamesFrameLibraryLawPropertyAndItem() {
        try (AdapterFixture spoilt = AdapterFixture.springOrbit()) {
            spoilt.adapter.laws().load(0, "writes_nan", badFrom(BAD_STEP));
            spoilt.run(10);
            WorldEvent fault = spoilt.events("fault").getFirst();
            assertThat(spoilt.events("fault")).hasSize(1);
            assertThat(fault.frame()).isEqualTo(6);
            assertThat(fault.fields())
                    .containsEntry("library", "writes_nan")
                    .containsEntry("law", "writes_nan")
                    .containsEntry("property", "velocity")
                    .containsEntry("row", 1L)
                    .containsEntry("item", "blue")
                    .containsEntry("status", "LAW_MISBEHAVED")
                    .containsKey("milliseconds");
            assertThat((long) fault.fields().get("calls")).isGreaterThanOrEqualTo(BAD_STEP);
            assertThat(fault.fields().get("message"))
                    .asString()
                    .startsWith("after " + BAD_STEP + " steps: law writes_nan: property velocity, ")
                    .contains("row 1: wrote nan");
        }
    }

    @Test
    void theSameBytesAreRefusedUntilReleased() {
        try (AdapterFixture spoilt = AdapterFixture.springOrbit()) {
            Laws laws = spoilt.adapter.laws();
            laws.load(0, "returns_failure", badFrom(0));
            spoilt.run(1);
            Quarantined out = laws.quarantined().getFirst();
            assertThat(out.library()).isEqualTo("returns_failure");
            assertThat(out.frame()).isEqualTo(1);
            assertThat(out.status()).isEqualTo(Status.LAW_FAILED);
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> laws.load(1, "returns_failure", Map.of()))
                    .withMessageContaining("in quarantine since frame 1")
                    .withMessageContaining("too many for this law");
            assertThat(laws.release(out.sha256())).isTrue();
            assertThat(laws.release(out.sha256())).isFalse();
            laws.load(1, "returns_failure", badFrom(1e9));
            spoilt.run(1);
            assertThat(laws.loaded()).extracting(PhysicsLaw::library).contains("returns_failure");
        }
    }

    @Test
    void aRefusedParameterEndsNoQuarantine() {
        try (AdapterFixture spoilt = AdapterFixture.springOrbit()) {
            Laws laws = spoilt.adapter.laws();
            laws.load(0, "returns_failure", badFrom(0));
            laws.load(0, "wind", Map.of());
            spoilt.run(1);
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> laws.setParameters(1, "wind", Map.of("nonsense", 1.0)));
            assertThat(laws.quarantined())
                    .extracting(Quarantined::library)
                    .containsExactly("returns_failure");
        }
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void severalBadLawsOfOneFrameAllGo(boolean validate) {
        try (AdapterFixture clean = AdapterFixture.springOrbit(validate);
                AdapterFixture spoilt = AdapterFixture.springOrbit(validate)) {
            spoilt.adapter.laws().load(0, "returns_failure", badFrom(BAD_STEP));
            spoilt.adapter.laws().load(0, "writes_nan", badFrom(BAD_STEP));
            clean.run(10);
            spoilt.run(10);
            assertThat(spoilt.bytes()).isEqualTo(clean.bytes());
            assertThat(spoilt.events("fault"))
                    .extracting(WorldEvent::frame)
                    .containsExactly(6L, 6L);
            assertThat(spoilt.adapter.profile().redoneFrames()).isEqualTo(2);
            assertThat(spoilt.adapter.laws().loaded())
                    .extracting(PhysicsLaw::library)
                    .containsExactly(SpringOrbit.LAWS);
        }
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void aLawThatFailsBesideAnAccumulatorRestoresTheForcesToo(boolean validate) {
        try (AdapterFixture clean = AdapterFixture.springOrbit(validate).load("wind");
                AdapterFixture spoilt =
                        AdapterFixture.springOrbit(validate).load("wind", "returns_failure")) {
            clean.run(3);
            spoilt.run(3);
            assertThat(spoilt.bytes()).isEqualTo(clean.bytes());
        }
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void theLastLawMayFail(boolean validate) {
        try (AdapterFixture still =
                new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        AdapterFixture.springOrbitItems(),
                        new OffHeapArena(),
                        validate,
                        engine -> engine)) {
            var before = still.bytes();
            still.load("returns_failure").run(2);
            assertThat(still.bytes()).isEqualTo(before);
            assertThat(still.adapter.laws().loaded()).isEmpty();
            assertThat(still.engine.stepCount()).isEqualTo(8);
        }
    }

    @Test
    void accumulatorsThatNoLawUsesArePutBackToo() {
        FailingEngine[] bug = new FailingEngine[1];
        try (AdapterFixture still =
                new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        AdapterFixture.springOrbitItems(),
                        new OffHeapArena(),
                        true,
                        engine -> bug[0] = new FailingEngine(engine))) {
            Item red = still.world.find("red").orElseThrow();
            red.physics().set("torque", 1, 2, 3);
            bug[0].broken = true;
            still.run(1);
            assertThat(red.physics().vector("torque")).containsExactly(1, 2, 3);
            bug[0].broken = false;
            still.run(1);
            assertThat(red.physics().vector("torque")).containsOnly(0);
        }
    }

    @Test
    void aFailureThatNoLawIsToBlameForStopsPhysicsForTheFrameAndIsReported() {
        FailingEngine[] bug = new FailingEngine[1];
        try (AdapterFixture orbit =
                new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        AdapterFixture.springOrbitItems(),
                        new OffHeapArena(),
                        true,
                        engine -> bug[0] = new FailingEngine(engine))) {
            orbit.load(SpringOrbit.LAWS).run(3);
            var before = orbit.bytes();
            bug[0].broken = true;
            orbit.run(2);
            assertThat(orbit.bytes()).isEqualTo(before);
            assertThat(orbit.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("message", "lost a step"));
            assertThat(orbit.adapter.laws().loaded()).hasSize(2);
            bug[0].broken = false;
            orbit.run(1);
            assertThat(orbit.bytes()).isNotEqualTo(before);
        }
    }

    private static Map<String, Double> badFrom(double step) {
        return Map.of("from_step", step);
    }
}
