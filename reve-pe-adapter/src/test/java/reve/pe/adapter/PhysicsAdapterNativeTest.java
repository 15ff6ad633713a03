// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.offset;
import static org.assertj.core.api.Assertions.withinPercentage;

import org.junit.jupiter.api.Test;

import reve.core.unit.Unit;
import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.PhysicsLaw;
import reve.pe.SpringOrbit;

import java.lang.foreign.ValueLayout;
import java.lang.management.ManagementFactory;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.channels.FileChannel;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;

class PhysicsAdapterNativeTest {
    @Test
    void springOrbitKeepsItsInvariants() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit()) {
            var before = invariants(orbit);
            orbit.run(AdapterFixture.FRAMES);
            var after = invariants(orbit);
            assertThat(after.momentum()).containsExactly(before.momentum(), offset(3000 * 1e-12));
            assertThat(after.energyAroundCentre())
                    .isCloseTo(before.energyAroundCentre(), withinPercentage(3e-3));
            assertThat(after.distance()).isBetween(20.00, 20.01);
            assertThat(after.turnedDegrees()).isCloseTo(43.0, offset(0.1));
        }
    }

    @Test
    void twoRunsEndInTheSameState() {
        try (AdapterFixture one = AdapterFixture.springOrbit();
                AdapterFixture other = AdapterFixture.springOrbit()) {
            one.run(AdapterFixture.FRAMES);
            other.run(AdapterFixture.FRAMES);
            assertThat(one.adapter.stateHash()).isEqualTo(other.adapter.stateHash());
            assertThat(one.bytes()).isEqualTo(other.bytes());
        }
    }

    @Test
    void sceneryIsNotMoved() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit()) {
            Item tree = orbit.world.add(ItemDefinition.named("tree").at(1, 2, 3).build());
            orbit.load("wind").run(10);
            assertThat(tree.physical().location()).containsExactly(1, 2, 3);
            assertThat(orbit.velocity("blue")[0]).isNotZero();
        }
    }

    @Test
    void sceneryThatGetsAMassTakesPartFromTheNextFrameOn() {
        try (AdapterFixture world = new AdapterFixture().load("wind", "newton_motion")) {
            Item stone = world.world.add(ItemDefinition.named("stone").at(0, 0, 0).build());
            world.run(1);
            stone.physics().set("mass", 2);
            world.run(1);
            assertThat(world.velocity("stone")[0]).isCloseTo(0.5 / 60, offset(1e-15));
        }
    }

    /** There are 4 steps per frame. Nothing moves the bodies. */
    @Test
    void whatLawsRememberOfAnItemStaysWithItWhenOthersComeAndGo() {
        try (AdapterFixture world = new AdapterFixture().load("counts_years")) {
            for (String name : List.of("a", "b", "c", "d")) {
                world.world.add(AdapterFixture.body(name, 1, 0, 0, 0, 0, 0, 0));
                world.run(1);
            }
            assertThat(ages(world, "a", "b", "c", "d")).containsExactly(16.0, 12.0, 8.0, 4.0);
            assertThat(world.adapter.laws().loaded().getFirst().uses().getFirst().access())
                    .containsExactly(Access.SCRATCH);
            remove(world, "a"); // d takes its row
            remove(world, "b"); // c takes its row
            world.world.add(AdapterFixture.body("e", 1, 0, 0, 0, 0, 0, 0)); // where c was
            world.run(1);
            assertThat(ages(world, "c", "d", "e")).containsExactly(12.0, 8.0, 4.0);
            remove(world, "d");
            remove(world, "e");
            world.world.add(AdapterFixture.body("f", 1, 0, 0, 0, 0, 0, 0));
            world.run(1);
            assertThat(ages(world, "c", "f")).containsExactly(16.0, 4.0);
        }
    }

    private static void remove(AdapterFixture world, String item) {
        world.world.remove(world.world.find(item).orElseThrow().id());
    }

    private static List<Double> ages(AdapterFixture world, String... items) {
        return Arrays.stream(items).map(item -> world.velocity(item)[0]).toList();
    }

    @Test
    void anEditReachesTheLawsInTheNextFrame() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit()) {
            orbit.run(1);
            orbit.world.find("blue").orElseThrow().physics().set("velocity", 0, 0, 6);
            double[] before = orbit.world.find("blue").orElseThrow().physical().location();
            orbit.run(1);
            double[] after = orbit.world.find("blue").orElseThrow().physical().location();
            assertThat(after[2] - before[2]).isCloseTo(6.0 / 60, offset(1e-4));
        }
    }

    @Test
    void aSpringHungElsewherePullsTheOther() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit()) {
            Item green = orbit.world.add(AdapterFixture.body("green", 1, 10, 25, 0, 0, 0, 0));
            orbit.run(1);
            assertThat(orbit.velocity("green")).containsOnly(0);
            orbit.world.find("band").orElseThrow().physics().setReferences("end2", green.id());
            orbit.run(1);
            assertThat(orbit.velocity("green")[1]).isNegative();
        }
    }

    @Test
    void aReferenceThatLeadsNowhereStopsPhysicsAndIsNamed() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit().run(1)) {
            long tree = orbit.world.add(ItemDefinition.named("tree").build()).id().value();
            long blue = orbit.world.find("blue").orElseThrow().id().value();
            Column end = orbit.world.table("spring").column("end2");
            var before = orbit.motion("blue");
            for (long target : new long[] {0, 999, tree}) {
                end.segment().set(ValueLayout.JAVA_LONG, 0, target);
                end.touch();
                orbit.run(1);
            }
            assertThat(orbit.motion("blue")).isEqualTo(before);
            assertThat(orbit.events("fault"))
                    .extracting(event -> String.valueOf(event.fields().get("message")))
                    .satisfiesExactly(
                            nothing ->
                                    assertThat(nothing)
                                            .contains("band")
                                            .contains(
                                                    "end2 refers to nothing, expected a body with"
                                                            + " physics"),
                            scenery ->
                                    assertThat(scenery)
                                            .contains("band", "end2", "tree")
                                            .contains("which has no physics aspect"));
            end.segment().set(ValueLayout.JAVA_LONG, 0, blue);
            end.touch();
            orbit.run(1);
            assertThat(orbit.motion("blue")).isNotEqualTo(before);
        }
    }

    @Test
    void rowsThatMoveTakeTheirSpringsAlong() {
        try (AdapterFixture alone = AdapterFixture.springOrbit();
                AdapterFixture crowded = crowdedOrbit()) {
            alone.run(20);
            crowded.run(10);
            crowded.world.remove(crowded.world.find("first").orElseThrow().id());
            crowded.run(10);
            assertThat(crowded.motion("red")).isEqualTo(alone.motion("red"));
            assertThat(crowded.motion("blue")).isEqualTo(alone.motion("blue"));
        }
    }

    @Test
    void columnsThatGrowPastTheirMemoryGoOnExactly() {
        try (AdapterFixture alone = AdapterFixture.springOrbit();
                AdapterFixture growing = AdapterFixture.springOrbit()) {
            alone.run(30);
            for (int frame = 0; frame < 30; frame++) {
                for (int i = 0; i < 10; i++) {
                    String name = frame + "-" + i;
                    growing.world.add(AdapterFixture.body("b" + name, 1, 0, 0, 0, 1, 0, 0));
                    growing.world.add(
                            ItemDefinition.named("s" + name)
                                    .kind("spring")
                                    .physics("springConstant", 0)
                                    .reference("end1", "red")
                                    .reference("end2", "b" + name)
                                    .build());
                }
                growing.run(1);
            }
            assertThat(growing.motion("blue")).isEqualTo(alone.motion("blue"));
            assertThat(growing.motion("b0-0").getFirst())
                    .isEqualTo(Double.doubleToRawLongBits(sumOfSteps(120)));
        }
    }

    @Test
    void aWorldInSharedMemoryMovesAlikeAndIsReadThroughItsDescriptors() throws Exception {
        try (AdapterFixture orbit = AdapterFixture.springOrbit();
                SharedArena arena = new SharedArena();
                AdapterFixture shared =
                        new AdapterFixture(
                                WorldPrototype.standard("si-f64"),
                                AdapterFixture.springOrbitItems(),
                                arena,
                                true,
                                engine -> engine)) {
            shared.load(SpringOrbit.LAWS).run(10);
            orbit.run(10);
            assertThat(shared.bytes()).isEqualTo(orbit.bytes());
            Column position = shared.world.table("body").column("position");
            Path file = Path.of("/proc/self/fd/" + arena.part(position.segment()).descriptor());
            ByteBuffer bytes = ByteBuffer.allocate(8).order(ByteOrder.nativeOrder());
            try (FileChannel other = FileChannel.open(file, StandardOpenOption.READ)) {
                other.read(bytes, 24);
            }
            assertThat(bytes.getDouble(0)).isEqualTo(position.getDouble(1, 0));
        }
    }

    @Test
    void aPropertyOfTheDesignersIsLent() {
        WorldPrototype prototype =
                WorldPrototype.standard("si-f64")
                        .extendedBy(
                                List.of(
                                        new PropertyDescriptor(
                                                "temperature",
                                                "body",
                                                ScalarType.F32,
                                                1,
                                                Unit.parse("K"),
                                                Optional.empty(),
                                                "")));
        try (AdapterFixture warm =
                new AdapterFixture(
                        prototype,
                        AdapterFixture.springOrbitItems(),
                        new OffHeapArena(),
                        true,
                        engine -> engine)) {
            long cold = warm.adapter.stateHash();
            warm.world.find("red").orElseThrow().physics().set("temperature", 300);
            assertThat(warm.adapter.stateHash()).isNotEqualTo(cold);
            assertThat(
                            warm.engine
                                    .propertyProvider()
                                    .findPhysicalProperty("temperature")
                                    .rowCount())
                    .isEqualTo(2);
        }
    }

    @Test
    void aLoadedLawIsToldAndListed() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit().run(1)) {
            assertThat(orbit.events("law-loaded"))
                    .hasSize(2)
                    .first()
                    .satisfies(
                            event ->
                                    assertThat(event.fields())
                                            .containsEntry("library", "hooke_spring")
                                            .containsEntry("laws", "hooke_spring")
                                            .containsKey("sha256"));
            int wind = orbit.adapter.laws().load(1, "wind", Map.of("force", 3.0));
            orbit.run(1);
            orbit.adapter.laws().unload(2, wind);
            orbit.run(1);
            assertThat(orbit.events("law-unloaded"))
                    .singleElement()
                    .satisfies(
                            event -> {
                                assertThat(event.fields())
                                        .containsEntry("library", "wind")
                                        .containsEntry("calls", 4L);
                                assertThat((double) event.fields().get("milliseconds"))
                                        .isPositive();
                            });
            assertThat(orbit.adapter.laws().loaded())
                    .extracting(PhysicsLaw::library)
                    .containsExactly(SpringOrbit.LAWS);
            assertThat(orbit.adapter.laws().isLoaded(wind)).isFalse();
        }
    }

    @Test
    void theProfileCountsFramesAndTime() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit().run(7)) {
            AdapterProfile profile = orbit.adapter.profile();
            assertThat(profile.frames()).isEqualTo(7);
            assertThat(profile.redoneFrames()).isZero();
            assertThat(profile.advanceNanoseconds()).isPositive();
            assertThat(profile.bindNanoseconds()).isPositive();
            assertThat(profile.copyNanoseconds()).isPositive();
        }
    }

    @Test
    void aSteadyFrameAllocatesNothing() {
        try (AdapterFixture orbit = AdapterFixture.springOrbit()) {
            var threads = (com.sun.management.ThreadMXBean) ManagementFactory.getThreadMXBean();
            orbit.run(5000);
            long before = threads.getCurrentThreadAllocatedBytes();
            orbit.run(5000);
            assertThat(threads.getCurrentThreadAllocatedBytes() - before).isLessThan(5000);
        }
    }

    private static AdapterFixture crowdedOrbit() {
        AdapterFixture crowded = new AdapterFixture();
        crowded.world.add(AdapterFixture.body("first", 1, 0, 0, 0, 0, 0, 1));
        crowded.world.addAll(AdapterFixture.springOrbitItems());
        return crowded.load(SpringOrbit.LAWS);
    }

    private static double sumOfSteps(int steps) {
        double x = 0;
        for (int i = 0; i < steps; i++) {
            x += 1.0 / 240;
        }
        return x;
    }

    private static SpringOrbit.Invariants invariants(AdapterFixture orbit) {
        return SpringOrbit.invariants(
                orbit.world
                        .table("body")
                        .column("position")
                        .segment()
                        .toArray(ValueLayout.JAVA_DOUBLE),
                orbit.world
                        .table("body")
                        .column("velocity")
                        .segment()
                        .toArray(ValueLayout.JAVA_DOUBLE));
    }
}
