// SPDX-License-Identifier: Apache-2.0
package reve.core.level;

import reve.core.frame.FrameBus;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.world.FrameControl;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.Level;
import reve.core.world.LevelChange;
import reve.core.world.LevelTest;
import reve.core.world.Motion;
import reve.core.world.World;
import reve.core.world.WorldEvent;

import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.SortedSet;

/**
 * Evaluation of the conditions of levels, once per frame, after the commands of the frame and
 * before its laws. If conditions of an item's inactive levels hold, the first of these levels
 * becomes active. For the world's thread only.
 */
public final class LevelKeeper {

    /** Maximum number of evaluation steps of all conditions in a frame. */
    public static final long MAX_STEPS = 200_000;

    /**
     * Number of evaluation steps for each item, in addition to those of its conditions and parts.
     */
    private static final int STEPS_PER_ITEM = 10;

    /** Number of evaluation steps for each part of an item, for the sum of the parts' motions. */
    private static final int STEPS_PER_PART = 4;

    private final Set<ItemId> reported = new HashSet<>();
    private boolean isLimitReported;
    private boolean isPaused;

    /** Subscribes to the phase ACT. Listeners that subscribed earlier are called first. */
    public void subscribeTo(FrameBus bus) {
        bus.subscribe(FramePhase.ACT, "levels", this::onFrame);
    }

    /**
     * Stops or continues the evaluation. A replay evaluates no conditions, because the journal
     * contains the changes of levels.
     */
    public void pause(boolean paused) {
        isPaused = paused;
    }

    private void onFrame(FrameEvent event) {
        SortedSet<ItemId> items = FrameControl.of(event.world()).withLevelConditions();
        if (!isPaused && !items.isEmpty()) {
            update(event, List.copyOf(items));
        }
    }

    private void update(FrameEvent event, List<ItemId> items) {
        World world = event.world();
        long left = MAX_STEPS;
        for (ItemId id : items) {
            if (left < 0) {
                reportLimit(event);
                return;
            }
            left -= update(event, world.item(id));
        }
    }

    /** Evaluates the conditions of an item. Returns the number of evaluation steps. */
    private long update(FrameEvent event, Item item) {
        World world = event.world();
        Level active = item.level().orElseThrow();
        long steps = STEPS_PER_ITEM + STEPS_PER_PART * active.items().size();
        try {
            Motion motion = LevelChange.motion(world, item);
            for (Level level : item.levels()) {
                if (!(level.when().orElse(null) instanceof LevelTest condition)
                        || level.equals(active)) {
                    continue;
                }
                world.activity().begin(condition);
                LevelTest.Result result = condition.test(item, motion);
                world.activity().end(result.steps());
                steps += result.steps();
                if (result.holds()) {
                    steps += LevelChange.steps(item, level.name());
                    LevelChange.prepare(world, item, level.name()).make(event.frame());
                    return steps;
                }
            }
        } catch (IllegalArgumentException refused) {
            world.activity().end();
            if (reported.add(item.id())) {
                raise(event, refused.getMessage() + " (reported once for this item)");
            }
        }
        return steps;
    }

    private void reportLimit(FrameEvent event) {
        if (!isLimitReported) {
            isLimitReported = true;
            raise(
                    event,
                    "the conditions of levels need more than "
                            + MAX_STEPS
                            + " steps in a frame; the conditions of further items were not evaluated;"
                            + " use simpler conditions or fewer items (reported once)");
        }
    }

    private static void raise(FrameEvent event, String message) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("phase", event.phase().name());
        fields.put("source", "levels");
        fields.put("error", "LevelRefused");
        fields.put("message", message);
        event.world().raise(new WorldEvent(event.frame(), "fault", fields));
    }
}
