// SPDX-License-Identifier: Apache-2.0
/**
 * The actions that agents can perform on an item. An action is a list of effects and the terms
 * (conditions and capabilities) that it requires. A world file declares the effects, or Java code
 * decides them. {@link reve.core.world.Action} is the contract of all actions. {@link
 * reve.core.world.Arguments} checks the arguments before any effect.
 */
@NullMarked
package reve.core.access;

import org.jspecify.annotations.NullMarked;
