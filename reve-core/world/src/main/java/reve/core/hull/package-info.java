// SPDX-License-Identifier: Apache-2.0
/** Convex hulls of points. Knows nothing of worlds. */
@NullMarked
package reve.core.hull;

import org.jspecify.annotations.NullMarked;
