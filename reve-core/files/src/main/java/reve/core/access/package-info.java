// SPDX-License-Identifier: Apache-2.0
/**
 * The actions that agents can perform on an item. An action is a list of effects, which a world
 * file declares or Java code decides, and the terms (conditions and capabilities) for performing
 * it. {@link reve.core.world.Action} is the contract of all actions. {@link
 * reve.core.world.Arguments} checks the arguments before any effect.
 */
@NullMarked
package reve.core.access;

import org.jspecify.annotations.NullMarked;
