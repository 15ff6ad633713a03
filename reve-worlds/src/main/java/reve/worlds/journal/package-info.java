// SPDX-License-Identifier: Apache-2.0
/**
 * What it takes to have a simulation again, written while it runs: images of everything, the inputs
 * between them, and digests that tell whether a replay is the same. One format for recordings and
 * for the durable store.
 */
@NullMarked
package reve.worlds.journal;

import org.jspecify.annotations.NullMarked;
