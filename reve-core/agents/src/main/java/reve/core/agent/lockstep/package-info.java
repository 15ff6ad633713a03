// SPDX-License-Identifier: Apache-2.0
/** The wait of a world for agents in lock-step, and the limits on the delays that they cause. */
@NullMarked
package reve.core.agent.lockstep;

import org.jspecify.annotations.NullMarked;
