// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.ColumnArena;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.WorldPrototype;
import reve.pe.SpringOrbit;

import java.lang.foreign.MemorySegment;
import java.util.List;
import java.util.stream.IntStream;

/** A world that cannot grow stays unchanged. It continues with its physics. */
class FullArenaNativeTest {
    @ParameterizedTest
    @ValueSource(ints = {0, 1, 12})
    void physicsGoesOnAfterGrowthWasRefusedBetweenTwoColumns(int columnsThatStillFit) {
        LimitedArena arena = new LimitedArena();
        try (AdapterFixture clean = AdapterFixture.springOrbit();
                AdapterFixture full =
                        new AdapterFixture(
                                WorldPrototype.standard("si-f64"),
                                AdapterFixture.springOrbitItems(),
                                arena,
                                true,
                                engine -> engine)) {
            full.load(SpringOrbit.LAWS);
            clean.run(1);
            full.run(1);

            arena.reservationsLeft = columnsThatStillFit;
            assertThatIllegalStateException()
                    .isThrownBy(() -> full.world.addAll(manyBodies()))
                    .withMessageContaining("arena is full");
            arena.reservationsLeft = Integer.MAX_VALUE;

            clean.run(2);
            full.run(2);
            assertThat(full.bytes()).isEqualTo(clean.bytes());
            full.world.addAll(manyBodies());
            clean.world.addAll(manyBodies());
            clean.run(1);
            full.run(1);
            assertThat(full.bytes()).isEqualTo(clean.bytes());
            assertThat(full.events("fault")).isEmpty();
        }
    }

    private static List<ItemDefinition> manyBodies() {
        return IntStream.range(0, 100)
                .mapToObj(i -> AdapterFixture.body("b" + i, 1, i, 0, 0, 0, 0, 0))
                .toList();
    }

    private static final class LimitedArena implements ColumnArena {
        private final OffHeapArena memory = new OffHeapArena();
        private int reservationsLeft = Integer.MAX_VALUE;

        @Override
        public MemorySegment reserve(String name, long bytes) {
            if (reservationsLeft-- <= 0) {
                throw new IllegalStateException("arena is full: no room for " + name);
            }
            return memory.reserve(name, bytes);
        }

        @Override
        public void release(MemorySegment segment) {
            memory.release(segment);
        }

        @Override
        public void close() {
            memory.close();
        }
    }
}
