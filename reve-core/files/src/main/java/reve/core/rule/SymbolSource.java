// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import reve.core.world.SymbolProvider;

import java.util.Set;

/** The computation of a rule's symbol. Immutable. */
public sealed interface SymbolSource {
    /**
     * Returns the full names that the computation is known to read, for example {@code
     * semantic.lit}.
     */
    Set<String> uses();

    /** A computation by an expression. */
    record Formula(Expression expression) implements SymbolSource {
        @Override
        public Set<String> uses() {
            return expression.uses();
        }

        /** Returns the text of the expression. */
        @Override
        public String toString() {
            return expression.toString();
        }
    }

    /**
     * A computation by a provider in Java. What it reads is not known, so it is computed in every
     * frame.
     */
    record Provided(SymbolProvider provider) implements SymbolSource {
        @Override
        public Set<String> uses() {
            return Set.of();
        }

        /** Returns the provider as a world file names it. */
        @Override
        public String toString() {
            return "java: " + provider.name();
        }
    }
}
