// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;
import java.util.Set;

/**
 * The appearance of a spring or a surface.
 *
 * @param colour colour of the item; if empty, a spring has {@link #SPRING_COLOUR}, and a surface
 *     has the colours of the bodies at its corners. Alpha 0 hides the item
 * @param width diameter of a spring [m], 0 or more; 0 for a thin line, whose width does not depend
 *     on the distance. Surfaces have no width
 */
public record ConnectionLook(Optional<Colour> colour, double width) {

    /** Name of the property for the width. */
    public static final String WIDTH = "width";

    /** The kinds of items with such an appearance. */
    public static final Set<String> KINDS = Set.of(WorldPrototype.SPRING, WorldPrototype.SURFACE);

    /** Colour of springs without a declared colour. */
    public static final Colour SPRING_COLOUR = Colour.parse("#6e7682");

    /** The appearance without declared values. */
    public static final ConnectionLook DEFAULT = new ConnectionLook(Optional.empty(), 0);

    /**
     * Checks the width.
     *
     * @throws IllegalArgumentException if the width is negative or not finite
     */
    public ConnectionLook {
        if (!(width >= 0) || !Double.isFinite(width)) {
            throw new IllegalArgumentException("width: found " + width + " m, expected 0 or more");
        }
    }

    /** Returns a copy with another colour. */
    public ConnectionLook with(Colour newColour) {
        return new ConnectionLook(Optional.of(newColour), width);
    }

    /** Returns a copy with another width [m]. */
    public ConnectionLook with(double newWidth) {
        return new ConnectionLook(colour, newWidth);
    }

    /** Returns whether the colour hides the item. */
    public boolean isHidden() {
        return colour.filter(own -> own.rgba() >>> 24 == 0).isPresent();
    }

    /**
     * Refuses an appearance that items of a kind do not have.
     *
     * @param item the item as text for messages
     * @throws IllegalArgumentException naming the item
     */
    void require(String item, String kind) {
        if (!equals(DEFAULT) && !KINDS.contains(kind)) {
            throw new IllegalArgumentException(
                    item + " is a " + kind + ", expected a spring or a surface with this look");
        }
        if (width != 0) {
            requireWidth(item, kind);
        }
    }

    /**
     * Refuses a width of an item that is no spring.
     *
     * @param item the item as text for messages
     * @throws IllegalArgumentException naming the item
     */
    static void requireWidth(String item, String kind) {
        if (!kind.equals(WorldPrototype.SPRING)) {
            throw new IllegalArgumentException(
                    item + " is a " + kind + ", expected a spring: only springs have a width");
        }
    }
}
