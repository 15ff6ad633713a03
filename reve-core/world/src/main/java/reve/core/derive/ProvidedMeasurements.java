// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import org.jspecify.annotations.Nullable;

import reve.core.frame.FrameBus;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.world.FrameControl;
import reve.core.world.Instrument;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.ProviderFaults;
import reve.core.world.Sensor;
import reve.core.world.SensorProvider;
import reve.core.world.World;

import java.util.HashMap;
import java.util.Map;
import java.util.SortedSet;

/**
 * Measures with the {@link SensorProvider}s of all items in each frame, in the phase DERIVE.
 * Snapshots of the frame contain the numbers. The cost is proportional to the number of sensors
 * with a provider. A world without such sensors allocates no memory. For the world's thread only.
 */
public final class ProvidedMeasurements {
    private boolean empty = true;

    /** Subscribes to the phase DERIVE. Listeners that subscribed earlier are called first. */
    public static void subscribeTo(FrameBus bus) {
        bus.subscribe(FramePhase.DERIVE, "provided sensors", new ProvidedMeasurements()::measure);
    }

    private void measure(FrameEvent frame) {
        FrameControl control = FrameControl.of(frame.world());
        SortedSet<ItemId> items = control.withProvided();
        if (items.isEmpty() && empty) {
            return;
        }
        empty = items.isEmpty();
        Map<ItemId, Map<String, double[]>> readings = new HashMap<>();
        for (ItemId id : items) {
            Item item = frame.world().item(id);
            Map<String, double[]> ofItem = new HashMap<>();
            for (Sensor sensor : item.sensors()) {
                if (sensor.instrument().orElse(null) instanceof Instrument.Provided provided
                        && provided.gauge() instanceof SensorProvider provider) {
                    double[] numbers = measure(frame, provider, provided.numbers(), item);
                    if (numbers != null) {
                        ofItem.put(sensor.name(), numbers);
                    }
                }
            }
            readings.put(id, ofItem);
        }
        control.setReadings(readings);
    }

    /** Returns the measured numbers; null if the measurement failed, which was then reported. */
    private static double @Nullable [] measure(
            FrameEvent frame, SensorProvider provider, int count, Item item) {
        World world = frame.world();
        String source = "sensor " + provider.name();
        world.activity().begin(source + " of " + item.name());
        try {
            double[] numbers = new double[count];
            world.guard()
                    .inspect(
                            source,
                            () -> {
                                provider.measure(item, frame.timeSeconds(), numbers);
                                return true;
                            });
            requireFinite(numbers);
            return numbers;
        } catch (Throwable failure) {
            ProviderFaults.requireBearable(failure);
            world.providerFaults()
                    .report(
                            frame.frame(),
                            frame.phase().name(),
                            source,
                            provider,
                            failure,
                            item.name() + " has no reading (reported once)");
            return null;
        } finally {
            ProviderFaults.clearInterrupt();
            world.activity().end();
        }
    }

    private static void requireFinite(double[] numbers) {
        for (double number : numbers) {
            if (!Double.isFinite(number)) {
                throw new ArithmeticException(
                        "it measured " + number + ", expected finite numbers");
            }
        }
    }
}
