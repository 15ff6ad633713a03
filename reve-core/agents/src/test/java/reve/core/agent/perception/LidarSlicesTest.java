// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.derive.BoundingBoxes;
import reve.core.world.Instrument;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.function.BooleanSupplier;

/** A scan with many rays does not delay other clients: it continues in later slices of time. */
class LidarSlicesTest {
    private static final Sensor SCAN =
            Sensor.measuring("scan", new Instrument.Lidar(300, 10, 6, 1, 50, 0, 0));

    private static double[] distances(View view) {
        return view.readings().getFirst().quantities().getFirst().numbers();
    }

    @Test
    void aScanInSlicesEqualsAScanAtOnce() {
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            Item body = world.add(ItemDefinition.named("body").sensor(SCAN).build());
            for (int i = 0; i < 40; i++) {
                world.add(
                        ItemDefinition.named("ball " + i)
                                .shape(Shape.sphere(1))
                                .at(9 * Math.cos(i), 0.2 * i - 4, 9 * Math.sin(i))
                                .build());
            }
            var ring = new SnapshotRing(world, 2);
            var boxes = new BoundingBoxes();
            var observatory = new Observatory();
            for (int frame = 1; frame <= 3; frame++) {
                world.find("ball 7").orElseThrow().physical().setLocation(0, 0, 2 + frame);
                boxes.update(world);
                ring.publish(frame, frame);
                try (var snapshot = ring.acquireLatest().orElseThrow()) {
                    assertThat(observatory.read(snapshot)).isTrue();
                }
                double[] atOnce = distances(new Senses(body.id(), List.of(SCAN)).look(observatory));
                assertThat(Arrays.stream(atOnce).filter(one -> one > 0).count()).isGreaterThan(300);

                var senses = new Senses(body.id(), List.of(SCAN));
                int slices = 1;
                Optional<View> view = senses.look(observatory, onlyOnce());
                for (; view.isEmpty(); view = senses.look(observatory, onlyOnce())) {
                    slices++;
                }
                assertThat(slices).isGreaterThan(20);
                assertThat(distances(view.get())).containsExactly(atOnce);
            }
        }
    }

    /** Time for one more part of the work. */
    private static BooleanSupplier onlyOnce() {
        int[] asked = {0};
        return () -> asked[0]++ < 1;
    }
}
