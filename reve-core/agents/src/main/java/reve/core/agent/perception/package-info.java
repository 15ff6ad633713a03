// SPDX-License-Identifier: Apache-2.0
/**
 * The perceptions of agents: the reach of sensors, the reuse of unchanged items, and the encoding.
 * For the event loop's thread. The encoding also runs on the threads that write.
 */
@NullMarked
package reve.core.agent.perception;

import org.jspecify.annotations.NullMarked;
