// SPDX-License-Identifier: Apache-2.0
/**
 * The REVE/PE adapter: a frame listener that binds a world's columns to a physics engine. It uses
 * the public API of items; the world does not depend on it.
 */
@NullMarked
package reve.pe.adapter;

import org.jspecify.annotations.NullMarked;
