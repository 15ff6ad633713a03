package reve.core.rule;

import java.util.ArrayList;
import java.util.List;
import reve.core.frame.FrameBus;
import reve.core.frame.FramePhase;
import reve.core.world.World;

/**
 * Keeps the symbols that rules give to items current. Rules are evaluated in their order, so that
 * one may read what those before it gave in the same frame, and only for items of which something
 * that they read has changed. One that gives no value for an item leaves it without the symbol,
 * which is told once per rule. World's thread.
 */
public final class Rules {
    private final List<RuleKeeper> keepers = new ArrayList<>();

    public Rules(World world, List<Rule> rules) {
        rules.forEach(rule -> keepers.add(new RuleKeeper(world, rule)));
    }

    /** Evaluates in DERIVE of every frame, after what subscribed before. */
    public void subscribeTo(FrameBus bus) {
        bus.subscribe(FramePhase.DERIVE, "rules", event -> update(event.frame()));
    }

    /** The world was restored: what its items have may be other than what they were given here. */
    public void forget() {
        keepers.forEach(RuleKeeper::forget);
    }

    /** Evaluates now, as part of that frame. */
    public void update(long frame) {
        for (int i = 0; i < keepers.size(); i++) {
            keepers.get(i).update(frame);
        }
    }
}
