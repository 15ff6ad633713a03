// SPDX-License-Identifier: Apache-2.0
/**
 * Journals, from which a simulation can be restored. A journal contains images of the complete
 * state, the inputs between them, and digests that verify a replay. Recordings and the durable
 * store share one format.
 */
@NullMarked
package reve.worlds.journal;

import org.jspecify.annotations.NullMarked;
