// SPDX-License-Identifier: Apache-2.0
import reve.core.derive.DerivedColumns;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.space.Box;
import reve.core.world.FrameControl;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.lang.management.ManagementFactory;
import java.lang.ref.Reference;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Random;

/**
 * Measures one row of bench/results/world_store.md: the load time of a world of moving balls in a
 * new process, the memory of an item, and the cost of queries, updates and attached items. See
 * docs/benchmarks.md.
 *
 * <p>The memory of a world is the memory that further worlds of the same size add. The memory
 * outside of the heap is the growth of the resident set, because the heap is resident from the
 * start. The memory in the heap is the growth of used memory after a garbage collection.
 */
final class StoreBench {

    private static final int SLOTS = 4;

    /**
     * Number of worlds over which memory is averaged, because the memory of the JVM itself varies.
     */
    private static final int WORLDS = 4;

    private static final int FRAMES = 200;
    private static final int QUERIES = 200;
    private static final double SIDE = 100;

    private final Random random = new Random(1);
    private final int items;
    private final World world;
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop;
    private final SnapshotRing ring;

    private StoreBench(String prototype, int items) {
        this.items = items;
        world = new World("bench", WorldPrototype.standard(prototype), new OffHeapArena());
        loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
        ring = new SnapshotRing(world, SLOTS);
    }

    public static void main(String[] arguments) throws Exception {
        String prototype = arguments[0];
        int items = Integer.parseInt(arguments[1]);
        var first = new StoreBench(prototype, items); // also triggers the JVM's own allocations
        long start = System.nanoTime();
        first.load();
        double loadSeconds = (System.nanoTime() - start) / 1e9;
        first.run();
        first.loop.run(FRAMES);
        first.space();
        long heapBefore = usedHeap();
        long outsideBefore = residentBytes();
        List<StoreBench> more = new ArrayList<>();
        for (int i = 0; i < WORLDS; i++) {
            var world = new StoreBench(prototype, items);
            world.load();
            world.run();
            more.add(world);
        }
        double heap = (usedHeap() - heapBefore) / (double) items / WORLDS;
        double outside = (residentBytes() - outsideBefore) / (double) items / WORLDS;
        Reference.reachabilityFence(first);
        StoreBench last = more.getLast();
        System.out.printf(
                "| %s | %,d | %.2f | %.0f | %.0f | %.0f | %s | %s |%n",
                prototype,
                items,
                loadSeconds,
                heap,
                outside,
                heap + outside,
                last.space(),
                last.attached());
    }

    /**
     * Loads all items at once, as a world file does. The definitions of the items come from code.
     */
    private void load() {
        List<ItemDefinition> definitions = new ArrayList<>();
        for (int i = 0; i < items; i++) {
            definitions.add(
                    ItemDefinition.named("ball " + i)
                            .at(any(), any(), any())
                            .shape(Shape.sphere(0.25))
                            .physics("mass", 1)
                            .physics(
                                    "velocity",
                                    random.nextGaussian(),
                                    random.nextGaussian(),
                                    random.nextGaussian())
                            .build());
        }
        world.addAll(definitions);
    }

    /** Runs frames in which all items move. Each frame is published to readers. */
    private void run() {
        bus.subscribe(FramePhase.PHYSICS, "motion", event -> move(event.dtSeconds()));
        DerivedColumns.subscribeTo(bus);
        bus.subscribe(
                FramePhase.PUBLISH,
                "snapshots",
                event -> ring.publish(event.frame(), event.timeSeconds()));
        loop.run(2 * SLOTS);
    }

    /** Moves all items. Writes the same columns as a law of motion with forces. */
    private void move(double dtSeconds) {
        var bodies = world.table("body");
        var positions = bodies.column("position");
        var velocities = bodies.column("velocity");
        var forces = bodies.column("externalForce");
        var accelerations = bodies.column("acceleration");
        for (int row = 0; row < items; row++) {
            for (int axis = 0; axis < 3; axis++) {
                double position = positions.getDouble(row, axis);
                double force = SIDE / 2 - position;
                double velocity = velocities.getDouble(row, axis) + dtSeconds * force;
                forces.setDouble(row, axis, force);
                accelerations.setDouble(row, axis, force);
                velocities.setDouble(row, axis, velocity);
                positions.setDouble(row, axis, position + dtSeconds * velocity);
            }
        }
    }

    /** Returns medians: update of the tree [ms], query of a region and of the ten nearest [us]. */
    private String space() {
        List<Double> updates = new ArrayList<>();
        List<Double> regions = new ArrayList<>();
        List<Double> nearest = new ArrayList<>();
        long hits = 0;
        for (int frame = 0; frame < FRAMES; frame++) {
            loop.step();
            long start = System.nanoTime();
            world.space().nearest(0, 0, 0, 1);
            long updated = System.nanoTime();
            for (int i = 0; i < QUERIES; i++) {
                hits += world.space().inBox(Box.around(any(), any(), any(), SIDE / 20)).size();
            }
            long found = System.nanoTime();
            for (int i = 0; i < QUERIES; i++) {
                world.space().nearest(any(), any(), any(), 10);
            }
            updates.add((updated - start) / 1e6);
            regions.add((found - updated) / 1e3 / QUERIES);
            nearest.add((System.nanoTime() - found) / 1e3 / QUERIES);
        }
        return "%.1f | %.1f (%d) | %.1f"
                .formatted(
                        median(updates), median(regions), hits / FRAMES / QUERIES, median(nearest));
    }

    /**
     * Returns the median time to compute the place of an attached item [ns]. A tenth of all items
     * is attached to the other nine tenths.
     */
    private String attached() {
        List<Item> all = world.items();
        int attached = items / 10;
        for (int i = 1; i <= attached; i++) {
            all.get(i).physics().set("mass", 0);
            world.attach(all.get(i).id(), all.get(attached + i).id());
        }
        List<Double> costs = new ArrayList<>();
        for (int i = 0; i < FRAMES; i++) {
            long start = System.nanoTime();
            FrameControl.of(world).placeAttached();
            costs.add((System.nanoTime() - start) / (double) attached);
        }
        return "%.0f".formatted(median(costs));
    }

    private double any() {
        return random.nextDouble() * SIDE;
    }

    private static double median(List<Double> values) {
        double[] sorted = values.stream().mapToDouble(Double::doubleValue).toArray();
        Arrays.sort(sorted);
        return sorted[sorted.length / 2];
    }

    private static long usedHeap() {
        for (int i = 0; i < 3; i++) {
            System.gc();
        }
        return ManagementFactory.getMemoryMXBean().getHeapMemoryUsage().getUsed();
    }

    private static long residentBytes() throws Exception {
        return Files.readAllLines(Path.of("/proc/self/status")).stream()
                .filter(line -> line.startsWith("RssAnon"))
                .findFirst()
                .map(line -> Long.parseLong(line.replaceAll("\\D+", "")) * 1024)
                .orElseThrow();
    }
}
