// SPDX-License-Identifier: Apache-2.0
/** How a world waits for agents in lock-step, and how long they may keep others waiting. */
@NullMarked
package reve.core.agent.lockstep;

import org.jspecify.annotations.NullMarked;
