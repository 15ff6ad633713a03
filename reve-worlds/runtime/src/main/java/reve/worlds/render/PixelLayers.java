// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.Optional;

/**
 * The layers of a picture, row by row from the top. Buffers are little-endian and read-only.
 *
 * @param width [px]
 * @param height [px]
 * @param colour red, green and blue in sRGB, one byte each
 * @param depth the distance of the surface at the centre of the pixel, along the view direction
 *     [m], f32; 0 if there is no surface
 * @param item number of the item at the centre of the pixel, u32; 0 if there is no item with a
 *     number
 */
public record PixelLayers(
        int width,
        int height,
        Optional<ByteBuffer> colour,
        Optional<ByteBuffer> depth,
        Optional<ByteBuffer> item) {

    public static final int COLOUR = 1;
    public static final int DEPTH = 2;
    public static final int ITEM = 4;

    /**
     * Splits the bytes of a picture into its layers.
     *
     * @param bytes the requested layers, one after the other
     */
    static PixelLayers of(ImageFormat image, int layers, byte[] bytes) {
        var rest = ByteBuffer.wrap(bytes);
        int pixels = image.width() * image.height();
        var read =
                new PixelLayers(
                        image.width(),
                        image.height(),
                        take(rest, (layers & COLOUR) != 0, 3 * pixels),
                        take(rest, (layers & DEPTH) != 0, 4 * pixels),
                        take(rest, (layers & ITEM) != 0, 4 * pixels));
        if (rest.hasRemaining()) {
            throw new RenderException(
                    bytes.length + " bytes of pixels came, " + rest.remaining() + " too many");
        }
        return read;
    }

    private static Optional<ByteBuffer> take(ByteBuffer rest, boolean wanted, int bytes) {
        if (!wanted) {
            return Optional.empty();
        }
        if (rest.remaining() < bytes) {
            throw new RenderException((bytes - rest.remaining()) + " bytes of pixels are missing");
        }
        ByteBuffer layer = rest.slice(rest.position(), bytes).asReadOnlyBuffer();
        rest.position(rest.position() + bytes);
        return Optional.of(layer.order(ByteOrder.LITTLE_ENDIAN));
    }
}
