// SPDX-License-Identifier: Apache-2.0
/**
 * Warnings about worlds that are valid but would not move, fall for ever, or diverge numerically.
 */
@NullMarked
package reve.worlds.check;

import org.jspecify.annotations.NullMarked;
