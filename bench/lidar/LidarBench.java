// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception; // the numbers of a reading are visible in this package only

import reve.core.derive.BoundingBoxes;
import reve.core.space.BoxIndex;
import reve.core.space.Effort;
import reve.core.space.LocalRay;
import reve.core.world.ColumnView;
import reve.core.world.Instrument;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.TableView;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.lang.foreign.MemorySegment;
import java.lang.management.ManagementFactory;
import java.lang.management.ThreadMXBean;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Random;
import java.util.stream.LongStream;

/**
 * Measures one row of bench/results/lidar.md: the processor time of all lidars in a frame, in turn
 * with the search ray by ray that the server used before. See docs/benchmarks.md.
 */
final class LidarBench {

    private static final double RANGE = 50;
    private static final int MOST = 100_000;
    private static final ThreadMXBean THREADS = ManagementFactory.getThreadMXBean();

    private final Random random = new Random(1);
    private final World world =
            new World("bench", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final Instrument.Lidar lidar;
    private final List<Item> bodies = new ArrayList<>();
    private final List<Senses> agents = new ArrayList<>();
    private final Observatory observatory = new Observatory();
    private final BoundingBoxes boxes = new BoundingBoxes();
    private final SnapshotRing ring = new SnapshotRing(world, 2);
    private long frame;

    private LidarBench(int items, int lidars, int columns, int rows) {
        lidar =
                new Instrument.Lidar(
                        columns,
                        rows,
                        Sensor.ALL_ROUND,
                        rows == 1 ? 0 : Math.toRadians(40),
                        RANGE,
                        0,
                        0);
        double side = Math.cbrt(8.0 * items);
        for (int i = 0; i < items; i++) {
            Shape shape = i % 2 == 0 ? Shape.sphere(0.5) : Shape.box(1, 1, 1);
            world.add(at(ItemDefinition.named("item-" + i).shape(shape), side).build());
        }
        Sensor sensor = Sensor.measuring("scan", lidar);
        for (int i = 0; i < lidars; i++) {
            Item body =
                    world.add(at(ItemDefinition.named("body-" + i), side).sensor(sensor).build());
            bodies.add(body);
            agents.add(new Senses(body.id(), List.of(sensor)));
        }
    }

    private ItemDefinition.Builder at(ItemDefinition.Builder item, double side) {
        double[] turn = new double[4];
        double square = 0;
        for (int i = 0; i < 4; i++) {
            turn[i] = random.nextGaussian();
            square += turn[i] * turn[i];
        }
        double length = Math.sqrt(square);
        return item.at(
                        side * (random.nextDouble() - 0.5),
                        side * (random.nextDouble() - 0.5),
                        side * (random.nextDouble() - 0.5))
                .orientation(
                        turn[0] / length, turn[1] / length, turn[2] / length, turn[3] / length);
    }

    /** Returns the processor time of all scans of a frame [ms], with the index of the boxes. */
    private double scans(double[][] measured) {
        boxes.update(world);
        ring.publish(++frame, frame / 60.0);
        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            observatory.read(snapshot);
        }
        long start = THREADS.getCurrentThreadCpuTime();
        for (int i = 0; i < agents.size(); i++) {
            measured[i] =
                    agents.get(i)
                            .look(observatory, () -> true)
                            .orElseThrow()
                            .readings()
                            .getFirst()
                            .quantities()
                            .getFirst()
                            .numbers();
        }
        return 1e-6 * (THREADS.getCurrentThreadCpuTime() - start);
    }

    /** The search ray by ray. */
    private final class Rays {
        final int count;
        final double[] size;
        final double[] places;
        final int[] shapes;
        final BoxIndex index = new BoxIndex();
        final LocalRay ray = new LocalRay();
        final Effort effort = new Effort();
        final double[] own = new double[7];
        final double[] place = new double[7];
        final double[] direction = new double[3];
        final double[] directions = new double[3 * lidar.rays()];
        final BoxIndex.RayTest test = this::distance;
        final TableView table;
        final MemorySegment ids;
        int looker;

        Rays(TableView table) {
            this.table = table;
            count = table.rowCount();
            size = numbers(table.column("size"));
            double[] positions = numbers(table.column("position"));
            double[] orientations = numbers(table.column("orientation"));
            places = new double[7 * count];
            shapes = new int[count];
            for (int row = 0; row < count; row++) {
                System.arraycopy(positions, 3 * row, places, 7 * row, 3);
                System.arraycopy(orientations, 4 * row, places, 7 * row + 3, 4);
                shapes[row] = table.column("shape").getInt(row, 0);
            }
            ids = MemorySegment.ofArray(LongStream.range(0, count).toArray());
            for (int i = 0; i < lidar.rays(); i++) {
                double side = lidar.sideways(i % lidar.columns());
                double up = lidar.upwards(i / lidar.columns());
                directions[3 * i] = StrictMath.sin(side) * StrictMath.cos(up);
                directions[3 * i + 1] = StrictMath.sin(up);
                directions[3 * i + 2] = StrictMath.cos(side) * StrictMath.cos(up);
            }
        }

