// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import de.javagl.jgltf.impl.v2.GlTF;
import de.javagl.jgltf.impl.v2.Image;
import de.javagl.jgltf.impl.v2.MaterialPbrMetallicRoughness;
import de.javagl.jgltf.impl.v2.TextureInfo;

import org.jspecify.annotations.Nullable;

import reve.core.world.Colour;
import reve.core.world.Material;
import reve.core.world.Texture;

import java.nio.ByteBuffer;
import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/** The materials of a glTF file, reduced to the properties that the renderer supports. */
final class GltfMaterials {

    private final GlTF gltf;
    private final GltfAccessors accessors;
    private final Sources sources;
    private final Map<Integer, Material> known = new HashMap<>();
    private final Map<Integer, Texture> images = new HashMap<>();
    private final Map<Integer, Texture> inViews = new HashMap<>();

    GltfMaterials(GlTF gltf, GltfAccessors accessors, Sources sources) {
        this.gltf = gltf;
        this.accessors = accessors;
        this.sources = sources;
    }

    /**
     * Returns a material.
     *
     * @param number index of the material; null for the default material of glTF
     */
    Material get(@Nullable Integer number) throws AssetException {
        if (number == null) {
            return Material.DEFAULT;
        }
        Material material = known.get(number);
        if (material == null) {
            material = read(number);
            known.put(number, material);
        }
        return material;
    }

    /**
     * Returns the name of the vertex attribute that contains the texture coordinates for a
     * material.
     */
    String coordinatesOf(@Nullable Integer number) throws AssetException {
        TextureInfo texture = number == null ? null : surface(number).getBaseColorTexture();
        return "TEXCOORD_"
                + (texture == null || texture.getTexCoord() == null ? 0 : texture.getTexCoord());
    }

    /** Converts linear colour components from 0 to 1 into an sRGB colour. */
    static Colour toSrgb(float red, float green, float blue) {
        return new Colour(toSrgb(red) | toSrgb(green) << 8 | toSrgb(blue) << 16 | 0xff000000);
    }

    private static int toSrgb(float linear) {
        double c = linear > 0 ? Math.min(linear, 1) : 0;
        return (int)
                Math.round(
                        255
                                * (c <= 0.0031308
                                        ? 12.92 * c
                                        : 1.055 * StrictMath.pow(c, 1 / 2.4) - 0.055));
    }

    private Material read(int number) throws AssetException {
        MaterialPbrMetallicRoughness surface = surface(number);
        float[] colour =
                surface.getBaseColorFactor() == null
                        ? surface.defaultBaseColorFactor()
                        : surface.getBaseColorFactor();
        Float roughness = surface.getRoughnessFactor();
        Float metallic = surface.getMetallicFactor();
        Optional<Texture> texture =
                surface.getBaseColorTexture() == null
                        ? Optional.empty()
                        : Optional.of(texture(surface.getBaseColorTexture()));
        try {
            return new Material(
                    toSrgb(colour[0], colour[1], colour[2]),
                    roughness == null ? surface.defaultRoughnessFactor() : roughness,
                    metallic == null ? surface.defaultMetallicFactor() : metallic,
                    texture);
        } catch (IllegalArgumentException outOfRange) {
            throw sources.refuse("material " + number + ": " + outOfRange.getMessage());
        }
    }

    private MaterialPbrMetallicRoughness surface(int number) throws AssetException {
        var surface =
                GltfContainer.element(gltf.getMaterials(), number, "material", sources)
                        .getPbrMetallicRoughness();
        return surface == null ? new MaterialPbrMetallicRoughness() : surface;
    }

    private Texture texture(TextureInfo info) throws AssetException {
        Integer source =
                GltfContainer.element(gltf.getTextures(), info.getIndex(), "texture", sources)
                        .getSource();
        Image image = GltfContainer.element(gltf.getImages(), source, "image", sources);
        Texture decoded = images.get(source);
        if (decoded == null) {
            decoded =
                    image.getUri() == null
                            ? inView(image.getBufferView(), source)
                            : image.getUri().startsWith("data:")
                                    ? decode(sources.read(image.getUri()), source)
                                    : sources.imageBehind(image.getUri());
            images.put(source, decoded);
        }
        return decoded;
    }

    /**
     * Returns the image that a bufferView contains, as a texture. Images in the same bufferView
     * share one texture.
     */
    private Texture inView(@Nullable Integer view, Integer source) throws AssetException {
        Texture known = inViews.get(view);
        if (known == null) {
            known = decode(accessors.view(view), source);
            inViews.put(view, known);
        }
        return known;
    }

    private Texture decode(ByteBuffer encoded, Integer source) throws AssetException {
        sources.budget().takeBytes(sources.path(), encoded.remaining());
        byte[] bytes = new byte[encoded.remaining()];
        encoded.get(bytes);
        return ImageDecoder.decode(
                bytes, sources.path() + ": image " + source, Optional.empty(), sources.budget());
    }
}
