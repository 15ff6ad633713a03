// SPDX-License-Identifier: Apache-2.0
/**
 * What a physics engine is, for any Java program: properties it is lent, laws it loads, steps it
 * takes. Knows nothing of REVE and nothing of one engine; those live in packages beside and below.
 */
@NullMarked
package reve.pe;

import org.jspecify.annotations.NullMarked;
