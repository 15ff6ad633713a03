// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import java.util.Map;

/**
 * The result of a rewind.
 *
 * @param frame the frame that shows the restored state
 * @param bodies the body of each agent in the world, or a refusal
 */
public record Rewound(long frame, Map<String, Outcome> bodies) {}
