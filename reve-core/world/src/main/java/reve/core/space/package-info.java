// SPDX-License-Identifier: Apache-2.0
/** Spatial search over boxes. Independent of worlds. */
@NullMarked
package reve.core.space;

import org.jspecify.annotations.NullMarked;
