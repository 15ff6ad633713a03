// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import reve.core.frame.FrameBus;
import reve.core.frame.FramePhase;
import reve.core.world.World;

import java.util.ArrayList;
import java.util.Comparator;
import java.util.List;
import java.util.Locale;
import java.util.function.BooleanSupplier;

/**
 * Keeps the symbols that rules give to items current. Rules are evaluated in their order, so that
 * one may read what those before it gave in the same frame, and only for items of which something
 * that they read has changed. One that gives no value for an item leaves it without the symbol,
 * which is told once per rule. World's thread.
 *
 * <p>All rules share the steps of a frame. Where they take more, the rule that took the most of
 * them is disabled for as long as the world runs, and the items that are left are evaluated in the
 * next frame. Steps are counted, never time, so this happens in the same frame on every machine.
 */
public final class Rules {
    /** Most steps of all rules in one frame, of about 0.1 microseconds. */
    static final long STEPS_PER_FRAME = 40_000_000;

    private final long stepsPerFrame;
    private final List<RuleKeeper> keepers = new ArrayList<>();

    /** With the usual steps per frame. */
    public Rules(World world, List<Rule> rules) {
        this(world, rules, STEPS_PER_FRAME);
    }

    Rules(World world, List<Rule> rules, long stepsPerFrame) {
        this.stepsPerFrame = stepsPerFrame;
        rules.forEach(rule -> keepers.add(new RuleKeeper(world, rule)));
    }

    /**
     * Evaluates in DERIVE of every frame, after what subscribed before.
     *
     * @param stopped whether the world makes no more frames: then the evaluation ends early
     */
    public void subscribeTo(FrameBus bus, BooleanSupplier stopped) {
        bus.subscribe(FramePhase.DERIVE, "rules", event -> update(event.frame(), stopped));
    }

    /**
     * The world was restored: what its items have may be other than what they were given here.
     * Disabled rules are evaluated again, so that what follows depends on the world alone.
     */
    public void forget() {
        keepers.forEach(RuleKeeper::forget);
    }

    /** Evaluates now, as part of that frame. */
    public void update(long frame) {
        update(frame, () -> false);
    }

    private void update(long frame, BooleanSupplier stopped) {
        long left = stepsPerFrame;
        for (int i = 0; i < keepers.size() && !stopped.getAsBoolean(); i++) {
            left -= keepers.get(i).update(frame, left, stopped);
            if (left < 0) {
                disableCostliest(frame, keepers.subList(0, i + 1), stepsPerFrame - left);
                return;
            }
        }
    }

    private void disableCostliest(long frame, List<RuleKeeper> evaluated, long steps) {
        RuleKeeper costliest =
                evaluated.stream().max(Comparator.comparingLong(RuleKeeper::steps)).orElseThrow();
        costliest.disable(
                frame,
                String.format(
                        Locale.ROOT,
                        "took %,d of %,d steps in frame %d, expected at most %,d for all rules: it"
                                + " is disabled and no item has its symbol; let it loop over less, read"
                                + " fewer relations, or hold for a class of items",
                        costliest.steps(),
                        steps,
                        frame,
                        stepsPerFrame));
    }
}
