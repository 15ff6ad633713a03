// SPDX-License-Identifier: Apache-2.0
/**
 * Expressions in world files, and the rules that compute symbols with them. The language is CEL,
 * the Common Expression Language (cel.dev). It is typed, and has no side effects, unbounded loops,
 * clock or random numbers. The same world therefore has the same result on every machine.
 */
@NullMarked
package reve.core.rule;

import org.jspecify.annotations.NullMarked;
