// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.StandardSymbols;

import java.util.Optional;

/**
 * A rule of a world. It computes a semantic symbol of items by an expression, or in Java.
 * Immutable.
 *
 * @param symbol name of the symbol
 * @param kind kind of the items that get the symbol
 * @param itemClass class of these items, or a class above theirs; empty for all classes
 * @param source the computation of the symbol
 */
public record Rule(
        String symbol, String kind, Optional<String> itemClass, SymbolSource source, String doc) {

    /** Creates a rule with an expression. */
    public Rule(
            String symbol,
            String kind,
            Optional<String> itemClass,
            Expression expression,
            String doc) {
        this(symbol, kind, itemClass, new SymbolSource.Formula(expression), doc);
    }

    /**
     * Checks that a rule may set the symbol.
     *
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
        return source.uses().stream().anyMatch(name -> name.startsWith("physics."));
    }

    /**
     * Returns the symbol that a full name reads, for example {@code lit} for {@code semantic.lit}.
     * Returns null if the name reads no symbol.
     */
    static @Nullable String symbolRead(String name) {
        return name.startsWith("semantic.") ? name.substring("semantic.".length()) : null;
    }
}
