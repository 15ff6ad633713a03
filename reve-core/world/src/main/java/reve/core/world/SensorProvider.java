// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * A measurement in Java. Sensors of world files refer to it by name: {@code sensors: {compass:
 * {java: NAME}}}. Agents receive the measured numbers with their perceptions, as readings. A plugin
 * lists its providers in {@code META-INF/services/reve.core.world.SensorProvider}. All worlds of a
 * process share one instance, and each world calls it on its own thread, possibly at the same time.
 * An instance must therefore not store data of a world.
 */
public interface SensorProvider extends Gauge {
    /**
     * Measures for one body. A served world calls this method in each frame, in the phase DERIVE,
     * on the world's thread, for each item with such a sensor.
     *
     * <p>The method may read the whole world through the item, but must not change it. It must
     * measure the same numbers for the same state of the world and the same time, so it must not
     * use a clock, random numbers without a fixed seed, or data of earlier calls. It must not sleep
     * or block, because the frame waits for it without a time limit.
     *
     * <p>If the method throws an exception, or a number is not finite, the body has no reading of
     * this sensor in this frame. The first such failure in a world raises an event {@code fault}.
     *
     * @param body the item that has the sensor
     * @param timeSeconds simulated time at the end of the frame [s]
     * @param numbers receives the components of all quantities, in the order of {@link
     *     #quantities}, in the units of the quantities; the array is zero before the call and
     *     belongs to the world
     */
    void measure(Item body, double timeSeconds, double[] numbers);
}
