// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Texture;

import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.nio.channels.Channels;
import java.nio.channels.WritableByteChannel;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * The client side of the scene stream, version 3 (vesper-native/render/SCENE.md). It writes
 * messages, reads answers, and tracks which meshes and textures the renderer has.
 */
final class SceneStream {

    static final int OK = 0;
    static final int MALFORMED = 1;

    private static final int VERSION = 3;
    private static final byte[] MAGIC = "VSCN".getBytes(StandardCharsets.US_ASCII);
    private static final int HELLO = 1;
    private static final int IMAGE = 2;
    private static final int CAMERA = 3;
    private static final int ENVIRONMENT = 4;
    private static final int MESH = 5;
    private static final int INSTANCES = 6;
    private static final int SEGMENTS = 7;
    private static final int RENDER = 8;
    private static final int TEXTURE = 9;
    private static final int MATERIAL = 10;
    private static final int TRIANGLES = 11;
    private static final int TO_ANSWER = 0;
    private static final int TO_FILE = 1;
    private static final int TO_PIXELS = 2;
    private static final int NORMALS = 1;
    private static final int COORDINATES = 2;
    private static final int COLOURS = 4;
    private static final int MAX_ANSWER_BYTES = 256 << 20;

    /**
     * An answer of the renderer. The payload is a PNG, pixels or nothing if the status is OK.
     * Otherwise the payload is the reason.
     */
    record Answer(int status, byte[] payload) {
        String reason() {
            return new String(payload, StandardCharsets.UTF_8);
        }
    }

    private final OutputStream out;
    private final WritableByteChannel channel;
    private final InputStream in;
    private final ByteBuffer scratch = ByteBuffer.allocate(128).order(ByteOrder.LITTLE_ENDIAN);
    private final Map<Mesh, Integer> meshIds = new LinkedHashMap<>();
    private final Map<Texture, Integer> textureIds = new LinkedHashMap<>();
    private int lastId;

    SceneStream(OutputStream out, InputStream in) {
        this.out = out;
        this.channel = Channels.newChannel(out);
        this.in = in;
    }

    /** Opens the stream and exchanges versions. */
    Answer hello() throws IOException {
        begin(HELLO).put(MAGIC).putInt(VERSION);
        end(List.of());
        out.flush();
        return readAnswer();
    }

    /**
     * Sends a scene and waits for its picture.
     *
     * @param path the file to write; if empty, the answer contains the picture
     */
    Answer render(Scene scene, String path) throws IOException {
        byte[] bytes = path.getBytes(StandardCharsets.UTF_8);
        return answer(scene, path.isEmpty() ? TO_ANSWER : TO_FILE, ByteBuffer.wrap(bytes));
    }

    /**
     * Sends a scene and waits for its pixels.
     *
     * @param layers the requested layers, a sum of the constants of {@link PixelLayers}
     */
    Answer pixels(Scene scene, int layers) throws IOException {
        ByteBuffer wanted = ByteBuffer.allocate(4).order(ByteOrder.LITTLE_ENDIAN).putInt(layers);
        return answer(scene, TO_PIXELS, wanted.flip());
    }

    private Answer answer(Scene scene, int destination, ByteBuffer what) throws IOException {
        try {
            write(scene, destination, what);
        } catch (IOException cut) {
            return lastWords(cut);
        }
        return readAnswer();
    }

    /**
     * Reads the renderer's last answer after a failed write. The renderer sends such an answer
     * before it stops reading, and the answer contains the reason.
     */
    private Answer lastWords(IOException cut) throws IOException {
        try {
            return readAnswer();
        } catch (IOException silent) {
            cut.addSuppressed(silent);
            throw cut;
        }
    }

    private void write(Scene scene, int destination, ByteBuffer what) throws IOException {
        writeSettings(scene);
        writeMeshes(scene);
        Map<Material, Integer> materials = writeMaterials(scene);
        for (var entry : scene.instances().entrySet()) {
            writeInstances(
                    entry.getKey(), materials.get(entry.getKey().material()), entry.getValue());
        }
        for (var entry : scene.segments().entrySet()) {
            Segments segments = entry.getValue();
            begin(SEGMENTS).putInt(segments.count()).putFloat(entry.getKey());
            end(segments.columns());
        }
        begin(TRIANGLES).putInt(scene.triangles().count());
        end(scene.triangles().columns());
        begin(RENDER).putInt(destination);
        endWith(List.of(what));
        out.flush();
    }

    private void writeSettings(Scene scene) throws IOException {
        ImageFormat image = scene.image();
        begin(IMAGE)
                .putInt(image.width())
                .putInt(image.height())
                .putInt(image.samples())
                .putInt(image.shadows() ? 1 : 0);
        end(List.of());

        Camera camera = scene.camera();
        begin(CAMERA).putInt(camera.orthographic() ? 1 : 0);
        put(camera.eye());
        put(camera.target());
        put(camera.up());
        scratch.putFloat((float) camera.extent());
        end(List.of());

        Environment environment = scene.environment();
        begin(ENVIRONMENT).putInt(environment.top().rgba()).putInt(environment.bottom().rgba());
        put(environment.toLight());
        scratch.putFloat((float) environment.light()).putFloat((float) environment.ambient());
        end(List.of());
    }

    /**
     * Sends the meshes of the scene that the renderer lacks. Makes the renderer free the meshes
     * that the scene does not use.
     */
    private void writeMeshes(Scene scene) throws IOException {
        Set<Mesh> wanted = new LinkedHashSet<>();
        for (Scene.Look look : scene.instances().keySet()) {
            if (look.mesh() != null) {
                wanted.add(look.mesh());
            }
        }
        for (Mesh mesh : new ArrayList<>(meshIds.keySet())) {
            if (!wanted.contains(mesh)) {
                begin(MESH).putInt(meshIds.remove(mesh)).putInt(0).putInt(0).putInt(0);
                end(List.of());
            }
        }
        for (Mesh mesh : wanted) {
            if (!meshIds.containsKey(mesh)) {
                meshIds.put(mesh, ++lastId);
                writeMesh(lastId, mesh);
            }
        }
    }

