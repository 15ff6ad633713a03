// SPDX-License-Identifier: Apache-2.0
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

/**
 * Measures the cost of a frame's physics with an engine in this process, and with an engine in a
 * separate process.
 *
 * <p>java FrameCost.java BODIES STEPS FRAMES PACED_FRAMES; {@code bench/engine_process/run} calls
 * it.
 *
 * <p>Both engines advance equal worlds, in turn. Prints one line. For each engine, it contains the
 * tenth percentile and the median of the time of a frame [us], back to back and then at 60 Hz.
 */
class FrameCost {
    private static final List<String> LAWS = List.of("gravity_field", "drag", "newton_motion");
    private static final double DT = 1.0 / 240;
    private static final long FRAME_NANOS = 16_666_667;
    private static final int BATCH = 20;

    public static void main(String[] arguments) throws Exception {
        int[] numbers = Arrays.stream(arguments).mapToInt(Integer::parseInt).toArray();
        Path natives = Path.of(System.getProperty("reve.native.path"));
        try (Hosts hosts = new Hosts(natives.resolve("vesper-host"), 0);
                Subject here = new Subject(numbers[0], null, natives);
                Subject hosted = new Subject(numbers[0], hosts, natives)) {
            long[][] fast = {new long[numbers[2]], new long[numbers[2]]};
            measure(here, hosted, numbers[1], new long[2][1000]);
            measure(here, hosted, numbers[1], fast);
            long[][] paced = {new long[numbers[3]], new long[numbers[3]]};
            for (int frame = 0; frame < numbers[3]; frame++) {
                pause();
                paced[0][frame] = here.advance(numbers[1]);
                pause();
                paced[1][frame] = hosted.advance(numbers[1]);
            }
            if (here.engine.stateHash() == 0 || hosted.engine.stateHash() == 0) {
                throw new IllegalStateException("no state");
            }
            System.out.printf(
                    Locale.ROOT,
                    "%d %.1f %.1f %.1f %.1f %.1f %.1f %.1f %.1f%n",
                    numbers[0],
                    at(fast[0], 0.1),
                    at(fast[0], 0.5),
                    at(fast[1], 0.1),
                    at(fast[1], 0.5),
                    at(paced[0], 0.1),
                    at(paced[0], 0.5),
                    at(paced[1], 0.1),
                    at(paced[1], 0.5));
        }
    }

    private static void pause() throws InterruptedException {
        Thread.sleep(Duration.ofNanos(FRAME_NANOS / 2));
    }

    private static void measure(Subject one, Subject other, int steps, long[][] times) {
        for (int frame = 0; frame < times[0].length; frame += BATCH) {
            for (int i = frame; i < Math.min(frame + BATCH, times[0].length); i++) {
                times[0][i] = one.advance(steps);
            }
            for (int i = frame; i < Math.min(frame + BATCH, times[1].length); i++) {
                times[1][i] = other.advance(steps);
            }
        }
    }

    private static double at(long[] times, double part) {
        long[] sorted = times.clone();
        Arrays.sort(sorted);
        return sorted.length == 0 ? 0 : sorted[(int) (part * (sorted.length - 1))] * 1e-3;
    }

    /** A world and its engine. */
    private static final class Subject implements AutoCloseable {
        final SharedArena arena = new SharedArena();
        final PhysicsEngine engine;
        final PhysicsAdapter adapter;

        Subject(int bodies, Hosts hosts, Path natives) {
            World world = new World("bodies", WorldPrototype.standard("si-f64"), arena);
            for (int i = 0; i < bodies; i++) {
                world.add(
                        ItemDefinition.named("b" + i)
                                .at(i % 100, i / 100 % 100, i / 10_000)
                                .physics("mass", 1)
                                .physics("velocity", 1, 0, 0)
                                .build());
            }
            VesperConfig config = VesperConfig.of(List.of(natives.resolve("laws")));
            Prototype prototype =
                    PropertyNames.prototype(
                            world.prototype(), VesperEngine.standardPrototype("si-f64"));
            engine =
                    hosts == null
                            ? new VesperEngine(config, prototype)
                            : new HostedEngine(
                                    hosts,
                                    Duration.ofSeconds(10),
                                    config,
                                    prototype,
                                    ApartRule.NEVER,
                                    arena::part);
            adapter = new PhysicsAdapter(world, engine, arena);
            LAWS.forEach(law -> adapter.laws().load(0, law, Map.of()));
        }

        long advance(int steps) {
            long start = System.nanoTime();
            engine.advance(DT, steps);
            return System.nanoTime() - start;
        }

        @Override
        public void close() {
            engine.close();
            adapter.close();
            arena.close();
        }
    }
}
