// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;

/**
 * The computation of a semantic symbol in Java. Rules of world files refer to it by name: {@code
 * rules: {heavy: {java: NAME}}}. A plugin lists its providers in {@code
 * META-INF/services/reve.core.world.SymbolProvider}. All worlds of a process share one instance,
 * and each world calls it on its own thread, possibly at the same time. An instance must therefore
 * not store data of a world.
 */
public interface SymbolProvider {
    /** Number of evaluation steps that one call of {@link #value} counts in the limit of rules. */
    int STEPS = 10;

    /** Returns the name by which rules refer to the provider, for example {@code example.heavy}. */
    String name();

    /** Returns one sentence that describes the symbol. */
    String doc();

    /**
     * Computes the symbol of one item. The world calls this method at the end of each frame, in the
     * phase DERIVE, on the world's thread, for each item of the rule's kind and class. In a world
     * with many items, the calls of a frame may continue in the next frames ({@link #STEPS}).
     *
     * <p>The method may read the whole world through the item, but must not change it. It must
     * return the same value for the same state of the world, so it must not use a clock, random
     * numbers or data of earlier calls. It must not sleep or block, because the frame waits for it
     * without a time limit.
     *
     * <p>If the method throws an exception, the item does not have the symbol in this frame. The
     * first exception in a world raises an event {@code fault}.
     *
     * @return a text, a truth value, a finite number, or a list of these; empty if the item has no
     *     such symbol. A number is in the SI unit of the unit that the world file declares for the
     *     symbol
     */
    Optional<Object> value(Item item);
}
