// SPDX-License-Identifier: Apache-2.0
/** Physical units of numbers in world files, properties and arguments of actions. */
@NullMarked
package reve.core.unit;

import org.jspecify.annotations.NullMarked;
