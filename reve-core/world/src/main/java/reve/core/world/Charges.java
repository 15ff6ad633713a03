// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.HashMap;
import java.util.Map;
import java.util.TreeMap;

/**
 * Account of the evaluation steps that agents cause, because rules must be evaluated after their
 * acts. It stores which agent last changed each item, and charges this agent for the evaluation of
 * the item's rules. For the world's thread only.
 */
public final class Charges {
    /** For each item, the agent that last changed it before the current pass of the rules began. */
    private Map<ItemId, String> changedBefore = new HashMap<>();

    private Map<ItemId, String> changedSince = new HashMap<>();
    private final Map<String, Long> steps = new TreeMap<>();
    private @Nullable String acting;

    Charges() {}

    /** Begins an agent's act: until {@link #end}, changes of items are attributed to the agent. */
    public void begin(String agent) {
        acting = agent;
    }

    /** Ends the act. */
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
            case WorldChange.ColumnEdited column -> {} // this change names no item
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
     * Begins a pass of the rules over all items, which may take several frames. This pass charges
     * the changes since the last call of this method. Changes during this pass are charged in this
     * pass and in the next one.
     */
    public void beginPass() {
        Map<ItemId, String> reused = changedBefore;
        reused.clear();
        changedBefore = changedSince;
        changedSince = reused;
    }

    /**
     * Charges evaluation steps to the agent that last changed the item. Does nothing if no agent
     * changed the item.
     */
    public void charge(ItemId item, long more) {
        String agent = changedSince.get(item);
        if (agent == null) {
            agent = changedBefore.get(item);
        }
        if (agent != null) {
            steps.merge(agent, more, Long::sum);
        }
    }

    /**
     * Returns the steps of each agent since the last call of this method, in the order of the
     * agents' names.
     */
    public Map<String, Long> take() {
        if (steps.isEmpty()) {
            return Map.of();
        }
        Map<String, Long> taken = new TreeMap<>(steps);
        steps.clear();
        return taken;
    }
}
