// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;

/**
 * Optical properties of a surface. The displayed colour is the product of the item's colour, this
 * colour and the texture. Immutable.
 *
 * @param colour colour of the surface
 * @param roughness 0 (a small and bright highlight, like a mirror) to 1 (no visible highlight)
 * @param metallic 0 (plastic, wood, stone) to 1 (bare metal: its colour appears in reflections
 *     only)
 * @param texture image that multiplies the colour, if the shape has texture coordinates
 */
public record Material(
        Colour colour, double roughness, double metallic, Optional<Texture> texture) {

    /** The material of surfaces without a declared one: slightly glossy and white. */
    public static final Material DEFAULT = new Material(Colour.WHITE, 0.45, 0, Optional.empty());

    /**
     * Checks the numbers.
     *
     * @throws IllegalArgumentException if roughness or metallic are not 0 to 1
     */
    public Material {
        requireFraction("roughness", roughness);
        requireFraction("metallic", metallic);
    }

    private static void requireFraction(String what, double value) {
        if (!(value >= 0 && value <= 1)) {
            throw new IllegalArgumentException(what + ": " + value + ", expected 0 to 1");
        }
    }
}
