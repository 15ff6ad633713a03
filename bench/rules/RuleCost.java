// SPDX-License-Identifier: Apache-2.0
import reve.core.rule.Rule;
import reve.core.rule.Rules;
import reve.core.rule.Scope;
import reve.core.unit.Unit;
import reve.core.world.FrameControl;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.lang.management.ManagementFactory;
import java.util.Arrays;
import java.util.List;
import java.util.Locale;
import java.util.Optional;

/**
 * Measures the cost of a rule per item and frame.
 *
 * <p>java RuleCost.java ROUNDS; {@code bench/rules/run} calls it.
 *
 * <p>Ten thousand items have one rule whose symbol does not change. First nothing changes; then all
 * temperatures change in each frame. Prints the median of the last rounds, after JIT compilation.
 */
class RuleCost {
    private static final int ITEMS = 10_000;
    private static final int FRAMES = 100;
    private static final int REPORTED_ROUNDS = 9;

    public static void main(String[] arguments) throws Exception {
        var temperature =
                new PropertyDescriptor(
                        "temperature",
                        "body",
                        ScalarType.F64,
                        1,
                        Unit.parse("K"),
                        Optional.empty(),
                        "");
        WorldPrototype prototype =
                WorldPrototype.standard("si-f64").extendedBy(List.of(temperature));
        try (var arena = new OffHeapArena()) {
            World world = new World("rules", prototype, arena);
            for (int i = 0; i < ITEMS; i++) {
                world.add(ItemDefinition.named("i" + i).physics("temperature", 300).build());
            }
            var rule =
                    new Rule(
                            "hot",
                            "body",
                            Optional.empty(),
                            Scope.ofItem(prototype, "body").compile("physics.temperature > 350"),
                            "");
            var rules = new Rules(world, List.of(rule), 40_000_000);
            int rounds = Integer.parseInt(arguments[0]);
            report("unchanged", world, rules, false, rounds);
            report("changed", world, rules, true, rounds);
        }
    }

    private static void report(String what, World world, Rules rules, boolean change, int rounds) {
        var threads = (com.sun.management.ThreadMXBean) ManagementFactory.getThreadMXBean();
        double[] nanoseconds = new double[rounds];
        double bytes = 0;
        for (int round = 0; round < rounds; round++) {
            long spent = 0;
            long allocated = 0;
            for (int frame = 0; frame < FRAMES; frame++) {
                if (change) {
                    for (Item item : world.items()) {
                        if (!item.kind().equals(WorldPrototype.WORLD)) {
                            item.physics().set("temperature", 200 + (frame + round) % 100);
                        }
                    }
                }
                long before = threads.getCurrentThreadAllocatedBytes();
                long start = System.nanoTime();
                rules.update(frame);
                spent += System.nanoTime() - start;
                allocated += threads.getCurrentThreadAllocatedBytes() - before;
                FrameControl.of(world).end();
            }
            nanoseconds[round] = (double) spent / FRAMES / ITEMS;
            bytes = (double) allocated / FRAMES / ITEMS;
        }
        double[] last = Arrays.copyOfRange(nanoseconds, rounds - REPORTED_ROUNDS, rounds);
        Arrays.sort(last);
        System.out.printf(
                Locale.ROOT,
                "%s: %.0f ns and %.0f bytes per item and frame%n",
                what,
                last[REPORTED_ROUNDS / 2],
                bytes);
    }
}
