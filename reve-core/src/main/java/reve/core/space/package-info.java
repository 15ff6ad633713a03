// SPDX-License-Identifier: Apache-2.0
/** Boxes in space, and which of them are where. Knows nothing of worlds. */
@NullMarked
package reve.core.space;

import org.jspecify.annotations.NullMarked;
