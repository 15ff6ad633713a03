// SPDX-License-Identifier: Apache-2.0
/**
 * Expressions in world files, and the symbols that worlds derive by them. The language is CEL, the
 * Common Expression Language (cel.dev): typed, without side effects, loops without end, clock or
 * chance, so that the same world gives the same result on every machine.
 */
@NullMarked
package reve.core.rule;

import org.jspecify.annotations.NullMarked;
