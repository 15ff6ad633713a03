// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.Comparator;
import java.util.HashMap;
import java.util.Map;
import java.util.PriorityQueue;

/**
 * Limit on the number of forces that act at the same time because of agents' actions. The limit
 * exists because each force costs time in each frame. For the world's thread only.
 */
public final class ForceBudget {
    /** Maximum number of simultaneous forces of one agent's actions. */
    public static final int OF_AGENT = 1000;

    /** Maximum number of simultaneous forces of all agents' actions. */
    public static final int OF_ALL = 10_000;

    private final int ofAgent;
    private final int ofAll;
    private final PriorityQueue<Acting> acting =
            new PriorityQueue<>(Comparator.comparingLong(Acting::lastFrame));
    private final Map<String, Integer> byAgent = new HashMap<>();
    private long frame;

    private record Acting(String agent, long lastFrame) {}

    /** Creates a budget with the usual limits. */
    public ForceBudget() {
        this(OF_AGENT, OF_ALL);
    }

    private ForceBudget(int ofAgent, int ofAll) {
        this.ofAgent = ofAgent;
        this.ofAll = ofAll;
    }

    /** Returns a budget without limits. */
    public static ForceBudget unlimited() {
        return new ForceBudget(Integer.MAX_VALUE, Integer.MAX_VALUE);
    }

    /**
     * Refuses forces that exceed the budget.
     *
     * @param agent name of the agent whose action exerts the forces; null if no agent acts
     * @param count number of forces of one call
     * @throws ActionRefused {@code too-many-forces}, with the found number and the limit
     */
    public void require(@Nullable String agent, long now, int count) throws ActionRefused {
        if (agent == null || count == 0) {
            return;
        }
        begin(now);
        require(count, byAgent.getOrDefault(agent, 0), ofAgent, "your actions");
        require(count, acting.size(), ofAll, "actions of all agents");
    }

    /**
     * Counts a force that {@link #require} has accepted, until it ends after this number of frames.
     */
    public void take(@Nullable String agent, long now, long frames) {
        if (agent == null) {
            return;
        }
        begin(now);
        acting.add(new Acting(agent, now + frames));
        byAgent.merge(agent, 1, Integer::sum);
    }

    private void begin(long now) {
        if (now < frame) {
            // The world was rewound to an earlier frame.
            acting.clear();
            byAgent.clear();
        }
        frame = now;
        while (!acting.isEmpty() && acting.peek().lastFrame() <= now) {
            byAgent.computeIfPresent(
                    acting.remove().agent(), (name, count) -> count == 1 ? null : count - 1);
        }
    }

    private static void require(int count, int already, int limit, String whose)
            throws ActionRefused {
        if (already + count > limit) {
            throw new ActionRefused(
                    "too-many-forces",
                    "the action exerts "
                            + count
                            + (count == 1 ? " force, and " : " forces, and ")
                            + already
                            + " of at most "
                            + limit
                            + " forces of "
                            + whose
                            + " still act; wait until some of them end");
        }
    }
}
