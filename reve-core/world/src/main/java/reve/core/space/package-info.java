// SPDX-License-Identifier: Apache-2.0
/** Spatial search over boxes. This package does not depend on worlds. */
@NullMarked
package reve.core.space;

import org.jspecify.annotations.NullMarked;