        static double[] numbers(ColumnView column) {
            double[] all = new double[column.rowCount() * column.components()];
            for (int i = 0; i < all.length; i++) {
                all[i] = column.getDouble(i / column.components(), i % column.components());
            }
            return all;
        }

        /** Returns the processor time of all scans [ms], with the index of the boxes. */
        double scans(double[][] measured) {
            long start = THREADS.getCurrentThreadCpuTime();
            index.build(
                    ids,
                    table.column("boundsMin").segment(),
                    table.column("boundsMax").segment(),
                    count);
            for (int i = 0; i < bodies.size(); i++) {
                looker = table.rowOf(bodies.get(i).id());
                System.arraycopy(places, 7 * looker, own, 0, 7);
                double[] distances = new double[lidar.rays()];
                for (int k = 0; k < distances.length; k++) {
                    turn(3 * k);
                    effort.begin(MOST);
                    double distance = index.nearestOnRay(own, direction, RANGE, test, effort);
                    distances[k] = distance <= RANGE ? distance : -1;
                }
                measured[i] = distances;
            }
            return 1e-6 * (THREADS.getCurrentThreadCpuTime() - start);
        }

        private void turn(int at) {
            double x = directions[at];
            double y = directions[at + 1];
            double z = directions[at + 2];
            double cx = 2 * (own[4] * z - own[5] * y);
            double cy = 2 * (own[5] * x - own[3] * z);
            double cz = 2 * (own[3] * y - own[4] * x);
            direction[0] = x + own[6] * cx + (own[4] * cz - own[5] * cy);
            direction[1] = y + own[6] * cy + (own[5] * cx - own[3] * cz);
            direction[2] = z + own[6] * cz + (own[3] * cy - own[4] * cx);
        }

        private double distance(long key, double most) {
            int row = (int) key;
            if (row == looker || shapes[row] == Shape.NONE) {
                return Double.POSITIVE_INFINITY;
            }
            System.arraycopy(places, 7 * row, place, 0, 7);
            ray.set(own, direction, place);
            double x = 0.5 * size[3 * row];
            return shapes[row] == Shape.SPHERE
                    ? ray.toSphere(x)
                    : ray.toBox(x, 0.5 * size[3 * row + 1], 0.5 * size[3 * row + 2]);
        }
    }

    private void run(int rounds) {
        int lidars = agents.size();
        double[][] found = new double[lidars][];
        double[][] expected = new double[lidars][];
        double[] scans = new double[rounds];
        double[] rays = new double[rounds];
        scans(found);
        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            Rays search = new Rays(snapshot.table(WorldPrototype.BODY));
            for (int round = -rounds / 2; round < rounds; round++) {
                double one = scans(found);
                double other = search.scans(expected);
                if (round >= 0) { // the first rounds let the JVM compile the code
                    scans[round] = one;
                    rays[round] = other;
                }
            }
        }
        if (!Arrays.deepEquals(found, expected)) {
            throw new IllegalStateException("the two methods measure different distances");
        }
        double[] ratios = new double[rounds];
        for (int i = 0; i < rounds; i++) {
            ratios[i] = rays[i] / scans[i];
        }
        int total = lidars * lidar.rays();
        long met = Arrays.stream(found).flatMapToDouble(Arrays::stream).filter(d -> d >= 0).count();
        System.out.printf(
                "| %,d | %d x %d x %d | %,d | %.0f %% | %s | %s | %.3f | %.3f | %s |%n",
                world.table(WorldPrototype.BODY).rowCount() - lidars,
                lidars,
                lidar.columns(),
                lidar.rows(),
                total,
                100.0 * met / total,
                quartiles(rays),
                quartiles(scans),
                1000 * median(rays) / total,
                1000 * median(scans) / total,
                quartiles(ratios));
    }

    private static double median(double[] values) {
        return quantile(values, 0.5);
    }

    private static double quantile(double[] values, double part) {
        double[] sorted = values.clone();
        Arrays.sort(sorted);
        return sorted[(int) Math.round(part * (sorted.length - 1))];
    }

    private static String quartiles(double[] values) {
        return String.format(
                "%.3g [%.3g, %.3g]",
                median(values), quantile(values, 0.25), quantile(values, 0.75));
    }

    public static void main(String[] given) {
        int[] numbers = Arrays.stream(given).mapToInt(Integer::parseInt).toArray();
        new LidarBench(numbers[0], numbers[1], numbers[2], numbers[3]).run(numbers[4]);
    }
}
