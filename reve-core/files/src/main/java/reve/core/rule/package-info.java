// SPDX-License-Identifier: Apache-2.0
/**
 * Expressions in world files, and the rules that compute symbols with them. The language is CEL,
 * the Common Expression Language (cel.dev): typed, without side effects, unbounded loops, clock or
 * random numbers, so that the same world has the same result on every machine.
 */
@NullMarked
package reve.core.rule;

import org.jspecify.annotations.NullMarked;
