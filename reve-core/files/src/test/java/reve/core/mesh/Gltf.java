// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import java.io.ByteArrayOutputStream;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Base64;
import java.util.Collections;
import java.util.List;
import java.util.Locale;

/**
 * Writes glTF files for tests. It shares no code with the reader, and writes accessors and JSON
 * itself.
 */
final class Gltf {

    static final String TRIANGLE_MESH =
            "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}]";

    private final ByteArrayOutputStream binary = new ByteArrayOutputStream();
    private final List<String> views = new ArrayList<>();
    private final List<String> accessors = new ArrayList<>();

    /** Adds an accessor of reals and returns its number. */
    int reals(String type, int components, float... values) {
        ByteBuffer bytes = ByteBuffer.allocate(4 * values.length).order(ByteOrder.LITTLE_ENDIAN);
        for (float value : values) {
            bytes.putFloat(value);
        }
        return accessor(5126, type, values.length / components, view(bytes.array()));
    }

    /** Adds an accessor of 16-bit indices and returns its number. */
    int indices(int... values) {
        ByteBuffer bytes = ByteBuffer.allocate(2 * values.length).order(ByteOrder.LITTLE_ENDIAN);
        for (int value : values) {
            bytes.putShort((short) value);
        }
        return accessor(5123, "SCALAR", values.length, view(bytes.array()));
    }

    /** Adds a bufferView and returns its number. */
    int view(byte[] bytes) {
        while (binary.size() % 4 != 0) {
            binary.write(0);
        }
        views.add(
                String.format(
                        Locale.ROOT,
                        "{\"buffer\": 0, \"byteOffset\": %d, \"byteLength\": %d}",
                        binary.size(),
                        bytes.length));
        binary.writeBytes(bytes);
        return views.size() - 1;
    }

    int accessor(int componentType, String type, int count, int view) {
        accessors.add(
                String.format(
                        Locale.ROOT,
                        "{\"bufferView\": %d, \"componentType\": %d, "
                                + "\"count\": %d, \"type\": \"%s\"}",
                        view,
                        componentType,
                        count,
                        type));
        return accessors.size() - 1;
    }

    /** Returns the JSON with the added parts and {@code rest}, the members that use them. */
    String json(String uri, String rest) {
        return "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": "
                + binary.size()
                + (uri.isEmpty() ? "" : ", \"uri\": \"" + uri + "\"")
                + "}], \"bufferViews\": ["
                + String.join(", ", views)
                + "], \"accessors\": ["
                + String.join(", ", accessors)
                + "], "
                + rest
                + "}";
    }

    byte[] binary() {
        return binary.toByteArray();
    }

    /** A .glb file. */
    byte[] glb(String rest) {
        return glb(json("", rest), binary());
    }

    static byte[] glb(String json, byte[] binary) {
        byte[] text =
                (json + " ".repeat((4 - json.length() % 4) % 4)).getBytes(StandardCharsets.UTF_8);
        int padded = (binary.length + 3) / 4 * 4;
        ByteBuffer file =
                ByteBuffer.allocate(28 + text.length + padded).order(ByteOrder.LITTLE_ENDIAN);
        file.putInt(0x46546c67).putInt(2).putInt(file.capacity());
        file.putInt(text.length).putInt(0x4e4f534a).put(text);
        file.putInt(padded).putInt(0x004e4942).put(binary);
        return file.array();
    }

    /** Returns a .gltf file with its numbers in a data URI. */
    String embedded(String rest) {
        return json(
                "data:application/octet-stream;base64,"
                        + Base64.getEncoder().encodeToString(binary()),
                rest);
    }

    /** One triangle (0 0 0, 1 0 0, 0 1 0), as accessor 0. */
    static Gltf triangle() {
        var gltf = new Gltf();
        gltf.reals("VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0);
        return gltf;
    }

    /** Returns a scene of all these nodes. */
    static String scene(String... nodes) {
        List<String> numbers = new ArrayList<>();
        for (int i = 0; i < nodes.length; i++) {
            numbers.add(String.valueOf(i));
        }
        return "\"nodes\": ["
                + String.join(", ", nodes)
                + "], \"scenes\": [{\"nodes\": ["
                + String.join(", ", numbers)
                + "]}]";
    }

    /** Returns copies of a text, as a list. */
    static String list(String text, int count) {
        return String.join(", ", Collections.nCopies(count, text));
    }
}
