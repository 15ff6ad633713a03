// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.agent.port.Cameras;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Sensor;
import reve.core.world.SnapshotRing;
import reve.core.world.WorldSnapshot;
import reve.worlds.render.Camera;
import reve.worlds.render.Environment;
import reve.worlds.render.ImageFormat;
import reve.worlds.render.PixelLayers;
import reve.worlds.render.RenderException;
import reve.worlds.render.Renderer;
import reve.worlds.render.Scene;
import reve.worlds.render.SceneBuilder;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.RejectedExecutionException;
import java.util.concurrent.ThreadPoolExecutor;
import java.util.concurrent.TimeUnit;

/**
 * Renders the pictures of bodies' cameras on its own thread, one after the other. A picture does
 * not show the body that carries the camera.
 */
final class BodyCameras implements Cameras, AutoCloseable {

    private static final int SAMPLES = 4;
    private static final int MAX_WAITING = 1024;

    /**
     * Maximum number of attempts to make a picture. An attempt fails if its snapshot is overwritten
     * while the scene is built.
     */
    private static final int ATTEMPTS = 3;

    private static final int MAX_NAMES = 0xffff;

    /** Reports that the body that carries the camera has left the world. */
    private static final class GoneException extends RuntimeException {
        private static final long serialVersionUID = 1;
    }

    private final SnapshotRing snapshots;
    private final Renderer renderer;
    private final ThreadPoolExecutor artist =
            new ThreadPoolExecutor(
                    1,
                    1,
                    0,
                    TimeUnit.SECONDS,
                    new LinkedBlockingQueue<>(MAX_WAITING),
                    Thread.ofPlatform().daemon().name("cameras of bodies").factory());

    /**
     * @param renderer the renderer, which this object closes
     */
    BodyCameras(SnapshotRing snapshots, Renderer renderer) {
        this.snapshots = snapshots;
        this.renderer = renderer;
    }

    @Override
    public void take(ItemId body, Sensor camera, Answer answer) {
        try {
            artist.execute(() -> draw(body, camera, answer));
        } catch (RejectedExecutionException full) {
            answer.refused("too many pictures are being taken");
        }
    }

    private void draw(ItemId body, Sensor camera, Answer answer) {
        Photo photo;
        try {
            photo = photo(body, camera);
        } catch (GoneException gone) {
            answer.refused("the body has left the world");
            return;
        } catch (RuntimeException failed) {
            answer.failed(failed);
            return;
        }
        answer.taken(photo);
    }

    private Photo photo(ItemId body, Sensor sensor) {
        for (int attempt = 1; ; attempt++) {
            try (WorldSnapshot snapshot =
                    snapshots
                            .acquireLatest()
                            .orElseThrow(
                                    () -> new RenderException("the world has not begun yet"))) {
                return photo(snapshot, body, sensor);
            } catch (RenderException lost) {
                if (attempt == ATTEMPTS) {
                    throw lost;
                }
            }
        }
    }

    private Photo photo(WorldSnapshot snapshot, ItemId body, Sensor sensor) {
        Sensor.Camera camera = sensor.camera().orElseThrow();
        Camera view =
                SceneBuilder.viewOf(snapshot, body, sensor.fieldOfView())
                        .orElseThrow(GoneException::new);
        Scene scene =
                new SceneBuilder(
                                new ImageFormat(camera.width(), camera.height(), SAMPLES, true),
                                Environment.STUDIO,
                                Optional.of(view),
                                Optional.of(body))
                        .build(snapshot);
        boolean ranged = Double.isFinite(sensor.range());
        PixelLayers seen = renderer.pixels(scene, layers(camera, ranged));
        Optional<byte[]> colour = seen.colour().map(BodyCameras::bytes);
        Optional<byte[]> depth = seen.depth().map(BodyCameras::bytes);
        Optional<byte[]> items = seen.item().map(BodyCameras::bytes);
        if (ranged) {
            forgetBeyond((float) sensor.range(), depth.orElseThrow(), colour, items);
        }
        var names = new ArrayList<String>();
        Optional<byte[]> numbers = items.map(ids -> number(ids, snapshot, names));
        return new Photo(
                snapshot.frame(),
                snapshot.timeSeconds(),
                camera.width(),
                camera.height(),
                colour,
                depth.filter(any -> camera.layers().contains(Sensor.Layer.DEPTH)),
                numbers,
                List.copyOf(names));
    }

    private static int layers(Sensor.Camera camera, boolean ranged) {
        int layers = ranged ? PixelLayers.DEPTH : 0;
        for (Sensor.Layer layer : camera.layers()) {
            layers |=
                    switch (layer) {
                        case COLOUR -> PixelLayers.COLOUR;
                        case DEPTH -> PixelLayers.DEPTH;
                        case ITEMS -> PixelLayers.ITEM;
                    };
        }
        return layers;
    }

    private static byte[] bytes(ByteBuffer buffer) {
        byte[] bytes = new byte[buffer.remaining()];
        buffer.get(bytes);
        return bytes;
    }

    private static ByteBuffer numbers(byte[] bytes) {
        return ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN);
    }

    /** Clears the pixels beyond the camera's range. They become black and show no item. */
    private static void forgetBeyond(
            float range, byte[] depth, Optional<byte[]> colour, Optional<byte[]> items) {
        ByteBuffer depths = numbers(depth);
        for (int pixel = 0; pixel < depth.length / 4; pixel++) {
            float far = depths.getFloat(4 * pixel);
            if (far > 0 && far <= range) {
                continue;
            }
            depths.putFloat(4 * pixel, 0);
            int at = pixel;
            colour.ifPresent(
                    rgb -> {
                        for (int channel = 0; channel < 3; channel++) {
                            rgb[3 * at + channel] = 0;
                        }
                    });
            items.ifPresent(ids -> numbers(ids).putInt(4 * at, 0));
        }
    }

    /**
     * Replaces the ids of items in the pixels by numbers from 1, in the order of the items' first
     * pixels.
     */
    private static byte[] number(byte[] ids, WorldSnapshot snapshot, List<String> names) {
        Map<Integer, Short> known = new HashMap<>();
        ByteBuffer from = numbers(ids);
        ByteBuffer to = numbers(new byte[ids.length / 2]);
        while (from.hasRemaining()) {
            int id = from.getInt();
            Short number = id == 0 ? Short.valueOf((short) 0) : known.get(id);
            if (number == null) {
                ItemSymbols item = snapshot.symbols().get(new ItemId(id));
                number = item == null || names.size() == MAX_NAMES ? 0 : (short) (names.size() + 1);
                if (number != 0) {
                    names.add(item.name());
                }
                known.put(id, number);
            }
            to.putShort(number);
        }
        return to.array();
    }

    /** Ends the renderer, which aborts the picture in progress. Idempotent. */
    @Override
    public void close() {
        artist.shutdownNow();
        renderer.close();
    }
}
