// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.WorldEvent;
import reve.pe.PhysicsLaw;

import java.util.List;
import java.util.Map;

/** Laws that fail because of the numbers of another law. */
class BlameNativeTest {
    private static final int FRAMES = 5;

    /** A mass [kg] that is so small that the acceleration overflows before the force does. */
    private static final double TINY_MASS = 1e-20;

    /**
     * The engine refuses 1e300 N. The integrator fails with 1e90 N. The order of loading does not
     * matter.
     */
    @ParameterizedTest
    @CsvSource({"1e300, false", "1e300, true", "1e90, false", "1e90, true"})
    void theLawThatAddsAnExtremeForceIsNamedAndNotTheIntegrator(double newtons, boolean first) {
        try (AdapterFixture clean = tinyOrbit();
                AdapterFixture spoilt = tinyOrbit()) {
            clean.load("hooke_spring", "newton_motion");
            if (first) {
                spoilt.adapter.laws().load(0, "gale", Map.of("force", newtons));
            }
            spoilt.load("hooke_spring", "newton_motion");
            if (!first) {
                spoilt.adapter.laws().load(0, "gale", Map.of("force", newtons));
            }
            for (int frame = 1; frame <= FRAMES; frame++) {
                clean.run(1);
                spoilt.run(1);
                assertThat(spoilt.bytes()).as("frame %d", frame).isEqualTo(clean.bytes());
            }
            assertThat(spoilt.adapter.stateHash()).isEqualTo(clean.adapter.stateHash());
            assertThat(spoilt.adapter.laws().loaded())
                    .extracting(PhysicsLaw::name)
                    .containsExactly("hooke_spring", "newton_motion");
            assertBlamed(spoilt, newtons);
        }
    }

    private static void assertBlamed(AdapterFixture spoilt, double newtons) {
        assertThat(spoilt.events("fault")).hasSize(1);
        WorldEvent fault = spoilt.events("fault").getFirst();
        assertThat(fault.frame()).isOne();
        assertThat(fault.fields())
                .containsEntry("library", "wind")
                .containsEntry("law", "wind")
                .containsEntry("status", "LAW_MISBEHAVED")
                .containsEntry("item", "red");
        assertThat(fault.fields().get("message"))
                .asString()
                .contains(
                        newtons > 1e100
                                ? "law wind: property externalForce, row 0: wrote 1e+300"
                                : "law wind: its numbers make another law fail, and without it the"
                                        + " frame succeeds: after 0 steps: law newton_motion");
    }

    @Test
    void aHostedLawIsNamedInTheSameWay() {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture clean = HostedFixture.inProcess()) {
            for (AdapterFixture world : List.of(hosted.world, clean)) {
                world.world.find("b3").orElseThrow().physics().set("mass", TINY_MASS);
                world.load("newton_motion", "counts_years");
            }
            hosted.world.adapter.laws().load(0, "gale", Map.of("force", 1e90));
            clean.run(FRAMES);
            hosted.world.run(FRAMES);
            assertThat(hosted.world.bytes()).isEqualTo(clean.bytes());
            assertThat(hosted.world.adapter.stateHash()).isEqualTo(clean.adapter.stateHash());
            assertThat(hosted.world.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("library", "wind")
                                            .containsEntry("item", "b3"));
        }
    }

    /** The trials change neither the columns nor the memory of laws. */
    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void aLawThatFailsWithoutAllOthersTooIsTheCause(boolean validate) {
        try (AdapterFixture clean = AdapterFixture.springOrbit(validate);
                AdapterFixture spoilt = AdapterFixture.springOrbit(validate)) {
            for (AdapterFixture world : List.of(clean, spoilt)) {
                var red = world.world.find("red").orElseThrow();
                red.physics().set("velocity", 1e80, 0, 0);
                red.physics().set("dragCoefficient", 1);
                world.load("counts_years");
            }
            spoilt.load("drag");
            clean.run(FRAMES);
            spoilt.run(FRAMES);
            assertThat(spoilt.bytes()).isEqualTo(clean.bytes());
            assertThat(spoilt.adapter.stateHash()).isEqualTo(clean.adapter.stateHash());
            assertThat(spoilt.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault -> {
                                assertThat(fault.fields()).containsEntry("library", "drag");
                                assertThat(fault.fields().get("message"))
                                        .asString()
                                        .doesNotContain("another law");
                            });
        }
    }

    private static AdapterFixture tinyOrbit() {
        AdapterFixture orbit = AdapterFixture.springOrbitWithoutLaws(false);
        orbit.world.find("red").orElseThrow().physics().set("mass", TINY_MASS);
        orbit.world.find("band").orElseThrow().physics().set("springConstant", 0.0);
        return orbit;
    }
}
