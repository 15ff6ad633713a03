// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.HashMap;
import java.util.Map;

/**
 * Limit on the bytes by which actions of agents enlarge the symbols of a world, see {@link
 * SymbolBytes}. Each agent has room for {@value #OF_AGENT} bytes. What its actions shorten or
 * remove gives room back, and so does each second of world time. For the world's thread only.
 */
public final class SymbolBudget {
    /** Room of one agent's actions [bytes]. */
    public static final long OF_AGENT = 1 << 20;

    /** Room that an agent gets back in each second of world time [bytes]. */
    public static final long PER_SECOND = 256;

    /** Size of all symbols up to which actions may enlarge them [bytes]. The rest is for edits. */
    public static final long OF_ALL = SymbolBytes.MOST - (1 << 20);

    /** Number of agents above which those are forgotten that have all of their room again. */
    private static final int MANY = 1024;

    private final int framesPerSecond;
    private final Map<String, Taken> byAgent = new HashMap<>();

    /**
     * @param bytes room that is taken
     * @param frame frame from which the next second counts
     */
    private record Taken(long bytes, long frame) {}

    /**
     * @param framesPerSecond frames per second of world time
     */
    public SymbolBudget(int framesPerSecond) {
        this.framesPerSecond = framesPerSecond;
    }

    /**
     * Refuses an action that enlarges symbols beyond the room of its agent or of all agents.
     *
     * @param agent name of the agent that acts; null if no agent acts
     * @param growth bytes by which the action enlarges the symbols of the world at most
     * @throws ActionRefused {@code symbols-too-large}, with the found size and the limit
     */
    public void require(World world, @Nullable String agent, long frame, long growth)
            throws ActionRefused {
        if (agent == null || growth <= 0) {
            return;
        }
        SymbolBytes.require(world, growth, OF_ALL, "symbols-too-large");
        long taken = taken(agent, frame).bytes;
        if (taken + growth > OF_AGENT) {
            throw new ActionRefused(
                    "symbols-too-large",
                    "the action enlarges symbols by "
                            + growth
                            + " bytes in messages, and your actions have taken "
                            + taken
                            + " of their "
                            + OF_AGENT
                            + " bytes; shorten symbols or remove items first. "
                            + PER_SECOND
                            + " bytes become free in each second of world time");
        }
    }

    /**
     * Counts a change of the size of the world's symbols, also a negative one. {@link #require}
     * must have accepted it before.
     */
    public void take(@Nullable String agent, long frame, long growth) {
        if (agent == null || growth == 0) {
            return;
        }
        if (byAgent.size() > MANY) {
            byAgent.keySet().removeIf(each -> taken(each, frame).bytes == 0);
        }
        Taken taken = taken(agent, frame);
        byAgent.put(agent, new Taken(Math.max(0, taken.bytes + growth), taken.frame));
    }

    private Taken taken(String agent, long frame) {
        Taken taken = byAgent.get(agent);
        if (taken == null) {
            return new Taken(0, frame);
        }
        long seconds = Math.max(0, frame - taken.frame) / framesPerSecond;
        return new Taken(
                Math.max(0, taken.bytes - PER_SECOND * seconds),
                taken.frame + seconds * framesPerSecond);
    }
}
