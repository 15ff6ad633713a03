// SPDX-License-Identifier: Apache-2.0
/** What is worked out from other properties, in DERIVE. */
@NullMarked
package reve.core.derive;

import org.jspecify.annotations.NullMarked;
