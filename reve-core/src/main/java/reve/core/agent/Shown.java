// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.world.Sensor;
import reve.core.world.Sensor.Aspect;

import java.util.EnumSet;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.TreeSet;

/**
 * What an agent perceives of one item.
 *
 * @param symbols names of the symbols; empty for all
 */
record Shown(Set<Aspect> aspects, Optional<SortedSet<String>> symbols) {

    static final Shown EVERYTHING = new Shown(EnumSet.allOf(Aspect.class), Optional.empty());

    static Shown by(Sensor sensor) {
        return new Shown(sensor.aspects(), sensor.symbols());
    }

    boolean has(Aspect aspect) {
        return aspects.contains(aspect);
    }

    /** True if another one shows no symbols and no actions that this one does not. */
    boolean isAllThatIsSymbolicOf(Shown other) {
        return has(Aspect.SEMANTIC) == other.has(Aspect.SEMANTIC)
                && has(Aspect.ACCESS) == other.has(Aspect.ACCESS)
                && symbols.equals(other.symbols);
    }

    /** What both together show. */
    Shown and(Shown other) {
        if (equals(other)) {
            return this;
        }
        var both = EnumSet.noneOf(Aspect.class);
        both.addAll(aspects);
        both.addAll(other.aspects);
        if (!has(Aspect.SEMANTIC)) {
            return new Shown(both, other.symbols);
        }
        if (!other.has(Aspect.SEMANTIC)) {
            return new Shown(both, symbols);
        }
        if (symbols.isEmpty() || other.symbols.isEmpty()) {
            return new Shown(both, Optional.empty());
        }
        var names = new TreeSet<>(symbols.get());
        names.addAll(other.symbols.get());
        return new Shown(both, Optional.of(names));
    }
}
