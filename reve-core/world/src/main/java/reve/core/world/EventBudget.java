// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.HashMap;
import java.util.Map;

/**
 * How many bytes of events actions of agents may raise in one second of world time. Seconds are
 * counted in frames, from the world's frame number, so that nothing before the current second
 * matters. World's thread.
 */
public final class EventBudget {
    private final int agentBytes;
    private final int worldBytes;
    private final int framesPerSecond;

    /** Spent in the current second, by agent. */
    private final Map<String, Long> spent = new HashMap<>();

    private long spentByAll;
    private long second = -1;

    /**
     * @param agentBytes most bytes in one second of events that actions of one agent raise
     * @param worldBytes most bytes in one second of events that actions of all agents raise
     * @param framesPerSecond frames of one second of world time
     */
    public EventBudget(int agentBytes, int worldBytes, int framesPerSecond) {
        this.agentBytes = agentBytes;
        this.worldBytes = worldBytes;
        this.framesPerSecond = framesPerSecond;
    }

    /** A budget without limits. */
    public static EventBudget unlimited() {
        return new EventBudget(Integer.MAX_VALUE, Integer.MAX_VALUE, 1);
    }

    /**
     * Refuses what exceeds the budget.
     *
     * @param agent whose action raises events, null for no agent's
     * @param bytes of the events that one call of an action raises, see {@link WorldEvent#bytes}
     * @throws ActionRefused {@code too-many-events}, with what was found and the limit
     */
    public void require(@Nullable String agent, long frame, long bytes) throws ActionRefused {
        if (agent == null || bytes == 0) {
            return;
        }
        begin(frame);
        require(bytes, spent.getOrDefault(agent, 0L), agentBytes, "your actions", frame);
        require(bytes, spentByAll, worldBytes, "actions of all agents", frame);
    }

    /** Takes what was required before. */
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

    private void require(long bytes, long already, int limit, String whose, long frame)
            throws ActionRefused {
        if (already + bytes <= limit) {
            return;
        }
        String found =
                "the action raises events of "
                        + bytes
                        + " bytes, and "
                        + whose
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
