// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.OffHeapArena;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Map;

/** The exchange of data with a law that keeps positions in its own memory. */
class KeptCopyNativeTest {
    private static final int STEPS =
            4; // steps of a frame, in each of which the law moves bodies by 1 m

    private static AdapterFixture world(boolean validate) {
        return new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        List.of(
                                AdapterFixture.body("a", 1, 0, 5, 0, 0, 0, 0),
                                AdapterFixture.body("b", 1, 10, 0, 0, 0, 0, 0)),
                        new OffHeapArena(),
                        validate,
                        engine -> engine)
                .load("keeps_copy");
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void theColumnComesBackInEveryFrameAndGoesThereOnlyIfTheWorldEditedIt(boolean validate) {
        try (AdapterFixture kept = world(validate)) {
            for (int frame = 1; frame <= 3; frame++) {
                kept.run(1);
                assertThat(x(kept, "a")).isEqualTo(frame * STEPS);
                assertThat(x(kept, "b")).isEqualTo(10 + frame * STEPS);
                assertThat(transfers(kept)).containsExactly(1, frame - 1, 0);
            }
            kept.world.find("a").orElseThrow().physics().set("velocity", 7, 7, 7);
            kept.run(1);
            assertThat(transfers(kept)).containsExactly(1, 3, 0);
            kept.world.find("a").orElseThrow().physical().setLocation(100, 0, 0);
            kept.run(1);
            assertThat(x(kept, "a")).isEqualTo(100 + STEPS);
            assertThat(x(kept, "b")).isEqualTo(10 + 5 * STEPS);
            assertThat(transfers(kept)).containsExactly(2, 4, 0);
        }
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void aFrameThatIsDoneOverStartsFromWhereTheWorldIs(boolean validate) {
        try (AdapterFixture kept = world(validate)) {
            kept.adapter.laws().load(0, "returns_failure", Map.of("from_step", 2.0 * STEPS));
            kept.run(4);
            assertThat(kept.adapter.profile().redoneFrames()).isOne();
            assertThat(x(kept, "a")).isEqualTo(4 * STEPS);
            assertThat(x(kept, "b")).isEqualTo(10 + 4 * STEPS);
        }
    }

    private static double x(AdapterFixture fixture, String item) {
        return fixture.world.find(item).orElseThrow().physical().location()[0];
    }

    /** Returns how often the law received the positions, and how often it had to return them. */
    private static double[] transfers(AdapterFixture fixture) {
        return fixture.world.find("a").orElseThrow().physics().vector("acceleration");
    }
}
