/**
 * Actions declared in world files: what an item lets others do to it, as a list of effects. The
 * contract that they share with actions written in Java is {@link reve.core.world.Action}; arguments
 * are checked in one place, {@link reve.core.world.Arguments}, before anything happens.
 */
@NullMarked
package reve.core.access;

import org.jspecify.annotations.NullMarked;
