/**
 * Actions: what an item lets others do to it. Actions are written in Java ({@link Action}) or
 * declared in a world file ({@link DeclaredAction}); either way their arguments are checked in one
 * place, {@link Arguments}, before anything happens.
 */
@NullMarked
package reve.core.access;

import org.jspecify.annotations.NullMarked;
