// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import java.util.Map;

/**
 * The world has gone back.
 *
 * @param frame that shows it
 * @param bodies what became of the bodies of those who are in the world, by agent
 */
public record Rewound(long frame, Map<String, Outcome> bodies) {}
