// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.nio.ByteBuffer;
import java.util.Optional;

/**
 * A picture that surfaces wear: opaque sRGB, repeated beyond its edges. Immutable; the same object
 * is shared by all that show it.
 */
public final class Texture {

    /** Most pixels of one texture. */
    public static final int MAX_PIXELS = 1 << 24;

    /** Most pixels a side, which any graphics library takes. */
    public static final int MAX_SIDE = 8192;

    private final int width;
    private final int height;
    private final byte[] rgba;
    private final Optional<String> file;

    /**
     * @param width [px]
     * @param height [px]
     * @param rgba (height x width x 4) bytes r g b a, from the upper left pixel by rows; copied; a
     *     is not shown
     * @param file where it came from, relative to the world's folder, if from a file of its own
     * @throws IllegalArgumentException if there are no or too many pixels, or not 4 bytes each
     */
    public Texture(int width, int height, byte[] rgba, Optional<String> file) {
        if (!fits(width, height)) {
            throw new IllegalArgumentException(
                    "texture of "
                            + width
                            + " x "
                            + height
                            + " pixels, expected 1 to "
                            + MAX_SIDE
                            + " a side and at most "
                            + MAX_PIXELS);
        }
        if (rgba.length != 4 * width * height) {
            throw new IllegalArgumentException(
                    "texture of "
                            + width
                            + " x "
                            + height
                            + " pixels has "
                            + rgba.length
                            + " bytes, expected "
                            + 4 * width * height);
        }
        this.width = width;
        this.height = height;
        this.rgba = rgba.clone();
        this.file = file;
    }

    /** Whether a texture may have that many pixels. */
    public static boolean fits(int width, int height) {
        return width >= 1
                && height >= 1
                && width <= MAX_SIDE
                && height <= MAX_SIDE
                && width * height <= MAX_PIXELS;
    }

    /** [px]. */
    public int width() {
        return width;
    }

    /** [px]. */
    public int height() {
        return height;
    }

    /** (height x width x 4) bytes r g b a, from the upper left pixel by rows; read only. */
    public ByteBuffer rgba() {
        return ByteBuffer.wrap(rgba).asReadOnlyBuffer();
    }

    /** The file it came from, relative to the world's folder; empty if it came with a mesh. */
    public Optional<String> file() {
        return file;
    }
}
