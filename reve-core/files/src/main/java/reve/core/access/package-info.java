// SPDX-License-Identifier: Apache-2.0
/**
 * The actions that an item offers: lists of effects, declared in world files or decided by Java
 * code, and the terms for performing them. {@link reve.core.world.Action} is the contract of all
 * actions. {@link reve.core.world.Arguments} checks the arguments before any effect.
 */
@NullMarked
package reve.core.access;

import org.jspecify.annotations.NullMarked;
