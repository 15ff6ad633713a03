// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import org.jspecify.annotations.Nullable;

import reve.core.world.Colour;
import reve.core.world.Material;
import reve.core.world.Texture;

import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/**
 * The materials in the libraries (MTL) of an OBJ file, reduced to the properties that the renderer
 * supports. These are diffuse colour and texture, and roughness and metallic if present.
 */
final class ObjMaterials {

    private static final int MAX_LIBRARY_BYTES = 1 << 20;
    private static final int MAX_LIBRARIES = 16;

    /**
     * Options that may precede the file name of a texture, in lower case, with the minimum and
     * maximum number of their arguments.
     */
    private static final Map<String, int[]> OPTIONS =
            Map.ofEntries(
                    Map.entry("-blendu", new int[] {1, 1}),
                    Map.entry("-blendv", new int[] {1, 1}),
                    Map.entry("-boost", new int[] {1, 1}),
                    Map.entry("-cc", new int[] {1, 1}),
                    Map.entry("-clamp", new int[] {1, 1}),
                    Map.entry("-imfchan", new int[] {1, 1}),
                    Map.entry("-texres", new int[] {1, 1}),
                    Map.entry("-bm", new int[] {1, 1}),
                    Map.entry("-type", new int[] {1, 1}),
                    Map.entry("-mm", new int[] {2, 2}),
                    Map.entry("-o", new int[] {1, 3}),
                    Map.entry("-s", new int[] {1, 3}),
                    Map.entry("-t", new int[] {1, 3}));

    private final Sources sources;
    private final Map<String, Material> materials = new HashMap<>();
    private int libraries;

    /** A material that is being read, line by line. */
    private static final class Draft {
        private Colour colour = Colour.WHITE;
        private double roughness = Material.DEFAULT.roughness();
        private double metallic = Material.DEFAULT.metallic();
        private Optional<Texture> texture = Optional.empty();
    }

    ObjMaterials(Sources sources) {
        this.sources = sources;
    }

    /** Returns whether the libraries define no material. */
    boolean isEmpty() {
        return materials.isEmpty();
    }

    /** Returns the material with that name, or the default material. */
    Material get(String name) {
        return materials.getOrDefault(name, Material.DEFAULT);
    }

    /**
     * Adds the materials of a library. A later material replaces an earlier one with the same name.
     */
    void readLibrary(String name) throws AssetException {
        if (++libraries > MAX_LIBRARIES) {
            throw sources.refuse("more than " + MAX_LIBRARIES + " material libraries");
        }
        var lines =
                new ObjLines(
                        sources.file(name, MAX_LIBRARY_BYTES), sources, "material library " + name);
        String material = "";
        @Nullable Draft draft = null;
        while (lines.next()) {
            if (lines.is("newmtl")) {
                keep(material, draft, lines);
                material = lines.rest();
                draft = new Draft();
            } else if (draft == null) {
                throw lines.refuse("`" + lines.text() + "` before the first `newmtl`");
            } else {
                read(lines, draft);
                lines.skipLine();
            }
        }
        keep(material, draft, lines);
    }

    private void keep(String name, @Nullable Draft draft, ObjLines lines) throws AssetException {
        if (draft != null) {
            try {
                materials.put(
                        name,
                        new Material(draft.colour, draft.roughness, draft.metallic, draft.texture));
            } catch (IllegalArgumentException outOfRange) {
                throw lines.refuse("material `" + name + "`: " + outOfRange.getMessage());
            }
        }
    }

    private void read(ObjLines lines, Draft draft) throws AssetException {
        switch (lines.keyword()) {
            case "kd" -> draft.colour = colour(lines);
            case "pr" -> draft.roughness = lines.number("Pr");
            case "pm" -> draft.metallic = lines.number("Pm");
            case "map_kd" -> draft.texture = Optional.of(sources.image(textureFile(lines)));
            default -> {}
        }
    }

    /**
     * Reads a colour. By convention, colours in these files are sRGB. One number without green and
     * blue means grey.
     */
    private static Colour colour(ObjLines lines) throws AssetException {
        float red = lines.number("Kd");
        float green = lines.word() ? lines.number() : red;
        float blue = lines.word() ? lines.number() : red;
        return new Colour(part(red) | part(green) << 8 | part(blue) << 16 | 0xff000000);
    }

    private static int part(float value) {
        return Math.round(255 * Math.clamp(value, 0f, 1f));
    }

    /**
     * Skips the options of a texture, and returns the file name after them, which may contain
     * spaces.
     */
    private static String textureFile(ObjLines lines) throws AssetException {
        while (lines.word()) {
            int[] words = OPTIONS.get(lines.keyword());
            if (words == null) {
                return lines.fromWord();
            }
            for (int i = 0; i < words[1]; i++) {
                if (!lines.word()) {
                    throw lines.refuse("`map_Kd` names no file");
                }
                if (i >= words[0] && !lines.isNumber()) {
                    lines.back();
                    break;
                }
            }
        }
        throw lines.refuse("`map_Kd` names no file");
    }
}
