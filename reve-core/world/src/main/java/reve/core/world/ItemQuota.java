// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

/**
 * Limit on the number of existing items that actions have created.
 *
 * @param agent name of the agent whose action creates items; null if no agent acts
 * @param items maximum number of existing items that this agent created
 * @param worldItems maximum number of existing items that all agents created
 */
public record ItemQuota(@Nullable String agent, int items, int worldItems) {

    /** A quota without limits. */
    public static final ItemQuota NONE = new ItemQuota(null, Integer.MAX_VALUE, Integer.MAX_VALUE);

    /**
     * Refuses an action that exceeds the quota.
     *
     * @param created number of items that the action creates
     * @param removed items that the action removes, each listed once
     * @throws ActionRefused {@code too-many-items}, with the found number and the limit
     */
    public void require(World world, int created, Iterable<Item> removed) throws ActionRefused {
        if (agent == null || created == 0) {
            return;
        }
        long own = world.made(agent);
        long all = world.made();
        long more = created;
        long moreOfAll = created;
        for (Item item : removed) {
            moreOfAll -= item.maker().isPresent() ? 1 : 0;
            more -= item.maker().filter(agent::equals).isPresent() ? 1 : 0;
        }
        if (more > 0 && own + more > items) {
            throw refused(
                    created,
                    own
                            + " of at most "
                            + items
                            + " items that your actions"
                            + " created are in the world; remove some of them first");
        }
        if (moreOfAll > 0 && all + moreOfAll > worldItems) {
            throw refused(
                    created,
                    all
                            + " of at most "
                            + worldItems
                            + " items that actions of agents created are in the world; some of them"
                            + " have to be removed first");
        }
    }

    private static ActionRefused refused(int created, String why) {
        return new ActionRefused(
                "too-many-items",
                "the action creates "
                        + created
                        + (created == 1 ? " item, and " : " items, and ")
                        + why);
    }
}
