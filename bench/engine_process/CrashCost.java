// SPDX-License-Identifier: Apache-2.0
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.ItemDefinition;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
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
import java.util.Random;

/**
 * Measures the frame in which a law ends the engine's process: the detection of the crash, the
 * replacement of the process, and the repeated frame.
 *
 * <p>java CrashCost.java BODIES STEPS CRASHES CRASH_LAWS; {@code bench/engine_process/run} calls
 * it. CRASH_LAWS is the folder of the law {@code crash}.
 *
 * <p>The world makes 60 frames in a second. The law crashes in a random step of a frame, in four
 * ways in turn. Prints one line: for each way, and then for all, the median, the 99th percentile
 * and the maximum of the time of the whole frame [us].
 */
class CrashCost {
    private static final List<String> LAWS =
            List.of("gravity_field", "drag", "sphere_contact", "newton_motion");
    private static final int KINDS = 4;

    /**
     * Minimum number of frames before a crash. In the first of these frames, the engine starts a
     * process with its laws.
     */
    private static final int FEWEST_FRAMES = 16;

    private static final int MORE_FRAMES = 12;
    private static final int WARM_UP = 40;
    private static final long FRAME_NANOS = 16_666_667;

    public static void main(String[] arguments) throws Exception {
        int bodies = Integer.parseInt(arguments[0]);
        int steps = Integer.parseInt(arguments[1]);
        int crashes = Integer.parseInt(arguments[2]);
        Path natives = Path.of(System.getProperty("reve.native.path"));
        List<Path> lawPath = List.of(natives.resolve("laws"), Path.of(arguments[3]));
        SharedArena arena = new SharedArena();
        try (Hosts hosts = new Hosts(natives.resolve("vesper-host"), 0)) {
            World world = new World("bodies", WorldPrototype.standard("si-f64"), arena);
            for (int i = 0; i < bodies; i++) {
                world.add(
                        ItemDefinition.named("b" + i)
                                .at(2 * (i % 100), 2 * (i / 100 % 100), 2 * (i / 10_000))
                                .physics("mass", 1)
                                .physics("radius", 0.5)
                                .physics("velocity", 1, 0, 0)
                                .build());
            }
            hosts.keepReady(1);
            VesperConfig config = VesperConfig.of(lawPath);
            Prototype prototype =
                    PropertyNames.prototype(
                            world.prototype(), VesperEngine.standardPrototype("si-f64"));
            HostedEngine engine =
                    new HostedEngine(
                            hosts,
                            Duration.ofMillis(50),
                            config,
                            prototype,
                            ApartRule.NEVER,
                            arena::part);
            PhysicsAdapter adapter = new PhysicsAdapter(world, engine, arena);
            FrameBus bus = new FrameBus();
            new CommandQueue(1000).subscribeTo(bus);
            bus.subscribe(FramePhase.PHYSICS, "physics", adapter);
            FrameLoop loop = new FrameLoop(world, bus, new Timing(60, steps), Pacing.FAST);
            LAWS.forEach(law -> adapter.laws().load(0, law, Map.of()));
            Random random = new Random(19);
            long[][] times = new long[KINDS][(crashes + KINDS - 1) / KINDS];
            for (int crash = -WARM_UP; crash < crashes; crash++) {
                int kind = Math.floorMod(crash, KINDS);
                int frames = FEWEST_FRAMES + random.nextInt(MORE_FRAMES);
                long last = engine.stepCount() + (long) frames * steps + random.nextInt(steps);
                adapter.laws()
                        .load(0, "crash", Map.of("step", (double) last, "kind", (double) kind));
                long redone = adapter.profile().redoneFrames();
                long next = System.nanoTime();
                for (int frame = 0; frame <= frames; frame++) {
                    next += FRAME_NANOS;
                    long start = System.nanoTime();
                    loop.step();
                    long end = System.nanoTime();
                    boolean again = adapter.profile().redoneFrames() > redone;
                    if (again != (frame == frames)) {
                        throw new IllegalStateException("frame " + frame + " of " + frames);
                    }
                    if (again && crash >= 0) {
                        times[kind][crash / KINDS] = end - start;
                    }
                    Thread.sleep(Duration.ofNanos(Math.max(0, next - System.nanoTime())));
                }
                adapter.laws()
                        .quarantined()
                        .forEach(library -> adapter.laws().release(library.sha256()));
            }
            StringBuilder line = new StringBuilder();
            for (long[] ofKind : times) {
                append(line, ofKind);
            }
            append(line, Arrays.stream(times).flatMapToLong(Arrays::stream).toArray());
            System.out.println(line.toString().strip());
            engine.close();
            adapter.close();
        } finally {
            arena.close();
        }
    }

    private static void append(StringBuilder line, long[] times) {
        Arrays.sort(times);
        for (double part : new double[] {0.5, 0.99, 1}) {
            line.append(
                    String.format(
                            Locale.ROOT, " %.1f", times[(int) (part * (times.length - 1))] * 1e-3));
        }
    }
}
