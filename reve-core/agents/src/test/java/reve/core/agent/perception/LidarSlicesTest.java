// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

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
            // Rays are tested one by one with meshes and with long shapes.
            Shape fin = Shape.mesh(new float[] {0, 0, 0, 9, 0, 0, 0, 3, 0}, new int[] {0, 1, 2});
            world.add(ItemDefinition.named("fin").shape(fin).at(1, 2, 12).build());
            world.add(
                    ItemDefinition.named("mast").shape(Shape.box(0.2, 9, 0.2)).at(2, 0, 3).build());
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

    /**
     * Rays that cross many triangles use more time. A slice then ends after fewer rays, and a ray
     * that would have to examine too many triangles measures nothing.
     */
    @Test
    void raysThatCrossManyTrianglesAreFewInASliceAndLimited() {
        for (int triangles : new int[] {10_000, LidarScanner.MOST_OF_RAY}) {
            try (var arena = new OffHeapArena()) {
                World world = new World("test", WorldPrototype.standard("si-f64"), arena);
                Sensor scan =
                        Sensor.measuring("scan", new Instrument.Lidar(8, 1, 0.001, 0, 50, 0, 0));
                Item body = world.add(ItemDefinition.named("body").sensor(scan).build());
                world.add(ItemDefinition.named("fan").shape(fan(triangles)).at(0, 0, 5).build());
                var ring = new SnapshotRing(world, 2);
                new BoundingBoxes().update(world);
                ring.publish(1, 1);
                var observatory = new Observatory();
                try (var snapshot = ring.acquireLatest().orElseThrow()) {
                    observatory.read(snapshot);
                }
                var senses = new Senses(body.id(), List.of(scan));
                int slices = 1;
                Optional<View> view = senses.look(observatory, onlyOnce());
                for (; view.isEmpty(); view = senses.look(observatory, onlyOnce())) {
                    slices++;
                }
                assertThat(slices).isGreaterThanOrEqualTo(4);
                boolean isTooMany = triangles == LidarScanner.MOST_OF_RAY;
                assertThat(distances(view.get())).hasSize(8);
                for (double found : distances(view.get())) {
                    assertThat(found).isCloseTo(isTooMany ? -1 : 5, within(0.01));
                }
            }
        }
    }

    /** Thin triangles of 20 m, one behind another, whose boxes all contain the centre. */
    private static Shape fan(int triangles) {
        float[] corners = new float[3 * (triangles + 2)];
        corners[0] = -10;
        corners[1] = -10;
        corners[3] = 10;
        corners[4] = -10;
        int[] indices = new int[3 * triangles];
        for (int i = 0; i < triangles; i++) {
            corners[3 * (i + 2) + 1] = 10;
            corners[3 * (i + 2) + 2] = 1e-8f * i;
            indices[3 * i + 1] = 1;
            indices[3 * i + 2] = i + 2;
        }
        return Shape.mesh(corners, indices);
    }

    /** Time for one more part of the work. */
    private static BooleanSupplier onlyOnce() {
        int[] asked = {0};
        return () -> asked[0]++ < 1;
    }
}
