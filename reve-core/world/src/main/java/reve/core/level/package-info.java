// SPDX-License-Identifier: Apache-2.0
/** Levels: alternative physical descriptions of an item, and the conditions that select one. */
@NullMarked
package reve.core.level;

import org.jspecify.annotations.NullMarked;
