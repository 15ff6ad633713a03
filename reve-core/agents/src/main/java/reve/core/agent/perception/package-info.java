// SPDX-License-Identifier: Apache-2.0
/**
 * What agents perceive of a frame: the reach of sensors, the reuse of unchanged items, and the
 * encoding. The event loop's thread and, for the encoding, the threads that write.
 */
@NullMarked
package reve.core.agent.perception;

import org.jspecify.annotations.NullMarked;
