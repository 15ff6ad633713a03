// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import reve.core.world.Colour;

/**
 * Background and light. A white surface facing the light shows white where light and ambient add up
 * to 1.
 *
 * @param top background at the top of the picture, {@code bottom} at its bottom
 * @param toLight direction to the light, any length but 0
 * @param light strength of the light, 0 to 8
 * @param ambient strength of the light from everywhere, 0 to 8
 */
public record Environment(Colour top, Colour bottom, Point toLight, double light, double ambient) {

    /** Bright and neutral, light from the upper left. */
    public static final Environment STUDIO =
            new Environment(
                    Colour.parse("#ffffff"),
                    Colour.parse("#e2e6eb"),
                    new Point(-0.5, 1, 0.4),
                    0.65,
                    0.48);
}
