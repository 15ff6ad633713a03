// SPDX-License-Identifier: Apache-2.0
/** The virtual world store: items, their aspects, and the columns with their numbers. */
@NullMarked
package reve.core.world;

import org.jspecify.annotations.NullMarked;
