// SPDX-License-Identifier: Apache-2.0
/** Convex hulls of points. This package does not depend on worlds. */
@NullMarked
package reve.core.hull;

import org.jspecify.annotations.NullMarked;
