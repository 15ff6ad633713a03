// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;
import static org.assertj.core.api.Assertions.offset;
import static org.assertj.core.api.Assertions.tuple;
import static org.assertj.core.api.Assertions.withinPercentage;

import org.junit.jupiter.api.Test;

import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.lang.management.ManagementFactory;
import java.nio.file.Files;
import java.security.MessageDigest;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HexFormat;
import java.util.List;
import java.util.Map;
import java.util.Set;

/** The behaviour that every engine has in any process. */
public abstract class EngineContract {
    /** Returns the kind of engine under test. */
    protected abstract EngineFixture.Home home();

    @Test
    void springOrbitKeepsItsInvariants() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            var before = SpringOrbit.invariants(orbit.get("position"), orbit.get("velocity"));
            orbit.engine.advance(SpringOrbit.DT, SpringOrbit.STEPS);
            var after = SpringOrbit.invariants(orbit.get("position"), orbit.get("velocity"));
            assertThat(after.momentum()).containsExactly(before.momentum(), offset(3000 * 1e-12));
            assertThat(after.energyAroundCentre())
                    .isCloseTo(before.energyAroundCentre(), withinPercentage(3e-3));
            assertThat(after.distance()).isBetween(20.00, 20.01);
            assertThat(after.turnedDegrees()).isCloseTo(43.0, offset(0.1));
            assertThat(orbit.engine.stepCount()).isEqualTo(SpringOrbit.STEPS);
        }
    }

    @Test
    void twoRunsEndInTheSameStateHashHoweverTheStepsAreGrouped() {
        try (EngineFixture one = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS);
                EngineFixture other =
                        new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            assertThat(one.engine.stateHash()).isEqualTo(other.engine.stateHash());
            one.engine.advance(SpringOrbit.DT, SpringOrbit.STEPS);
            for (int i = 0; i < SpringOrbit.STEPS / 4; i++) {
                other.engine.advance(SpringOrbit.DT, 4);
            }
            assertThat(one.engine.stateHash()).isEqualTo(other.engine.stateHash());
            other.engine.advance(SpringOrbit.DT, 1);
            assertThat(one.engine.stateHash()).isNotEqualTo(other.engine.stateHash());
        }
    }

    @Test
    void loadedLawsSayWhatTheyUse() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            orbit.engine.advance(SpringOrbit.DT, 3);
            List<PhysicsLaw> laws = orbit.engine.laws();
            assertThat(laws)
                    .extracting(PhysicsLaw::name)
                    .containsExactly("hooke_spring", "newton_motion");
            PhysicsLaw motion = laws.get(1);
            assertThat(motion.phase()).isEqualTo(Phase.INTEGRATE);
            assertThat(motion.calls()).isEqualTo(3); // after the forces of each step
            assertThat(motion.uses())
                    .filteredOn(use -> use.name().equals("position"))
                    .extracting(PropertyUse::access)
                    .containsExactly(Set.of(Access.READ, Access.WRITE));
        }
    }

    @Test
    void aLawWithAnIntervalActsInEveryNthStepWithAllItsForce() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load("newton_motion")) {
            int wind = orbit.engine.loadPhysicsLaw("wind", Map.of("force", 2.0));
            orbit.engine.setInterval(wind, 3);
            for (double velocity : new double[] {6, 6, 6, 12}) {
                orbit.engine.advance(1, 1);
                assertThat(orbit.get("velocity")[3]).isEqualTo(velocity);
            }
            assertThat(orbit.engine.laws().getLast().calls()).isEqualTo(2);
            orbit.engine.setInterval(wind, 0);
            orbit.engine.advance(1, 4);
            assertThat(orbit.get("velocity")[3]).isEqualTo(12.0);
            orbit.engine.setInterval(wind, 1);
            orbit.engine.advance(1, 1);
            assertThat(orbit.get("velocity")[3]).isEqualTo(14.0);
            int motion = orbit.engine.laws().getFirst().libraryId();
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> orbit.engine.setInterval(motion, 2))
                    .withMessageContaining("law newton_motion is no force law");
        }
    }

    @Test
    void timesAreThoseOfTheLaws() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            long[] times = new long[SpringOrbit.LAWS.length];
            orbit.engine.advance(SpringOrbit.DT, 3);
            orbit.engine.readTimes(times);
            assertThat(times)
                    .containsExactly(
                            orbit.engine.laws().stream()
                                    .mapToLong(PhysicsLaw::nanoseconds)
                                    .toArray());
            assertThat(Arrays.stream(times).min().orElseThrow()).isPositive();
        }
    }

    @Test
    void anUnloadedLawActsNoMore() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load("newton_motion")) {
            int wind = orbit.engine.loadPhysicsLaw("wind", Map.of("force", 2.0));
            orbit.engine.advance(1, 1);
            assertThat(orbit.get("velocity")[3]).isEqualTo(2.0); // F/m t of the 1 kg body
            orbit.engine.unloadPhysicsLaw(wind);
            orbit.engine.advance(1, 1);
            assertThat(orbit.get("velocity")[3]).isEqualTo(2.0);
            assertThat(orbit.engine.laws())
                    .extracting(PhysicsLaw::name)
                    .containsExactly("newton_motion");
        }
    }

    @Test
    void undoneChangesLeaveNoTrace() {
        try (EngineFixture changed =
                        new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS);
                EngineFixture expected =
                        new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            changed.engine.advance(SpringOrbit.DT, 4);
            expected.engine.advance(SpringOrbit.DT, 4);
            List<Integer> ids = changed.engine.laws().stream().map(PhysicsLaw::libraryId).toList();
            for (int round = 0; round < 3; round++) {
                changed.engine.beginChanges();
                ids.forEach(changed.engine::unloadPhysicsLaw);
                changed.load("newton_motion", "wind");
                changed.engine.setStepCount(99, 0.5);
                changed.engine.endChanges(false);
            }
            changed.engine.advance(SpringOrbit.DT, 4);
            expected.engine.advance(SpringOrbit.DT, 4);
            assertThat(changed.engine.laws())
                    .extracting(PhysicsLaw::libraryId, PhysicsLaw::name, PhysicsLaw::calls)
                    .containsExactly(
                            tuple(ids.get(0), "hooke_spring", 8L),
                            tuple(ids.get(1), "newton_motion", 8L));
            assertThat(changed.engine.stateHash()).isEqualTo(expected.engine.stateHash());
            assertThat(changed.engine.saveState()).isEqualTo(expected.engine.saveState());
        }
    }

    @Test
    void aReplacedLawKeepsItsIdAndPlace() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS);
                EngineFixture expected =
                        new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS);
                PreparedLibrary again = orbit.engine.prepare("hooke_spring");
                PreparedLibrary rival = orbit.engine.prepare("newton_motion")) {
            int spring = orbit.engine.laws().getFirst().libraryId();
            orbit.engine.advance(SpringOrbit.DT, 4);
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> orbit.engine.replacePhysicsLaw(spring, rival, Map.of()))
                    .satisfies(e -> assertThat(e.status()).isEqualTo(Status.ALREADY_EXISTS));
            orbit.engine.replacePhysicsLaw(spring, again, Map.of());
            assertThatIllegalStateException()
                    .isThrownBy(() -> orbit.engine.replacePhysicsLaw(spring, again, Map.of()));
            orbit.engine.advance(SpringOrbit.DT, 4);
            expected.engine.advance(SpringOrbit.DT, 8);
            assertThat(orbit.engine.laws())
                    .extracting(PhysicsLaw::libraryId, PhysicsLaw::name, PhysicsLaw::calls)
                    .containsExactly(
                            tuple(spring, "hooke_spring", 4L),
                            tuple(spring + 1, "newton_motion", 8L));
            assertThat(orbit.engine.stateHash()).isEqualTo(expected.engine.stateHash());
        }
    }

    @Test
    void keptChangesStay() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            int spring = orbit.engine.laws().getFirst().libraryId();
            orbit.engine.beginChanges();
            orbit.engine.unloadPhysicsLaw(spring);
            assertThatIllegalStateException().isThrownBy(orbit.engine::beginChanges);
            orbit.engine.endChanges(true);
            assertThatIllegalStateException().isThrownBy(() -> orbit.engine.endChanges(true));
            orbit.engine.advance(SpringOrbit.DT, 4);
            assertThat(orbit.engine.laws())
                    .extracting(PhysicsLaw::name)
                    .containsExactly("newton_motion");
        }
    }

    @Test
    void theLedgerSaysWhichLawGaveWhat() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit()) {
            orbit.engine.setLedger(true);
            orbit.load("hooke_spring", "newton_motion");
            int wind = orbit.engine.loadPhysicsLaw("wind", Map.of("force", 2.0));
            orbit.engine.advance(0.25, 4);
            List<LedgerLine> lines = orbit.engine.ledger();
            assertThat(lines)
                    .extracting(LedgerLine::name)
                    .containsExactly(
                            "hooke_spring",
                            "newton_motion",
                            "wind",
                            "client",
                            "ground",
                            "unloaded",
                            "total");
            assertThat(lines)
                    .extracting(LedgerLine::law)
                    .containsExactly(true, true, true, false, false, false, false);
            LedgerLine spring = lines.get(0);
            LedgerLine total = lines.get(6);
            assertThat(spring.momentum()).allSatisfy(p -> assertThat(p).isCloseTo(0, offset(1e-9)));
            assertThat(lines.get(2).momentum()).containsExactly(4.0, 0.0, 0.0); // 2 bodies, 1 s
            assertThat(total.momentum().get(0)).isCloseTo(4, offset(1e-9));
            assertThat(spring.hasPotentialEnergy()).isTrue();
            assertThat(total.energy())
                    .isCloseTo(spring.energy() + lines.get(2).energy(), withinPercentage(1e-6));
            orbit.engine.unloadPhysicsLaw(wind);
            assertThat(orbit.engine.ledger().get(4).momentum()).containsExactly(4.0, 0.0, 0.0);
            orbit.engine.setLedger(false);
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(orbit.engine::ledger)
                    .withMessageContaining("the ledger is off");
        }
    }

    @Test
    void sharedValuesReachLawsThroughIndices() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit()) {
            MemorySegment masses = orbit.allocate(24);
            MemorySegment.copy(new double[] {4, 8, 16}, 0, masses, ValueLayout.JAVA_DOUBLE, 0, 3);
            MemorySegment indices = orbit.allocate(8);
            indices.set(ValueLayout.JAVA_INT, 0, 2);
            orbit.engine.propertyProvider().rebindPhysicalProperty("mass", masses, 3, indices, 2);
            orbit.load("newton_motion", "wind").engine.advance(1, 1);
            assertThat(orbit.get("velocity")).containsExactly(1.0 / 16, 3, 0, 1.0 / 4, 0, 0);
        }
    }

    @Test
    void aPropertyIsFoundAsItIsBound() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit()) {
            PhysicalPropertyProvider provider = orbit.engine.propertyProvider();
            long version = provider.findPhysicalProperty("velocity").version();
            provider.touch("velocity");
            var velocity = provider.findPhysicalProperty("velocity");
            assertThat(velocity.version()).isGreaterThan(version);
            assertThat(velocity.rowCount()).isEqualTo(2);
            assertThat(velocity.components()).isEqualTo(3);
            assertThat(velocity.lawAccess()).isEqualTo(Set.of(Access.READ, Access.WRITE));
            provider.removePhysicalProperty("charge");
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> provider.findPhysicalProperty("charge"));
        }
    }

    @Test
    void logLinesOfLawsArriveWithTheirLevel() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load("greets")) {
            orbit.engine.advance(SpringOrbit.DT, 2);
            assertThat(orbit.log)
                    .filteredOn(line -> line.contains("greetings from a law"))
                    .hasSize(2)
                    .allMatch(line -> line.startsWith("WARNING "));
        }
    }

    @Test
    void aLogThatThrowsHarmsNobody() {
        VesperConfig config =
                new VesperConfig(
                        1,
                        true,
                        NativeFiles.lawPath(),
                        (level, message) -> {
                            throw new IllegalStateException("disk full");
                        });
        try (EngineFixture.Home home = home();
                PhysicsEngine engine =
                        home.engine(config, VesperEngine.standardPrototype("si-f64"))) {
            engine.propertyProvider().addPhysicalProperty("mass", home.allocate(8), 1);
            engine.loadPhysicsLaw("greets", Map.of());
            engine.advance(SpringOrbit.DT, 2);
            assertThat(engine.stepCount()).isEqualTo(2);
        }
    }

    @Test
    void aPreparedLibraryIsKnownByItsContent() throws Exception {
        try (EngineFixture orbit = new EngineFixture(home());
                PreparedLibrary wind = orbit.engine.prepare("wind")) {
            byte[] bytes = Files.readAllBytes(NativeFiles.testLaw("wind"));
            assertThat(wind.name()).isEqualTo("wind");
            assertThat(wind.sha256())
                    .isEqualTo(
                            HexFormat.of()
                                    .formatHex(MessageDigest.getInstance("SHA-256").digest(bytes)));
        }
    }

    @Test
    void aPreparedLibraryIsTakenOnce() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit();
                PreparedLibrary wind = orbit.engine.prepare("wind")) {
            orbit.engine.loadPhysicsLaw(wind, Map.of());
            assertThatIllegalStateException()
                    .isThrownBy(() -> orbit.engine.loadPhysicsLaw(wind, Map.of()))
                    .withMessageContaining("'wind' was taken by an engine or closed");
        }
    }

    @Test
    void aRefusedLibraryStaysWithTheCaller() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit();
                PreparedLibrary wind = orbit.engine.prepare("wind")) {
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> orbit.engine.loadPhysicsLaw(wind, Map.of("force", 101.0)));
            orbit.engine.loadPhysicsLaw(wind, Map.of("force", 100.0));
            assertThat(orbit.engine.laws()).hasSize(1);
        }
    }

    @Test
    void aClosedEngineSaysSo() {
        EngineFixture orbit = new EngineFixture(home()).springOrbit();
        orbit.close();
        orbit.engine.close();
        assertThatIllegalStateException()
                .isThrownBy(() -> orbit.engine.advance(1, 1))
                .withMessage("the engine is closed");
        assertThatIllegalStateException()
                .isThrownBy(() -> orbit.engine.propertyProvider().touch("mass"));
    }

    @Test
    void memoryClosedUnderTheEngineIsNamedBeforeCTouchesIt() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            MemorySegment gone = orbit.allocate(16);
            orbit.engine.propertyProvider().rebindPhysicalProperty("mass", gone, 2);
            orbit.release(gone);
            assertThatIllegalStateException()
                    .isThrownBy(() -> orbit.engine.advance(SpringOrbit.DT, 1))
                    .withMessageContaining("[mass]");
            assertThatIllegalStateException().isThrownBy(orbit.engine::stateHash);
            orbit.engine
                    .propertyProvider()
                    .rebindPhysicalProperty("mass", orbit.arrays.get("mass"), 2);
            orbit.engine.advance(SpringOrbit.DT, 1);
            assertThat(orbit.engine.stepCount()).isOne();
        }
    }

    @Test
    void arraysThatCannotBeLentAreRefused() {
        try (EngineFixture orbit = new EngineFixture(home())) {
            PhysicalPropertyProvider provider = orbit.engine.propertyProvider();
            assertThatIllegalArgumentException()
                    .isThrownBy(
                            () -> provider.addPhysicalProperty("velocity", orbit.allocate(47), 2))
                    .withMessage("velocity: data has 47 bytes, expected at least 48 (2 x 24)");
            assertThatIllegalArgumentException()
                    .isThrownBy(
                            () ->
                                    provider.addPhysicalProperty(
                                            "mass", MemorySegment.ofArray(new double[2]), 2))
                    .withMessage("mass: data is heap memory, expected native memory");
            assertThatIllegalArgumentException()
                    .isThrownBy(
                            () ->
                                    provider.addPhysicalProperty(
                                            "mass", orbit.allocate(16), 2, orbit.allocate(4), 2))
                    .withMessageContaining("mass: indices has 4 bytes, expected at least 8");
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> provider.addPhysicalProperty("mass", orbit.allocate(16), -1));
        }
    }

    @Test
    void aSteadyAdvanceAllocatesNothing() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            var threads = (com.sun.management.ThreadMXBean) ManagementFactory.getThreadMXBean();
            int frames = 100;
            long least = Long.MAX_VALUE; // because a delayed frame may allocate
            for (int window = 0; window < 400; window++) {
                long before = threads.getCurrentThreadAllocatedBytes();
                for (int i = 0; i < frames; i++) {
                    orbit.engine.advance(SpringOrbit.DT, 1);
                }
                least = Math.min(least, threads.getCurrentThreadAllocatedBytes() - before);
            }
            assertThat(least).isLessThan(frames);
        }
    }

    @Test
    void aPropertyOfTheClientsOwnTravelsWithTheOthers() {
        Prototype standard = VesperEngine.standardPrototype("si-f64");
        List<PropertyDescriptor> properties = new ArrayList<>(standard.properties());
        properties.add(
                new PropertyDescriptor(
                        "temperature",
                        "body",
                        ScalarType.F64,
                        1,
                        Set.of(Access.READ, Access.WRITE),
                        SiUnit.of(new byte[] {0, 0, 0, 0, 1, 0, 0}, 1, "K"),
                        null,
                        null,
                        "Of the surface."));
        try (EngineFixture warm =
                new EngineFixture(
                                home(),
                                new Prototype("warm", ScalarType.F64, SiUnit.SECOND, properties))
                        .springOrbit()) {
            long cold = warm.engine.stateHash();
            warm.set("temperature", 300, 0);
            assertThat(warm.engine.stateHash()).isNotEqualTo(cold);
        }
    }
}
