// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import java.util.Map;

/**
 * The result of a rewind.
 *
 * @param frame number of the frame that shows the restored state
 * @param bodies the result for each agent in the world: {@link Outcome.Joined} with its body, or a
 *     refusal
 */
public record Rewound(long frame, Map<String, Outcome> bodies) {}
