// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import java.util.Map;

/**
 * The result of a rewind.
 *
 * @param frame the frame that shows the restored state
 * @param bodies for each agent in the world, its body or a refusal
 */
public record Rewound(long frame, Map<String, Outcome> bodies) {}
