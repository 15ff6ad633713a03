// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import reve.core.world.Colour;

/**
 * Background and light. A white surface that faces the light appears white if light and ambient sum
 * to 1.
 *
 * @param top background colour at the top of the picture
 * @param bottom background colour at the bottom of the picture
 * @param toLight direction to the light, any length except 0
 * @param light strength of the directional light, 0 to 8
 * @param ambient strength of the ambient light, 0 to 8
 */
public record Environment(Colour top, Colour bottom, Point toLight, double light, double ambient) {

    /** A bright, neutral environment with light from the upper left. */
    public static final Environment STUDIO =
            new Environment(
                    Colour.parse("#ffffff"),
                    Colour.parse("#e2e6eb"),
                    new Point(-0.5, 1, 0.4),
                    0.65,
                    0.48);
}
