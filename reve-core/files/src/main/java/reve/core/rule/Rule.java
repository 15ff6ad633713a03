// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.StandardSymbols;

import java.util.Optional;

/**
 * A rule of a world: it computes a semantic symbol of items by an expression. Immutable.
 *
 * @param kind kind of the items that get the symbol
 * @param itemClass class of these items, their symbol {@code class}; empty for all classes
 */
public record Rule(
        String symbol, String kind, Optional<String> itemClass, Expression expression, String doc) {

    /**
     * @throws IllegalArgumentException if the world itself computes the symbol, for example {@code
     *     name}
     */
    public Rule {
        if (StandardSymbols.DERIVED.contains(symbol) || symbol.equals("class")) {
            throw new IllegalArgumentException(
                    "symbol " + symbol + " is a standard one; a rule cannot give it");
        }
    }

    /** Returns whether the rule reads properties that only items with physics have. */
    boolean needsPhysics() {
        return expression.uses().stream().anyMatch(name -> name.startsWith("physics."));
    }

    /**
     * Returns the symbol that a full name such as {@code semantic.lit} reads; null if it reads no
     * symbol.
     */
    static @Nullable String symbolRead(String name) {
        return name.startsWith("semantic.") ? name.substring("semantic.".length()) : null;
    }
}