    private void writeMesh(int id, Mesh mesh) throws IOException {
        int attributes =
                (mesh.normals().isPresent() ? NORMALS : 0)
                        | (mesh.textureCoordinates().isPresent() ? COORDINATES : 0)
                        | (mesh.colours().isPresent() ? COLOURS : 0);
        begin(MESH)
                .putInt(id)
                .putInt(mesh.vertices().remaining() / 3)
                .putInt(mesh.triangles().remaining() / 3)
                .putInt(attributes);
        List<ByteBuffer> numbers = new ArrayList<>();
        numbers.add(bytes(mesh.vertices()));
        mesh.normals().map(SceneStream::bytes).ifPresent(numbers::add);
        mesh.textureCoordinates().map(SceneStream::bytes).ifPresent(numbers::add);
        mesh.colours().map(SceneStream::bytes).ifPresent(numbers::add);
        numbers.add(bytes(mesh.triangles()));
        endWith(numbers);
    }

    private static ByteBuffer bytes(FloatBuffer numbers) {
        ByteBuffer bytes = allocate(numbers.remaining());
        bytes.asFloatBuffer().put(numbers);
        return bytes;
    }

    private static ByteBuffer bytes(IntBuffer numbers) {
        ByteBuffer bytes = allocate(numbers.remaining());
        bytes.asIntBuffer().put(numbers);
        return bytes;
    }

    private static ByteBuffer allocate(int numbers) {
        return ByteBuffer.allocate(4 * numbers).order(ByteOrder.LITTLE_ENDIAN);
    }

    /**
     * Sends the textures that the renderer lacks. Makes the renderer free the textures that the
     * scene does not use.
     */
    private void writeTextures(Collection<Material> materials) throws IOException {
        Set<Texture> wanted = new LinkedHashSet<>();
        materials.forEach(material -> material.texture().ifPresent(wanted::add));
        for (Texture texture : new ArrayList<>(textureIds.keySet())) {
            if (!wanted.contains(texture)) {
                begin(TEXTURE).putInt(textureIds.remove(texture)).putInt(0).putInt(0);
                end(List.of());
            }
        }
        for (Texture texture : wanted) {
            if (!textureIds.containsKey(texture)) {
                textureIds.put(texture, ++lastId);
                begin(TEXTURE).putInt(lastId).putInt(texture.width()).putInt(texture.height());
                endWith(List.of(texture.rgba()));
            }
        }
    }

    /** Sends the materials of the instances, and returns the number of each material. */
    private Map<Material, Integer> writeMaterials(Scene scene) throws IOException {
        Map<Material, Integer> ids = new LinkedHashMap<>();
        ids.put(Material.DEFAULT, 0);
        scene.instances().keySet().forEach(look -> ids.putIfAbsent(look.material(), ids.size()));
        writeTextures(ids.keySet());
        for (var entry : ids.entrySet()) {
            Material material = entry.getKey();
            if (entry.getValue() > 0) {
                begin(MATERIAL)
                        .putInt(entry.getValue())
                        .putInt(material.colour().rgba())
                        .putFloat((float) material.roughness())
                        .putFloat((float) material.metallic())
                        .putInt(material.texture().map(textureIds::get).orElse(0));
                end(List.of());
            }
        }
        return ids;
    }

    private void writeInstances(Scene.Look look, int material, Instances instances)
            throws IOException {
        Integer mesh = look.mesh() == null ? null : meshIds.get(look.mesh());
        begin(INSTANCES)
                .putInt(look.shape())
                .putInt(mesh == null ? 0 : mesh)
                .putInt(material)
                .putInt(look.firstTriangle())
                .putInt(look.triangleCount())
                .putInt(instances.count());
        end(instances.columns());
    }

    private void put(Point point) {
        scratch.putFloat((float) point.x()).putFloat((float) point.y()).putFloat((float) point.z());
    }

    /**
     * Begins a message in the scratch buffer. The length at the beginning is set when the message
     * is complete.
     */
    private ByteBuffer begin(int type) {
        return scratch.clear().putInt(type).putInt(0);
    }

    private void end(List<GrowingColumn> columns) throws IOException {
        endWith(columns.stream().map(GrowingColumn::content).toList());
    }

    private void endWith(List<ByteBuffer> rest) throws IOException {
        long length = scratch.position() - 8L;
        for (ByteBuffer part : rest) {
            length += part.remaining();
        }
        scratch.putInt(4, Math.toIntExact(length));
        out.write(scratch.array(), 0, scratch.position());
        for (ByteBuffer part : rest) {
            while (part.hasRemaining()) {
                channel.write(part);
            }
        }
    }

    private Answer readAnswer() throws IOException {
        ByteBuffer header = ByteBuffer.wrap(in.readNBytes(12)).order(ByteOrder.LITTLE_ENDIAN);
        if (header.remaining() < 12) {
            throw new IOException("it ended without an answer");
        }
        int status = header.getInt();
        int length = header.getInt(8);
        if (length < 0 || length > MAX_ANSWER_BYTES) {
            throw new IOException(
                    "it announced an answer of "
                            + Integer.toUnsignedLong(length)
                            + " bytes, at most "
                            + MAX_ANSWER_BYTES
                            + " are expected");
        }
        byte[] payload = in.readNBytes(length);
        if (payload.length < length) {
            throw new IOException("it ended inside its answer");
        }
        return new Answer(status, payload);
    }
}
