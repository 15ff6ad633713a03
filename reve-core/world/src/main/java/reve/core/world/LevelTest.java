// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** A condition of a level that can be evaluated. Immutable. */
public interface LevelTest extends LevelCondition {

    /**
     * Evaluates the condition. For the world's thread only.
     *
     * @param item the item with the level
     * @param motion motion of the item at its active level
     */
    Result test(Item item, Motion motion);

    /**
     * The result of an evaluation.
     *
     * @param holds false also if the condition has no value, for example because it reads physics
     *     of an item that consists of parts
     * @param steps number of evaluation steps, the same on every machine
     */
    record Result(boolean holds, long steps) {}
}
