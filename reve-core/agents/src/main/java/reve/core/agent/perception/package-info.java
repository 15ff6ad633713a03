// SPDX-License-Identifier: Apache-2.0
/**
 * What agents perceive of a frame: what sensors reach, which items are the same as before, and how
 * they are encoded. The event loop's thread and, for encoding, the writers.
 */
@NullMarked
package reve.core.agent.perception;

import org.jspecify.annotations.NullMarked;
