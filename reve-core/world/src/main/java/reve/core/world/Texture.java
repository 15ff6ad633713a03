// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.nio.ByteBuffer;
import java.util.Optional;

/**
 * An image on surfaces: opaque, in sRGB, and repeated beyond its edges. Immutable. All surfaces
 * with the texture share one object.
 */
public final class Texture {

    /** Maximum number of pixels of one texture. */
    public static final int MAX_PIXELS = 1 << 24;

    /** Maximum width and height [px]. Any graphics library supports textures of this size. */
    public static final int MAX_SIDE = 8192;

    private final int width;
    private final int height;
    private final byte[] rgba;
    private final Optional<String> file;

    /**
     * Creates a texture.
     *
     * @param width [px]
     * @param height [px]
     * @param rgba (height x width x 4) bytes r g b a, by rows from the upper left pixel; the array
     *     is copied, and the alpha bytes are ignored
     * @param file path relative to the world's folder, if the texture has its own file
     * @throws IllegalArgumentException if the number of pixels is 0 or too large, or there are not
     *     4 bytes per pixel
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

    /** Returns whether a texture may have this size [px]. */
    public static boolean fits(int width, int height) {
        return width >= 1
                && height >= 1
                && width <= MAX_SIDE
                && height <= MAX_SIDE
                && width * height <= MAX_PIXELS;
    }

    /** Returns the width [px]. */
    public int width() {
        return width;
    }

    /** Returns the height [px]. */
    public int height() {
        return height;
    }

    /** Returns (height x width x 4) bytes r g b a, by rows from the upper left pixel; read only. */
    public ByteBuffer rgba() {
        return ByteBuffer.wrap(rgba).asReadOnlyBuffer();
    }

    /**
     * Returns the file, relative to the world's folder; empty if the texture is part of a mesh
     * file.
     */
    public Optional<String> file() {
        return file;
    }
}
