// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.Item;
import reve.core.world.ProviderFaults;
import reve.core.world.SymbolProvider;
import reve.core.world.WorldGuard;

import java.util.Optional;

/** The computation of a rule's symbol in one world. For the world's thread only. */
sealed interface Computation {
    /**
     * Returns the value for an item, in SI units.
     *
     * @return null if the item has no such symbol
     * @throws EvaluationException if there is no value because of an error
     */
    @Nullable Object compute(Item item) throws EvaluationException;

    /** Returns the number of evaluation steps so far. */
    long steps();

    /** A computation by an expression. */
    record Formula(Expression expression, Bindings bindings) implements Computation {
        @Override
        public Object compute(Item item) throws EvaluationException {
            return expression.evaluate(bindings.of(item));
        }

        @Override
        public long steps() {
            return bindings.steps();
        }
    }

    /** A computation by a provider in Java. */
    final class Provided implements Computation {
        private final WorldGuard guard;
        private final SymbolProvider provider;
        private final String name;

        /** Calls the provider for {@link #item}. One object serves all calls, to save memory. */
        private final WorldGuard.Inspection<Optional<Object>, RuntimeException> call;

        private @Nullable Item item;
        private long steps;

        Provided(WorldGuard guard, SymbolProvider provider) {
            this.guard = guard;
            this.provider = provider;
            this.name = "symbol " + provider.name();
            this.call = this::call;
        }

        private Optional<Object> call() {
            Item asked = item;
            return asked == null ? Optional.empty() : provider.value(asked);
        }

        @Override
        public @Nullable Object compute(Item asked) throws EvaluationException {
            item = asked;
            steps += SymbolProvider.STEPS;
            try {
                return guard.inspect(name, call).orElse(null);
            } catch (RuntimeException | Error failed) {
                ProviderFaults.requireBearable(failed);
                throw new EvaluationException(failed);
            } finally {
                ProviderFaults.clearInterrupt();
                item = null;
            }
        }

        @Override
        public long steps() {
            return steps;
        }
    }
}
