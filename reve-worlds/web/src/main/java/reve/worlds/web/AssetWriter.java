// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import reve.core.world.Mesh;
import reve.core.world.Texture;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.Optional;
import java.util.function.ToIntFunction;

/** Encodes meshes and textures as binary messages to web pages; page/view.js reads them. */
final class AssetWriter {

    /** Type of a message with a mesh. */
    static final int MESH = 2;

    /** Type of a message with a texture. */
    static final int TEXTURE = 3;

    private static final int NORMALS = 1;
    private static final int TEXTURE_COORDINATES = 2;
    private static final int COLOURS = 4;
    private static final int HEADER_BYTES = 24;
    private static final int PART_BYTES = 24;

    private AssetWriter() {}

    /**
     * Encodes a mesh as a message. The message consists of:
     *
     * <ul>
     *   <li>type, id, number of vertices, number of indices, attributes, number of parts;
     *   <li>coordinates, normals, texture coordinates, colours, indices;
     *   <li>for each part: the first triangle, the number of triangles, colour, roughness,
     *       metallic, id of the texture.
     * </ul>
     */
    static ByteBuffer mesh(int id, Mesh mesh, ToIntFunction<Object> assetId) {
        FloatBuffer vertices = mesh.vertices();
        IntBuffer triangles = mesh.triangles();
        Optional<FloatBuffer> normals = mesh.normals();
        Optional<FloatBuffer> coordinates = mesh.textureCoordinates();
        Optional<IntBuffer> colours = mesh.colours();
        int numbers =
                vertices.remaining()
                        + triangles.remaining()
                        + normals.map(FloatBuffer::remaining).orElse(0)
                        + coordinates.map(FloatBuffer::remaining).orElse(0)
                        + colours.map(IntBuffer::remaining).orElse(0);
        ByteBuffer out =
                ByteBuffer.allocate(
                                HEADER_BYTES
                                        + Float.BYTES * numbers
                                        + PART_BYTES * mesh.parts().size())
                        .order(ByteOrder.LITTLE_ENDIAN);
        out.putInt(MESH).putInt(id);
        out.putInt(vertices.remaining() / 3).putInt(triangles.remaining());
        out.putInt(
                (normals.isPresent() ? NORMALS : 0)
                        | (coordinates.isPresent() ? TEXTURE_COORDINATES : 0)
                        | (colours.isPresent() ? COLOURS : 0));
        out.putInt(mesh.parts().size());
        put(out, vertices);
        normals.ifPresent(values -> put(out, values));
        coordinates.ifPresent(values -> put(out, values));
        colours.ifPresent(values -> put(out, values));
        put(out, triangles);
        for (Mesh.Part part : mesh.parts()) {
            out.putInt(part.firstTriangle()).putInt(part.triangleCount());
            out.putInt(part.material().colour().rgba());
            out.putFloat((float) part.material().roughness());
            out.putFloat((float) part.material().metallic());
            out.putInt(part.material().texture().map(assetId::applyAsInt).orElse(0));
        }
        return out.flip().asReadOnlyBuffer();
    }

    /**
     * Returns a texture as a message: type, id, width, height, then the bytes r g b a of each pixel
     * from the upper left.
     */
    static ByteBuffer texture(int id, Texture texture) {
        ByteBuffer rgba = texture.rgba();
        ByteBuffer out =
                ByteBuffer.allocate(4 * Integer.BYTES + rgba.remaining())
                        .order(ByteOrder.LITTLE_ENDIAN);
        out.putInt(TEXTURE).putInt(id).putInt(texture.width()).putInt(texture.height());
        return out.put(rgba).flip().asReadOnlyBuffer();
    }

    private static void put(ByteBuffer out, FloatBuffer values) {
        while (values.hasRemaining()) {
            out.putFloat(values.get());
        }
    }

    private static void put(ByteBuffer out, IntBuffer values) {
        while (values.hasRemaining()) {
            out.putInt(values.get());
        }
    }
}
