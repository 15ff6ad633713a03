// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import java.util.Map;

/**
 * The result of a rewind.
 *
 * @param frame that shows the restored state
 * @param bodies outcome for each agent in the world, by agent
 */
public record Rewound(long frame, Map<String, Outcome> bodies) {}
