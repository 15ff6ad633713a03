// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

/**
 * Size and quality of a picture.
 *
 * @param width [px], 1 to 8192
 * @param height [px], 1 to 8192; at most 2^24 pixels in all
 * @param samples samples per pixel for smooth edges, 0 to 16; 0 is fast and gives jagged edges
 * @param shadows whether the light casts shadows
 */
public record ImageFormat(int width, int height, int samples, boolean shadows) {

    /** Checks the size against its limits. */
    public ImageFormat {
        if (width < 1
                || height < 1
                || width > 8192
                || height > 8192
                || (long) width * height > 1 << 24) {
            throw new IllegalArgumentException(
                    "picture of "
                            + width
                            + " x "
                            + height
                            + " pixels, expected 1 to 8192 a side and at most 16777216 in all");
        }
        if (samples < 0 || samples > 16) {
            throw new IllegalArgumentException(samples + " samples per pixel, expected 0 to 16");
        }
    }

    /** Returns a format with smooth edges and shadows. */
    public static ImageFormat of(int width, int height) {
        return new ImageFormat(width, height, 4, true);
    }

    /** Returns the width divided by the height. */
    public double aspect() {
        return (double) width / height;
    }
}
