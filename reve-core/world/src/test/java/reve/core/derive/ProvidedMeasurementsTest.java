// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.unit.Unit;
import reve.core.world.Instrument;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.SensorProvider;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.function.Consumer;

/** Sensors in Java: the numbers that they measure are in the snapshot of the same frame. */
class ProvidedMeasurementsTest {
    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("test", WorldPrototype.standard("si-f64"), arena);
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop = new FrameLoop(world, bus, new Timing(4, 1), Pacing.FAST);
    private final SnapshotRing ring = new SnapshotRing(world, 2);
    private final List<WorldEvent> faults = new ArrayList<>();

    @AfterEach
    void free() {
        arena.close();
    }

    /** Measures x of a body and the time. A body at x = 9 makes it throw, at x = 8 measure NaN. */
    private static final class Ruler implements SensorProvider {
        @Override
        public String name() {
            return "test.ruler";
        }

        @Override
        public String doc() {
            return "";
        }

        @Override
        public List<Quantity> quantities() {
            return List.of(
                    new Quantity("x", 1, Unit.parse("m")),
                    new Quantity("time", 1, Unit.parse("s")));
        }

        @Override
        public void measure(Item body, double timeSeconds, double[] numbers) {
            if (numbers[0] != 0 || numbers[1] != 0) {
                throw new IllegalStateException("the array is not zero");
            }
            numbers[0] = body.physical().location()[0];
            numbers[1] = timeSeconds;
            if (numbers[0] == 9) {
                throw new IllegalStateException("too far");
            }
            if (numbers[0] == 8) {
                numbers[1] = Double.NaN;
            }
            if (numbers[0] == 7) {
                body.physical().setLocation(0, 0, 0);
            }
        }
    }

    private Item add(String name, double x) {
        return world.add(
                ItemDefinition.named(name)
                        .at(x, 0, 0)
                        .sensor(Sensor.measuring("ruler", Instrument.Provided.by(new Ruler())))
                        .build());
    }

    private void subscribe(Consumer<World> act) {
        bus.subscribe(FramePhase.ACT, "act", frame -> act.accept(frame.world()));
        DerivedColumns.subscribeTo(bus);
        ProvidedMeasurements.subscribeTo(bus);
        bus.subscribe(
                FramePhase.PUBLISH,
                "snapshots",
                frame -> {
                    ring.publish(frame.frame(), frame.timeSeconds());
                    faults.addAll(frame.world().events());
                });
    }

    private Map<String, double[]> readings(Item item) {
        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            return snapshot.readings().getOrDefault(item.id(), Map.of());
        }
    }

    @Test
    void theNumbersAreThoseOfTheFrame() {
        Item a = add("a", 2);
        subscribe(now -> a.physical().setLocation(a.physical().location()[0] + 1, 0, 0));
        loop.step();
        assertThat(readings(a).get("ruler")).containsExactly(3, 0.25);
        loop.step();
        assertThat(readings(a).get("ruler")).containsExactly(4, 0.5);
        assertThat(faults).isEmpty();
    }

    @Test
    void aFailureCostsOnlyTheReadingOfItsItemAndIsReportedOnce() {
        Item a = add("a", 2);
        Item thrown = add("thrown", 9);
        Item nan = add("nan", 8);
        Item meddles = add("meddles", 7);
        subscribe(now -> {});
        loop.step();
        loop.step();
        assertThat(readings(a)).containsOnlyKeys("ruler");
        assertThat(readings(thrown)).isEmpty();
        assertThat(readings(nan)).isEmpty();
        assertThat(readings(meddles)).isEmpty();
        assertThat(meddles.physical().location()).containsExactly(7, 0, 0);
        assertThat(faults).hasSize(1);
        assertThat(faults.getFirst().type()).isEqualTo("fault");
        assertThat(faults.getFirst().fields())
                .containsEntry("source", "sensor test.ruler")
                .containsEntry("class", Ruler.class.getName())
                .containsEntry("message", "too far; thrown has no reading (reported once)");
    }

    @Test
    void readingsEndWithTheirItem() {
        Item a = add("a", 2);
        boolean[] remove = {false};
        subscribe(
                now -> {
                    if (remove[0]) {
                        now.remove(a.id());
                        remove[0] = false;
                    }
                });
        loop.step();
        assertThat(readings(a)).isNotEmpty();
        var id = a.id();
        remove[0] = true;
        loop.step();
        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            assertThat(snapshot.readings()).doesNotContainKey(id).isEmpty();
        }
    }
}
