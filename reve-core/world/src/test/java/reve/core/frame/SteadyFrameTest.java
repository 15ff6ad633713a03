// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import static org.assertj.core.api.Assertions.assertThat;

import com.sun.management.ThreadMXBean;

import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.derive.DerivedColumns;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.lang.management.ManagementFactory;

class SteadyFrameTest {

    private static final int WARM_UP = 5000;
    private static final int MEASURED = 1000;

    /**
     * The bounds, the snapshot, the command queue, the bus and the profile work together in a world
     * that no longer changes.
     */
    @ParameterizedTest
    @ValueSource(strings = {"si-f64", "si-f32"})
    void allocatesNothing(String prototype) {
        World world = new World("test", WorldPrototype.standard(prototype), new OffHeapArena());
        for (int i = 0; i < 100; i++) {
            world.add(
                    ItemDefinition.named("b" + i)
                            .at(i, 0, 0)
                            .orientation(1, i, 0, 1)
                            .shape(i % 2 == 0 ? Shape.sphere(1) : Shape.box(1, 2, 3))
                            .physics("mass", 1)
                            .build());
        }
        var bus = new FrameBus();
        new CommandQueue(16).subscribeTo(bus);
        DerivedColumns.subscribeTo(bus);
        var ring = new SnapshotRing(world, 3);
        bus.subscribe(
                FramePhase.PUBLISH,
                "snapshots",
                event -> ring.publish(event.frame(), event.timeSeconds()));
        var loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
        var threads = (ThreadMXBean) ManagementFactory.getThreadMXBean();
        assertThat(threads.isThreadAllocatedMemorySupported()).isTrue();

        loop.run(WARM_UP);
        long before = threads.getCurrentThreadAllocatedBytes();
        loop.run(MEASURED);
        long bytes = threads.getCurrentThreadAllocatedBytes() - before;
        assertThat(bytes / MEASURED).as("bytes per frame, %d in all", bytes).isZero();
    }
}
