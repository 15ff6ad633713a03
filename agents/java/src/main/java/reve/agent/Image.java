// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.nio.ByteBuffer;
import java.util.List;
import java.util.Optional;

/**
 * A picture from a camera, in rows from the top. Buffers are read-only and little-endian. Layers
 * that the camera lacks are empty.
 *
 * @param id id of the request
 * @param time time of the world [s]
 * @param sensor the camera
 * @param width [px]
 * @param height [px]
 * @param colour red, green and blue in sRGB, one byte each
 * @param depth distance along the view axis [m], f32; 0 if no surface is in range
 * @param items u16; 0 for no item, otherwise the index of its name in {@code names}, from 1
 * @param names names of the visible items
 */
public record Image(
        long id,
        long frame,
        double time,
        String sensor,
        int width,
        int height,
        Optional<ByteBuffer> colour,
        Optional<ByteBuffer> depth,
        Optional<ByteBuffer> items,
        List<String> names)
        implements ServerMessage {

    /** Returns the name of the item at a pixel, counted from the upper left. */
    public Optional<String> find(int x, int y) {
        ByteBuffer numbers =
                items.orElseThrow(
                        () ->
                                new IllegalStateException(
                                        "the camera " + sensor + " does not tell items"));
        int number = Short.toUnsignedInt(numbers.getShort(2 * (y * width + x)));
        return number > 0 ? Optional.of(names.get(number - 1)) : Optional.empty();
    }
}
