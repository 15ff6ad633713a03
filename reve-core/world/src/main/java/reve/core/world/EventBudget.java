// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.HashMap;
import java.util.Map;

/**
 * Limit on the size of events that actions of agents raise in one second of world time. A second
 * begins every {@code framesPerSecond} frames. Unused bytes are not carried over to the next
 * second. For the world's thread only.
 */
public final class EventBudget {
    private final int agentBytes;
    private final int worldBytes;
    private final int framesPerSecond;

    /** Bytes of events raised in the current second, by agent. */
    private final Map<String, Long> spent = new HashMap<>();

    private long spentByAll;
    private long second = -1;

    /**
     * @param agentBytes maximum size of events of one agent's actions per second [bytes]
     * @param worldBytes maximum size of events of all agents' actions per second [bytes]
     * @param framesPerSecond frames per second of world time
     */
    public EventBudget(int agentBytes, int worldBytes, int framesPerSecond) {
        this.agentBytes = agentBytes;
        this.worldBytes = worldBytes;
        this.framesPerSecond = framesPerSecond;
    }

    /** Returns a budget without limits. */
    public static EventBudget unlimited() {
        return new EventBudget(Integer.MAX_VALUE, Integer.MAX_VALUE, 1);
    }

    /**
     * Refuses events that exceed the budget.
     *
     * @param agent name of the agent whose action raises events; null if no agent acts
     * @param bytes total size of the events of one call, see {@link WorldEvent#bytes}
     * @throws ActionRefused {@code too-many-events}, with the found size and the limit
     */
    public void require(@Nullable String agent, long frame, long bytes) throws ActionRefused {
        if (agent == null || bytes == 0) {
            return;
        }
        begin(frame);
        require(bytes, spent.getOrDefault(agent, 0L), agentBytes, "your actions", frame);
        require(bytes, spentByAll, worldBytes, "actions of all agents", frame);
    }

    /**
     * Subtracts the size of events from the budget. {@link #require} must have accepted these
     * events before.
     */
    public void take(@Nullable String agent, long frame, long bytes) {
        if (agent == null || bytes == 0) {
            return;
        }
        begin(frame);
        spent.merge(agent, bytes, Long::sum);
        spentByAll += bytes;
    }

    private void begin(long frame) {
        long now = Math.floorDiv(frame, framesPerSecond);
        if (now != second) {
            second = now;
            spent.clear();
            spentByAll = 0;
        }
    }

    private void require(long bytes, long already, int limit, String spenders, long frame)
            throws ActionRefused {
        if (already + bytes <= limit) {
            return;
        }
        String found =
                "the action raises events of "
                        + bytes
                        + " bytes, and "
                        + spenders
                        + " have raised "
                        + already
                        + " of at most "
                        + limit
                        + " bytes in this second of world time";
        throw new ActionRefused(
                "too-many-events",
                found
                        + (bytes > limit
                                ? "; give it shorter texts"
                                : "; give it shorter texts, or try again in "
                                        + (framesPerSecond - Math.floorMod(frame, framesPerSecond))
                                        + " frames"));
    }
}
