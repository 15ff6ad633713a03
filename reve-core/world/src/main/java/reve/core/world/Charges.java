// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.HashMap;
import java.util.Map;
import java.util.TreeMap;

/**
 * Charges agents for what a frame computes because of their acts: it remembers which agent changed
 * an item last, and adds up the steps that the item's rules then take. World's thread.
 */
public final class Charges {
    /** Who changed an item before the rules began their last pass over all items, and since. */
    private Map<ItemId, String> changedBefore = new HashMap<>();

    private Map<ItemId, String> changedSince = new HashMap<>();
    private final Map<String, Long> steps = new TreeMap<>();
    private @Nullable String acting;

    Charges() {}

    /** An agent acts: until {@link #end}, changes of items are its changes. */
    public void begin(String agent) {
        acting = agent;
    }

    /** The act is over. */
    public void end() {
        acting = null;
    }

    void note(WorldChange change) {
        switch (change) {
            case WorldChange.Removed removed -> {
                forget(removed.item());
                removed.cascade().forEach(this::forget);
            }
            case WorldChange.Restored restored -> {
                changedBefore.clear();
                changedSince.clear();
            }
            case WorldChange.Added added -> {
                for (int i = 0; acting != null && i < added.definitions().size(); i++) {
                    changed(new ItemId(added.first().value() + i));
                }
            }
            case WorldChange.Renamed renamed -> changed(renamed.item());
            case WorldChange.Attached attached -> changed(attached.item());
            case WorldChange.Detached detached -> changed(detached.item());
            case WorldChange.Edited edited -> changed(edited.item());
            case WorldChange.Pushed pushed -> changed(pushed.force().item());
            case WorldChange.ColumnEdited column -> {} // no item is named
        }
    }

    private void changed(ItemId item) {
        if (acting != null) {
            changedSince.put(item, acting);
        }
    }

    private void forget(ItemId item) {
        changedBefore.remove(item);
        changedSince.remove(item);
    }

    /**
     * The rules begin a pass over all items, which may last for several frames. Changes are charged
     * in the pass that they precede and, as they may be made in the middle of one, in that one.
     */
    public void beginPass() {
        Map<ItemId, String> reused = changedBefore;
        reused.clear();
        changedBefore = changedSince;
        changedSince = reused;
    }

    /** Charges the steps to the agent that changed the item last, if any. */
    public void charge(ItemId item, long more) {
        String agent = changedSince.get(item);
        if (agent == null) {
            agent = changedBefore.get(item);
        }
        if (agent != null) {
            steps.merge(agent, more, Long::sum);
        }
    }

    /** Returns the steps charged since the last call, by agent in the order of names. */
    public Map<String, Long> take() {
        if (steps.isEmpty()) {
            return Map.of();
        }
        Map<String, Long> taken = new TreeMap<>(steps);
        steps.clear();
        return taken;
    }
}
