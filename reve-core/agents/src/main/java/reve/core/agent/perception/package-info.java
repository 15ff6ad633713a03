// SPDX-License-Identifier: Apache-2.0
/**
 * Perceptions of frames: the reach of sensors, the reuse of unchanged items, and the encoding. The
 * event loop's thread and, for encoding, the threads that write.
 */
@NullMarked
package reve.core.agent.perception;

import org.jspecify.annotations.NullMarked;
