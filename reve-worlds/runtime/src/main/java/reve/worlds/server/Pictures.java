// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.frame.FrameEvent;
import reve.core.world.WorldSnapshot;
import reve.worlds.Product;
import reve.worlds.render.Camera;
import reve.worlds.render.Environment;
import reve.worlds.render.ImageFormat;
import reve.worlds.render.Renderer;
import reve.worlds.render.Scene;
import reve.worlds.render.SceneBuilder;

import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.TimeUnit;

/**
 * Pictures of a running world at given frames. The world's thread only builds the scene; another
 * thread draws it. The world continues if a picture fails.
 */
public final class Pictures implements AutoCloseable {
    /** Default size of pictures. */
    public static final ImageFormat DEFAULT_FORMAT = ImageFormat.of(960, 640);

    private static final long PATIENCE_SECONDS = 120;

    private final Path folder;
    private final long[] frames;
    private final Renderer renderer =
            new Renderer(Product.nativeFolder(), Renderer.DEFAULT_DEADLINE);
    private final ExecutorService artist =
            Executors.newSingleThreadExecutor(
                    Thread.ofPlatform().daemon().name("pictures").factory());
    private int next;
    private boolean wanted;

    /**
     * Creates the taker of pictures, which draws nothing yet.
     *
     * @param folder the folder for the pictures; their names contain the world and the frame
     * @param frames the frames at whose end a picture is taken
     */
    public Pictures(Path folder, List<Long> frames) {
        this.folder = folder;
        this.frames = frames.stream().mapToLong(Long::longValue).sorted().distinct().toArray();
    }

    /** Subscribes to the frames of a simulation; called once, before its loop runs. */
    void subscribeTo(Simulation simulation, ServerEvents events) {
        simulation.onPublish("pictures", frame -> onFrame(frame, simulation, events));
    }

    /** Requests a picture of the current frame. For the world's thread, before PUBLISH. */
    void takeNext() {
        wanted = true;
    }

    /** Returns the name of the file of a picture, without its folder. */
    static String fileName(String world, long frame) {
        return String.format(Locale.ROOT, "%s-%06d.png", world, frame);
    }

    /** Returns a scene builder for a simulation, with the world's camera if it has one. */
    public static SceneBuilder sceneBuilder(Simulation simulation, ImageFormat format) {
        return sceneBuilder(format, simulation.description().camera().map(Camera::of));
    }

    /**
     * Returns a scene builder with a viewpoint.
     *
     * @param camera if empty, all bodies except planes are fitted into the picture
     */
    public static SceneBuilder sceneBuilder(ImageFormat format, Optional<Camera> camera) {
        return new SceneBuilder(format, Environment.STUDIO, camera);
    }

    private void onFrame(FrameEvent frame, Simulation simulation, ServerEvents events) {
        boolean listed = next < frames.length && frame.frame() >= frames[next];
        if (!listed && !wanted) {
            return;
        }
        next += listed ? 1 : 0;
        wanted = false;
        Path file = folder.resolve(fileName(simulation.world().name(), frame.frame()));
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("frame", frame.frame());
        fields.put("time", frame.timeSeconds());
        fields.put("file", file.toAbsolutePath().normalize().toString());
        try (WorldSnapshot snapshot = simulation.snapshots().acquireLatest().orElseThrow()) {
            Scene scene = sceneBuilder(simulation, DEFAULT_FORMAT).build(snapshot);
            artist.execute(() -> draw(scene, file, fields, events));
        } catch (RuntimeException failed) {
            tellFailure(failed, fields, events);
        }
    }

    private void draw(Scene scene, Path file, Map<String, Object> fields, ServerEvents events) {
        try {
            renderer.render(scene, file);
            events.happened("picture", fields);
        } catch (RuntimeException failed) {
            tellFailure(failed, fields, events);
        }
    }

    private static void tellFailure(
            RuntimeException failed, Map<String, Object> fields, ServerEvents events) {
        fields.put("message", String.valueOf(failed.getMessage()));
        events.happened("picture-failed", fields);
    }

    /** Finishes the pictures in progress, then ends the renderer. Idempotent. */
    @Override
    public void close() {
        artist.shutdown();
        try {
            artist.awaitTermination(PATIENCE_SECONDS, TimeUnit.SECONDS);
        } catch (InterruptedException hurried) {
            Thread.currentThread().interrupt();
        }
        renderer.close();
    }
}
