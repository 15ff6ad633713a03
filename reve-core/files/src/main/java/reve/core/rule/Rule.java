// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.StandardSymbols;

import java.util.Optional;

/**
 * A semantic symbol that an expression gives to items. Immutable.
 *
 * @param kind of the items that get it
 * @param itemClass which of them: those of that class; empty for all
 */
public record Rule(
        String symbol, String kind, Optional<String> itemClass, Expression expression, String doc) {

    /**
     * @throws IllegalArgumentException if the world derives that symbol in another way
     */
    public Rule {
        if (StandardSymbols.DERIVED.contains(symbol) || symbol.equals("class")) {
            throw new IllegalArgumentException(
                    "symbol " + symbol + " is a standard one; a rule cannot give it");
        }
    }

    /** Whether items without physics can never get it: it reads what only physics has. */
    boolean needsPhysics() {
        return expression.uses().stream().anyMatch(name -> name.startsWith("physics."));
    }

    /** The name of the symbol that is read, if it is one. */
    static @Nullable String symbolRead(String name) {
        return name.startsWith("semantic.") ? name.substring("semantic.".length()) : null;
    }
}
