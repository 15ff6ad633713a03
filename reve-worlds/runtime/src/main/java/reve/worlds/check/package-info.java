// SPDX-License-Identifier: Apache-2.0
/** Warnings about worlds that are valid and would do nothing, fall for ever, or diverge. */
@NullMarked
package reve.worlds.check;

import org.jspecify.annotations.NullMarked;
