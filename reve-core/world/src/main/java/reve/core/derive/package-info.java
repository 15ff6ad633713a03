// SPDX-License-Identifier: Apache-2.0
/** Columns that the world computes from other columns in the phase DERIVE of each frame. */
@NullMarked
package reve.core.derive;

import org.jspecify.annotations.NullMarked;
