// SPDX-License-Identifier: Apache-2.0
/** Experiments: many runs of one world, what is measured in them, and comparisons of results. */
@NullMarked
package reve.worlds.experiment;

import org.jspecify.annotations.NullMarked;
