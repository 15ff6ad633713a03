// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.StandardSymbols;

import java.util.Optional;

/**
 * A rule: a semantic symbol whose value an expression computes. Immutable.
 *
 * @param kind of the items with the symbol
 * @param itemClass class of the items with the symbol; empty for all classes
 */
public record Rule(
        String symbol, String kind, Optional<String> itemClass, Expression expression, String doc) {

    /**
     * @throws IllegalArgumentException if the world derives that symbol itself
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

    /** Returns the symbol that a name reads, or null if it reads none. */
    static @Nullable String symbolRead(String name) {
        return name.startsWith("semantic.") ? name.substring("semantic.".length()) : null;
    }
}
