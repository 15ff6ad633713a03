// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import java.util.List;

/**
 * Perceived items as the agent of a body perceives them: items that are too heavy for the body have
 * the symbol {@code tooHeavy}.
 *
 * @param from the items as all agents perceive them
 * @param items the items as this agent perceives them; the same list if none is too heavy
 * @param strength the largest weight that the body lifts [N]
 * @param version the {@link Weights#version} of the weights
 */
record Weighed(List<PerceivedItem> from, List<PerceivedItem> items, double strength, long version) {
    static final Weighed NOTHING = new Weighed(List.of(), List.of(), Double.POSITIVE_INFINITY, -1);
}
