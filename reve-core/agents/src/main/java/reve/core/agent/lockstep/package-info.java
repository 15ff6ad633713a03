// SPDX-License-Identifier: Apache-2.0
/**
 * Lock-step: before a frame, the world waits until agents are ready. This package also limits the
 * delays that such agents cause.
 */
@NullMarked
package reve.core.agent.lockstep;

import org.jspecify.annotations.NullMarked;
