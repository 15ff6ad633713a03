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
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Locale;
import java.util.Map;

/**
 * Measures the cost of laws that run apart (in a sandbox), and of the same laws in the engine's
 * process.
 *
 * <p>java ApartCost.java BODIES STEPS FRAMES PACED_FRAMES; {@code bench/laws_apart/run} calls it.
 *
 * <p>Three engines advance equal worlds, in turn: one engine with all laws in its process, one
 * engine with one law apart, and one engine with all laws apart. Prints one line. For each engine,
 * it contains the tenth percentile and the median of the time of a frame [us], back to back and
 * then at 60 Hz.
 */
class ApartCost {
    private static final List<String> LAWS = List.of("gravity_field", "drag", "newton_motion");
    private static final String ONE = "libvesper_law_drag.so";
    private static final double DT = 1.0 / 240;
    private static final long FRAME_NANOS = 16_666_667;
    private static final int BATCH = 20;
    private static final List<ApartRule> RULES =
            List.of(
                    ApartRule.NEVER,
                    (file, library) ->
                            file.orElseThrow().endsWith(ONE)
                                    ? ApartRule.Isolation.APART
                                    : ApartRule.Isolation.NONE,
                    (file, library) -> ApartRule.Isolation.APART);

    public static void main(String[] arguments) throws Exception {
        int[] numbers = Arrays.stream(arguments).mapToInt(Integer::parseInt).toArray();
        Path natives = Path.of(System.getProperty("reve.native.path"));
        List<Subject> subjects = new ArrayList<>();
        try (Hosts hosts = new Hosts(natives.resolve("vesper-host"), 0)) {
            for (ApartRule rule : RULES) {
                subjects.add(new Subject(numbers[0], hosts, natives, rule));
            }
            measure(subjects, numbers[1], new long[RULES.size()][300]);
            long[][] fast = new long[RULES.size()][numbers[2]];
            measure(subjects, numbers[1], fast);
            long[][] paced = new long[RULES.size()][numbers[3]];
            for (int frame = 0; frame < numbers[3]; frame++) {
                for (int i = 0; i < paced.length; i++) {
                    Thread.sleep(Duration.ofNanos(FRAME_NANOS / 3));
                    paced[i][frame] = subjects.get(i).advance(numbers[1]);
                }
            }
            long hash = subjects.getFirst().engine.stateHash();
            for (Subject subject : subjects) {
                if (subject.engine.stateHash() != hash) {
                    throw new IllegalStateException("laws apart have other bits");
                }
            }
            StringBuilder line = new StringBuilder();
            for (int i = 0; i < RULES.size(); i++) {
                line.append(
                        String.format(
                                Locale.ROOT,
                                "%.1f %.1f %.1f %.1f ",
                                at(fast[i], 0.1),
                                at(fast[i], 0.5),
                                at(paced[i], 0.1),
                                at(paced[i], 0.5)));
            }
            System.out.println(line);
            subjects.forEach(Subject::close);
        }
    }

    private static void measure(List<Subject> subjects, int steps, long[][] times) {
        for (int frame = 0; frame < times[0].length; frame += BATCH) {
            for (int subject = 0; subject < times.length; subject++) {
                for (int i = frame; i < Math.min(frame + BATCH, times[0].length); i++) {
                    times[subject][i] = subjects.get(subject).advance(steps);
                }
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

        Subject(int bodies, Hosts hosts, Path natives, ApartRule rule) {
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
                    new HostedEngine(
                            hosts, Duration.ofSeconds(10), config, prototype, rule, arena::part);
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
