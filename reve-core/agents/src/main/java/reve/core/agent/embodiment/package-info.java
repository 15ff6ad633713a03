// SPDX-License-Identifier: Apache-2.0
/**
 * Agents in a world: their bodies, and the one place where what they want is checked and done. The
 * world's thread.
 */
@NullMarked
package reve.core.agent.embodiment;

import org.jspecify.annotations.NullMarked;
