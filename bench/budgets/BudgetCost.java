// SPDX-License-Identifier: Apache-2.0
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.TimeBudget;
import reve.core.frame.Timing;
import reve.core.world.ItemDefinition;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsEngine;
import reve.pe.Prototype;
import reve.pe.adapter.PhysicsAdapter;
import reve.pe.adapter.PropertyNames;
import reve.pe.adapter.SharedArena;
import reve.pe.hosted.ApartRule;
import reve.pe.hosted.HostedEngine;
import reve.pe.hosted.Hosts;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;

import java.nio.file.Path;
import java.time.Duration;
import java.util.Arrays;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/**
 * Measures what the times of laws and their budgets cost in a frame.
 *
 * <p>java BudgetCost.java LAW_FOLDER BODIES STEPS ROUNDS FRAMES LAWS...; {@code bench/budgets/run}
 * calls it.
 *
 * <p>Each world has a library of LAWS laws with an empty body, in the engine's process. Prints one
 * line for each number of laws. It contains the medians, over rounds, of the time of a frame
 * without and with a budget, of reading the laws' times once, and of all readings of the clock in a
 * frame, two for each call of a law [us].
 */
class BudgetCost {
    private static final int RATE = 60;

    public static void main(String[] arguments) {
        Path natives = Path.of(System.getProperty("reve.native.path"));
        int[] numbers = Arrays.stream(arguments).skip(1).mapToInt(Integer::parseInt).toArray();
        int bodies = numbers[0];
        int steps = numbers[1];
        int rounds = numbers[2];
        int frames = numbers[3];
        try (Hosts hosts = new Hosts(natives.resolve("vesper-host"), 0)) {
            for (int laws : Arrays.copyOfRange(numbers, 4, numbers.length)) {
                Path folder = Path.of(arguments[0]);
                try (Subject without = new Subject(hosts, folder, bodies, steps, laws, false);
                        Subject with = new Subject(hosts, folder, bodies, steps, laws, true)) {
                    without.frames(frames);
                    with.frames(frames);
                    double[][] times = new double[4][rounds];
                    for (int round = 0; round < rounds; round++) {
                        times[0][round] = without.frames(frames);
                        times[1][round] = with.frames(frames);
                        times[2][round] = with.readings(frames);
                        times[3][round] = clock(2 * steps * laws, frames);
                    }
                    System.out.printf(
                            Locale.ROOT,
                            "%d %.3f %.3f %.3f %.3f%n",
                            laws,
                            median(times[0]),
                            median(times[1]),
                            median(times[2]),
                            median(times[3]));
                }
            }
        }
    }

    /** Returns the time of {@code readings} readings of the system's clock [us]. */
    private static double clock(int readings, int times) {
        long sum = 0;
        long start = System.nanoTime();
        for (long i = (long) readings * times; i > 0; i--) {
            sum += System.nanoTime();
        }
        double spent = (System.nanoTime() - start) * 1e-3 / times;
        if (sum == 0) {
            throw new IllegalStateException("no clock");
        }
        return spent;
    }

    private static double median(double[] values) {
        double[] sorted = values.clone();
        Arrays.sort(sorted);
        return sorted[sorted.length / 2];
    }

    /** A world with empty laws, whose engine runs in a separate process. */
    private static final class Subject implements AutoCloseable {
        private final SharedArena arena = new SharedArena();
        private final PhysicsEngine engine;
        private final PhysicsAdapter adapter;
        private final FrameLoop loop;
        private final long[] times;

        Subject(Hosts hosts, Path folder, int bodies, int steps, int laws, boolean budget) {
            World world = new World("bodies", WorldPrototype.standard("si-f64"), arena);
            for (int i = 0; i < bodies; i++) {
                world.add(ItemDefinition.named("b" + i).at(i, 0, 0).physics("mass", 1).build());
            }
            Prototype prototype =
                    PropertyNames.prototype(
                            world.prototype(), VesperEngine.standardPrototype("si-f64"));
            engine =
                    new HostedEngine(
                            hosts,
                            Duration.ofSeconds(10),
                            VesperConfig.of(List.of(folder)),
                            prototype,
                            ApartRule.NEVER,
                            arena::part);
            adapter = new PhysicsAdapter(world, engine, arena);
            FrameBus bus = new FrameBus();
            bus.subscribe(FramePhase.PHYSICS, "physics", adapter);
            loop = new FrameLoop(world, bus, new Timing(RATE, steps), Pacing.FAST);
            adapter.laws().load(0, "empty_" + laws, Map.of());
            times = new long[laws];
            if (budget) {
                adapter.enforceBudgets(true);
                adapter.laws()
                        .setBudget(
                                "empty_laws",
                                Optional.of(
                                        new TimeBudget(
                                                1_000_000_000L,
                                                TimeBudget.DEFAULT_FRAMES,
                                                TimeBudget.Response.WARN,
                                                TimeBudget.DEFAULT_EVERY)));
            }
        }

        /** Makes frames, and returns the time of one of them [us]. */
        double frames(int count) {
            long start = System.nanoTime();
            for (int i = 0; i < count; i++) {
                loop.step();
            }
            return (System.nanoTime() - start) * 1e-3 / count;
        }

        /** Reads the times of all laws, and returns the time of a reading [us]. */
        double readings(int count) {
            long start = System.nanoTime();
            for (int i = 0; i < count; i++) {
                engine.readTimes(times);
            }
            return (System.nanoTime() - start) * 1e-3 / count;
        }

        @Override
        public void close() {
            engine.close();
            adapter.close();
            arena.close();
        }
    }
}
