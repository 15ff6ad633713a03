// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render; // the renderer's process id is visible in this package only

import reve.core.derive.BoundingBoxes;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.Random;

/**
 * Measures rows of bench/results/cameras.md: the rate at which one renderer makes the pictures of
 * cameras of bodies, as the server does. See docs/benchmarks.md.
 */
final class CamerasBench {

    private static final int[] CAMERAS = {1, 8, 64};

    /** Layers and shadows of the measured pictures. */
    private enum Layers {
        COLOUR("colour, shadows", PixelLayers.COLOUR, true),
        PLAIN("colour, no shadows", PixelLayers.COLOUR, false),
        SENSED("depth, items", PixelLayers.DEPTH | PixelLayers.ITEM, true);

        final String title;
        final int layers;
        final boolean shadows;

        Layers(String title, int layers, boolean shadows) {
            this.title = title;
            this.layers = layers;
            this.shadows = shadows;
        }
    }

    private final Random random = new Random(1);
    private final World world =
            new World("bench", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final List<Item> bodies = new ArrayList<>();
    private final Renderer renderer;
    private final int items;

    private CamerasBench(Path nativeFolder, int items) {
        this.items = items;
        renderer = new Renderer(nativeFolder, Duration.ofSeconds(60));
        double side = 2 * Math.sqrt(items);
        world.add(ItemDefinition.named("ground").shape(Shape.plane(2 * side, 2 * side)).build());
        for (int i = 0; i < items; i++) {
            Shape shape = i % 2 == 0 ? Shape.sphere(0.5) : Shape.box(1, 1, 1);
            add("item-" + i, shape, side);
        }
        for (int i = 0; i < CAMERAS[CAMERAS.length - 1]; i++) {
            bodies.add(add("body-" + i, Shape.box(0.3, 0.3, 0.3), side));
        }
        new BoundingBoxes().update(world);
    }

    private Item add(String name, Shape shape, double side) {
        double half = Math.PI * random.nextDouble();
        return world.add(
                ItemDefinition.named(name)
                        .shape(shape)
                        .at(
                                side * (random.nextDouble() - 0.5),
                                0.5 + random.nextDouble(),
                                side * (random.nextDouble() - 0.5))
                        .orientation(0, Math.sin(half), 0, Math.cos(half))
                        .build());
    }

    private double rendererSeconds() {
        return 1e-9
                * ProcessHandle.of(renderer.pid())
                        .flatMap(handle -> handle.info().totalCpuDuration())
                        .orElseThrow()
                        .toNanos();
    }

    private void measure(
            WorldSnapshot snapshot,
            Layers what,
            int width,
            int height,
            int cameras,
            double seconds,
            int rounds) {
        var format = new ImageFormat(width, height, 4, what.shadows);
        double[] rates = new double[rounds];
        double building = 0;
        double drawing = 0;
        long pictures = 0;
        for (int round = -1; round < rounds; round++) {
            double drawn = round < 0 ? 0 : rendererSeconds();
            long start = System.nanoTime();
            long count = 0;
            double least = round < 0 ? 0.1 * seconds : seconds;
            while (System.nanoTime() - start < 1e9 * least || round >= 0 && count % cameras != 0) {
                Item body = bodies.get((int) (count++ % cameras));
                long begun = System.nanoTime();
                Camera view = SceneBuilder.viewOf(snapshot, body.id(), 1.2).orElseThrow();
                Scene scene =
                        new SceneBuilder(
                                        format,
                                        Environment.STUDIO,
                                        Optional.of(view),
                                        Optional.of(body.id()))
                                .build(snapshot);
                if (round >= 0) {
                    building += System.nanoTime() - begun;
                }
                renderer.pixels(scene, what.layers);
            }
            if (round >= 0) { // the first round compiles shaders and code of the JVM
                rates[round] = count / (1e-9 * (System.nanoTime() - start));
                drawing += rendererSeconds() - drawn;
                pictures += count;
            }
        }
        Arrays.sort(rates);
        double rate = rates[rounds / 2];
        System.out.printf(
                "| %,d | %s | %d x %d | %d | %.0f [%.0f, %.0f] | %.1f | %.2f | %.2f | %.2f |%n",
                items,
                what.title,
                width,
                height,
                cameras,
                rate,
                rates[rounds / 4],
                rates[3 * rounds / 4],
                rate / cameras,
                1000 / rate,
                1e-6 * building / pictures,
                1000 * drawing / pictures);
    }

    public static void main(String[] given) {
        double seconds = Double.parseDouble(given[1]);
        int rounds = Integer.parseInt(given[2]);
        for (int at = 3; at < given.length; at++) {
            var bench = new CamerasBench(Path.of(given[0]), Integer.parseInt(given[at]));
            var ring = new SnapshotRing(bench.world, 2);
            ring.publish(1, 1);
            try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow();
                    Renderer renderer = bench.renderer) {
                for (Layers what : Layers.values()) {
                    for (int[] size : new int[][] {{64, 64}, {320, 240}}) {
                        for (int cameras : CAMERAS) {
                            bench.measure(
                                    snapshot, what, size[0], size[1], cameras, seconds, rounds);
                        }
                    }
                }
            }
        }
    }
}
