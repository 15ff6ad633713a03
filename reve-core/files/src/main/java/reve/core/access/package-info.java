// SPDX-License-Identifier: Apache-2.0
/**
 * What an item lets others do to it: actions as lists of effects, declared in world files or
 * decided by Java code, with the terms on which they may be performed. The contract that they share
 * is {@link reve.core.world.Action}; arguments are checked in one place, {@link
 * reve.core.world.Arguments}, before anything happens.
 */
@NullMarked
package reve.core.access;

import org.jspecify.annotations.NullMarked;
