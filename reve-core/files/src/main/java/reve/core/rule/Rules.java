// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import reve.core.frame.FrameBus;
import reve.core.frame.FramePhase;
import reve.core.world.World;

import java.util.ArrayList;
import java.util.Comparator;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.function.BooleanSupplier;

/**
 * Updater of the symbols of all rules. Rules are evaluated in their order, so that a rule may read
 * the results of earlier rules in the same frame. A rule is evaluated only for items with changed
 * inputs. An item for which a rule has no value does not have the symbol. This is reported once per
 * rule. For the world's thread only.
 *
 * <p>The number of evaluation steps of all rules in a frame is limited, so that rules never delay a
 * frame for long. The remaining items keep their symbols and are evaluated in the next frames if
 * the rules need more steps. The limit of the first update is higher, so that a large world begins
 * with all symbols. The same is true for the first update after {@link #forget}.
 *
 * <p>The limit counts steps instead of time. Every machine therefore evaluates the same items in
 * the same frames.
 */
public final class Rules {
    /** Default maximum number of steps of all rules in one frame. */
    public static final long DEFAULT_STEPS = 200_000;

    /** Maximum number of steps of all rules in the first update. */
    static final long FIRST_STEPS = 40_000_000;

    private final World world;
    private final long stepsPerFrame;
    private final long firstSteps;
    private final List<RuleKeeper> keepers = new ArrayList<>();

    private boolean first = true;
    private boolean reported;

    /**
     * Index of the rule with which the next update starts. The next field is the row at which it
     * starts.
     */
    private int nextKeeper;

    private int nextRow;

    /**
     * @param rules rules of the world, in the order of evaluation
     * @param stepsPerFrame maximum number of evaluation steps in one frame
     */
    public Rules(World world, List<Rule> rules, long stepsPerFrame) {
        this(world, rules, stepsPerFrame, FIRST_STEPS);
    }

    Rules(World world, List<Rule> rules, long stepsPerFrame, long firstSteps) {
        this.world = world;
        this.stepsPerFrame = stepsPerFrame;
        this.firstSteps = firstSteps;
        rules.forEach(rule -> keepers.add(new RuleKeeper(world, rule)));
    }

    /**
     * Subscribes to the phase DERIVE of every frame, to evaluate the rules. Listeners that
     * subscribed earlier are called first.
     *
     * @param stopped returns true if the world will make no more frames; the evaluation then ends
     *     early
     */
    public void subscribeTo(FrameBus bus, BooleanSupplier stopped) {
        bus.subscribe(FramePhase.DERIVE, "rules", event -> update(event.frame(), stopped));
    }

    /**
     * Makes the next update evaluate all rules for all items. Called after the world was restored,
     * because the stored inputs belong to another state.
     */
    public void forget() {
        first = true;
        reported = false;
        nextKeeper = 0;
        nextRow = 0;
        keepers.forEach(RuleKeeper::forget);
    }

    /**
     * Replaces the rules. Items lose the symbols of rules that are not among the new ones. The next
     * update evaluates the new rules for all items. Called outside the phase DERIVE.
     */
    public void set(List<Rule> rules) {
        Map<Rule, RuleKeeper> before = new IdentityHashMap<>();
        keepers.forEach(keeper -> before.put(keeper.rule(), keeper));
        keepers.clear();
        for (Rule rule : rules) {
            RuleKeeper known = before.remove(rule);
            keepers.add(known == null ? new RuleKeeper(world, rule) : known);
        }
        before.values().forEach(RuleKeeper::takeBack);
        first = true;
        nextKeeper = 0;
        nextRow = 0;
    }

    /** Evaluates rules now, as part of the given frame. */
    public void update(long frame) {
        update(frame, () -> false);
    }

    private void update(long frame, BooleanSupplier stopped) {
        long most = first ? firstSteps : stepsPerFrame;
        first = false;
        if (nextKeeper == 0 && nextRow == 0) {
            world.charges().beginPass();
        }
        long left = most;
        int firstKeeper = nextKeeper;
        for (int i = nextKeeper; i < keepers.size(); i++) {
            RuleKeeper keeper = keepers.get(i);
            nextKeeper = i;
            nextRow = keeper.update(frame, nextRow, left, stopped);
            left -= keeper.steps();
            if (nextRow != RuleKeeper.COMPLETE) {
                if (left < 0) {
                    report(frame, keepers.subList(firstKeeper, i + 1), most, most - left);
                }
                return;
            }
            nextRow = 0;
        }
        nextKeeper = 0;
    }

    /**
     * Reports that symbols may be outdated, because the rules need more steps than a frame has. The
     * report names the costliest rule. The report is made only once.
     */
    private void report(long frame, List<RuleKeeper> evaluated, long most, long steps) {
        if (reported) {
            return;
        }
        reported = true;
        RuleKeeper costliest =
                evaluated.stream().max(Comparator.comparingLong(RuleKeeper::steps)).orElseThrow();
        costliest.reportTooManySteps(
                frame,
                String.format(
                        Locale.ROOT,
                        "took %,d of %,d steps in frame %d, expected at most %,d for all rules of a"
                                + " frame: from now on symbols of rules may be some frames old; let"
                                + " the rule loop over less, read fewer relations or hold for a"
                                + " class of items, or raise `frame: {ruleSteps: %d}` (reported"
                                + " once)",
                        costliest.steps(),
                        steps,
                        frame,
                        most,
                        stepsPerFrame));
    }
}
