// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.world.Sensor;
import reve.core.world.Sensor.Aspect;

import java.util.EnumSet;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.TreeSet;

/**
 * The kinds of data of an item that a sensor perceives.
 *
 * @param symbols names of the perceived symbols; empty for all
 */
record Visibility(Set<Aspect> aspects, Optional<SortedSet<String>> symbols) {

    static final Visibility EVERYTHING =
            new Visibility(EnumSet.allOf(Aspect.class), Optional.empty());

    static Visibility by(Sensor sensor) {
        return new Visibility(sensor.aspects(), sensor.symbols());
    }

    boolean has(Aspect aspect) {
        return aspects.contains(aspect);
    }

    /** Returns whether this visibility includes a symbol. */
    boolean hasSymbol(String symbol) {
        return has(Aspect.SEMANTIC) && (symbols.isEmpty() || symbols.get().contains(symbol));
    }

    /** Returns whether this visibility includes all symbols and actions of the other visibility. */
    boolean isAllThatIsSymbolicOf(Visibility other) {
        return has(Aspect.SEMANTIC) == other.has(Aspect.SEMANTIC)
                && has(Aspect.ACCESS) == other.has(Aspect.ACCESS)
                && symbols.equals(other.symbols);
    }

    /** Returns a visibility that includes the data of both visibilities. */
    Visibility and(Visibility other) {
        if (equals(other)) {
            return this;
        }
        var both = EnumSet.noneOf(Aspect.class);
        both.addAll(aspects);
        both.addAll(other.aspects);
        if (!has(Aspect.SEMANTIC)) {
            return new Visibility(both, other.symbols);
        }
        if (!other.has(Aspect.SEMANTIC)) {
            return new Visibility(both, symbols);
        }
        if (symbols.isEmpty() || other.symbols.isEmpty()) {
            return new Visibility(both, Optional.empty());
        }
        var names = new TreeSet<>(symbols.get());
        names.addAll(other.symbols.get());
        return new Visibility(both, Optional.of(names));
    }
}
