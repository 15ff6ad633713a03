// SPDX-License-Identifier: Apache-2.0
/**
 * Frames (ticks of a world): their phases, listeners and commands, and the schedule by which they
 * run.
 */
@NullMarked
package reve.core.frame;

import org.jspecify.annotations.NullMarked;
