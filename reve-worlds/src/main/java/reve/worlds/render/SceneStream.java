package reve.worlds.render;

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
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import reve.core.world.Mesh;
import reve.core.world.Shape;

/**
 * Our end of the scene stream, version 1 (vesper-native/render/SCENE.md): writes messages, reads
 * answers, and knows which meshes the other end has.
 */
final class SceneStream {

    static final int OK = 0;
    static final int MALFORMED = 1;

    private static final int VERSION = 1;
    private static final byte[] MAGIC = "VSCN".getBytes(StandardCharsets.US_ASCII);
    private static final int HELLO = 1;
    private static final int IMAGE = 2;
    private static final int CAMERA = 3;
    private static final int ENVIRONMENT = 4;
    private static final int MESH = 5;
    private static final int INSTANCES = 6;
    private static final int SEGMENTS = 7;
    private static final int RENDER = 8;
    private static final int MAX_ANSWER_BYTES = 256 << 20;

    /** What came back: the PNG or nothing if OK, else the reason. */
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
    private int lastMeshId;

    SceneStream(OutputStream out, InputStream in) {
        this.out = out;
        this.channel = Channels.newChannel(out);
        this.in = in;
    }

    /** Opens the conversation. */
    Answer hello() throws IOException {
        begin(HELLO).put(MAGIC).putInt(VERSION);
        end(List.of());
        out.flush();
        return readAnswer();
    }

    /**
     * Sends a scene and waits for its picture.
     *
     * @param path the file to write, or empty for a picture in the answer
     */
    Answer render(Scene scene, String path) throws IOException {
        try {
            write(scene, path);
        } catch (IOException cut) {
            return lastWords(cut);
        }
        return readAnswer();
    }

    /** What the other end said before it stopped reading, which is why. */
    private Answer lastWords(IOException cut) throws IOException {
        try {
            return readAnswer();
        } catch (IOException silent) {
            cut.addSuppressed(silent);
            throw cut;
        }
    }

    private void write(Scene scene, String path) throws IOException {
        writeSettings(scene);
        writeMeshes(scene);
        for (var entry : scene.simple().entrySet()) {
            writeInstances(entry.getKey(), 0, entry.getValue());
        }
        for (var entry : scene.meshes().entrySet()) {
            writeInstances(Shape.MESH, meshIds.get(entry.getKey()), entry.getValue());
        }
        for (var entry : scene.segments().entrySet()) {
            Segments segments = entry.getValue();
            begin(SEGMENTS).putInt(segments.count()).putFloat(entry.getKey());
            end(segments.columns());
        }
        begin(RENDER).putInt(path.isEmpty() ? 0 : 1);
        endWith(List.of(ByteBuffer.wrap(path.getBytes(StandardCharsets.UTF_8))));
        out.flush();
    }

    private void writeSettings(Scene scene) throws IOException {
        ImageFormat image = scene.image();
        begin(IMAGE).putInt(image.width()).putInt(image.height()).putInt(image.samples())
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

    /** Sends the scene's meshes that the other end lacks and frees those it needs no more. */
    private void writeMeshes(Scene scene) throws IOException {
        for (Mesh mesh : new ArrayList<>(meshIds.keySet())) {
            if (!scene.meshes().containsKey(mesh)) {
                begin(MESH).putInt(meshIds.remove(mesh)).putInt(0).putInt(0).putInt(0);
                end(List.of());
            }
        }
        for (Mesh mesh : scene.meshes().keySet()) {
            if (!meshIds.containsKey(mesh)) {
                meshIds.put(mesh, ++lastMeshId);
                writeMesh(lastMeshId, mesh);
            }
        }
    }

    private void writeMesh(int id, Mesh mesh) throws IOException {
        FloatBuffer vertices = mesh.vertices();
        IntBuffer triangles = mesh.triangles();
        begin(MESH).putInt(id).putInt(vertices.remaining() / 3).putInt(triangles.remaining() / 3)
                .putInt(0);
        var numbers = ByteBuffer.allocate((vertices.remaining() + triangles.remaining()) * 4)
                .order(ByteOrder.LITTLE_ENDIAN);
        while (vertices.hasRemaining()) {
            numbers.putFloat(vertices.get());
        }
        while (triangles.hasRemaining()) {
            numbers.putInt(triangles.get());
        }
        endWith(List.of(numbers.flip()));
    }

    private void writeInstances(int shape, int meshId, Instances instances) throws IOException {
        begin(INSTANCES).putInt(shape).putInt(meshId).putInt(instances.count());
        end(instances.columns());
    }

    private void put(Point point) {
        scratch.putFloat((float) point.x()).putFloat((float) point.y()).putFloat((float) point.z());
    }

    /** Begins a message in the scratch buffer; its length is filled in at the end. */
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
            throw new IOException("it announced an answer of " + Integer.toUnsignedLong(length)
                    + " bytes, at most " + MAX_ANSWER_BYTES + " are expected");
        }
        byte[] payload = in.readNBytes(length);
        if (payload.length < length) {
            throw new IOException("it ended inside its answer");
        }
        return new Answer(status, payload);
    }
}
