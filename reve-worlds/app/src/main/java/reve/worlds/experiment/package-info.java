// SPDX-License-Identifier: Apache-2.0
/**
 * Experiments. An experiment makes many runs of one world, measures values in them, and compares
 * the results with earlier ones.
 */
@NullMarked
package reve.worlds.experiment;

import org.jspecify.annotations.NullMarked;
