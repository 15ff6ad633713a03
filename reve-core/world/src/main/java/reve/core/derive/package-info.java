// SPDX-License-Identifier: Apache-2.0
/** Columns that are derived from other properties, in DERIVE. */
@NullMarked
package reve.core.derive;

import org.jspecify.annotations.NullMarked;
