// SPDX-License-Identifier: Apache-2.0
/**
 * The REVE/PE adapter: a frame listener that lends a world's columns to a physics engine. It
 * reaches items as everybody does; the world does not know that it exists.
 */
@NullMarked
package reve.pe.adapter;

import org.jspecify.annotations.NullMarked;
