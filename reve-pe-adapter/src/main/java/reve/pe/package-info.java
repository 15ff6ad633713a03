// SPDX-License-Identifier: Apache-2.0
/**
 * The interface of a physics engine for any Java program: bound properties, loaded laws, steps.
 * This package depends neither on REVE nor on a particular engine. Its subpackages do.
 */
@NullMarked
package reve.pe;

import org.jspecify.annotations.NullMarked;
