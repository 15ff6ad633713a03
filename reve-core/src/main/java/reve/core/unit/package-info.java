// SPDX-License-Identifier: Apache-2.0
/** Physical units: what a number in a world file, a property or an action's argument means. */
@NullMarked
package reve.core.unit;

import org.jspecify.annotations.NullMarked;
