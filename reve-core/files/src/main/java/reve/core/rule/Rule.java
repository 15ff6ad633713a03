// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.StandardSymbols;

import java.util.Optional;

/**
 * A rule of a world. It computes a semantic symbol of items by an expression. Immutable.
 *
 * @param symbol name of the symbol
 * @param kind kind of the items that get the symbol
 * @param itemClass class of these items, which is their symbol {@code class}; empty for all classes
 */
public record Rule(
        String symbol, String kind, Optional<String> itemClass, Expression expression, String doc) {

    /**
     * @throws IllegalArgumentException if the world itself sets the symbol, for example {@code
     *     name}
     */
    public Rule {
        if (StandardSymbols.DERIVED.contains(symbol) || symbol.equals("class")) {
            throw new IllegalArgumentException(
                    "symbol " + symbol + " is a standard one; a rule cannot give it");
        }
    }

    /** Returns whether the rule reads properties that only items with a physics aspect have. */
    boolean needsPhysics() {
        return expression.uses().stream().anyMatch(name -> name.startsWith("physics."));
    }

    /**
     * Returns the symbol that a full name reads, for example {@code lit} for {@code semantic.lit}.
     * Returns null if the name reads no symbol.
     */
    static @Nullable String symbolRead(String name) {
        return name.startsWith("semantic.") ? name.substring("semantic.".length()) : null;
    }
}
