// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * A condition at which a {@link Level} of an item becomes active. The world evaluates it if it is a
 * {@link LevelTest}. Immutable. Worlds on several threads may share it.
 */
public interface LevelCondition {

    /** Returns the text of the condition, as a world file contains it. */
    String text();
}
