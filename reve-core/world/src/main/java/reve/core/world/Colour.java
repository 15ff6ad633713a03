// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;
import java.util.regex.Pattern;

/**
 * An sRGB colour with an alpha channel that is not premultiplied.
 *
 * @param rgba red in the low byte, then green, blue and alpha. The order of the bytes in memory is
 *     therefore r g b a on a little-endian machine
 */
public record Colour(int rgba) {

    private static final Pattern TEXT = Pattern.compile("#[0-9a-fA-F]{6}([0-9a-fA-F]{2})?");

    public static final Colour WHITE = parse("#ffffff");

    /** Light grey. */
    public static final Colour DEFAULT = parse("#cccccc");

    /**
     * Reads {@code #rrggbb} or {@code #rrggbbaa}.
     *
     * @throws IllegalArgumentException for anything else
     */
    public static Colour parse(String text) {
        if (!TEXT.matcher(text).matches()) {
            throw new IllegalArgumentException(
                    "colour \"" + text + "\": expected #rrggbb or #rrggbbaa, for example #c0392b");
        }
        String digits = text.length() == 7 ? text.substring(1) + "ff" : text.substring(1);
        return new Colour(Integer.reverseBytes(Integer.parseUnsignedInt(digits, 16)));
    }

    /**
     * Returns the colour of an item without a declared colour: {@link #DEFAULT}, or white if a
     * texture or a mesh has its own colours.
     */
    public static Colour defaultOf(Shape shape, Optional<Material> material) {
        boolean coloured =
                material.isPresent()
                        ? material.get().texture().isPresent()
                        : shape instanceof Mesh mesh
                                && (!mesh.parts().isEmpty() || mesh.colours().isPresent());
        return coloured ? WHITE : DEFAULT;
    }

    /** Returns {@code #rrggbbaa}, which {@link #parse} accepts. */
    @Override
    public String toString() {
        return String.format("#%08x", Integer.reverseBytes(rgba));
    }
}
