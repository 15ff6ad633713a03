// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.TimeBudget;
import reve.core.world.ItemId;

import java.util.Map;
import java.util.Optional;

/**
 * A change to the laws of a world. A {@code place} is the position of a library in the list of
 * loaded libraries, in the order of loading, from 0.
 */
public sealed interface LawChange {
    /** Returns the library that the change loads, if it loads one. */
    default Optional<LawLibrary> brought() {
        return switch (this) {
            case Loaded added -> Optional.of(added.library());
            case Replaced replaced -> Optional.of(replaced.library());
            case RolledBack back -> Optional.of(back.library());
            case Unloaded _, ParametersSet _, BudgetSet _, IntervalSet _ -> Optional.empty();
            case Failed _, Arrested _, Released _, Unmoved _ -> Optional.empty();
        };
    }

    /** Records that a library was loaded, as the last one in the order. */
    record Loaded(LawLibrary library) implements LawChange {}

    /**
     * Records that the library at a place was replaced by another library. The new library has the
     * same place. It also has the state of the old laws, where the layout of this state is the
     * same.
     */
    record Replaced(int place, LawLibrary library) implements LawChange {}

    /** Records that the library at a place was unloaded. */
    record Unloaded(int place) implements LawChange {}

    /**
     * Records that parameters of the library at a place were changed. The laws keep their SCRATCH
     * memory.
     *
     * @param changed values, keyed by {@code parameter} or {@code law.parameter}
     */
    record ParametersSet(int place, Map<String, Double> changed) implements LawChange {}

    /**
     * Records that the budget of the library at a place was changed or removed. The interval of the
     * library is then 1.
     */
    record BudgetSet(int place, Optional<TimeBudget> budget) implements LawChange {}

    /** Records that the laws of the library at a place are evaluated in every n-th step only. */
    record IntervalSet(int place, int interval) implements LawChange {}

    /**
     * Records that the library at a place failed in PHYSICS, the frame's phase in which laws act.
     * It was unloaded and quarantined.
     */
    record Failed(int place, Quarantined reason) implements LawChange {}

    /**
     * Records that the library at a place failed in PHYSICS soon after it had replaced another
     * library. The failed library is quarantined, and the replaced library has its place again.
     *
     * @param library the library that was replaced and is loaded again
     */
    record RolledBack(int place, Quarantined reason, LawLibrary library) implements LawChange {}

    /**
     * Records that a law failed in PHYSICS at an item. The item was arrested, so that laws do not
     * act on it.
     */
    record Arrested(ItemId item) implements LawChange {}

    /**
     * Records that the quarantine of a library's bytes was ended, so that the library may be loaded
     * again.
     */
    record Released(String sha256) implements LawChange {}

    /**
     * Records that the laws did not act in this frame, because PHYSICS failed and no law was the
     * cause.
     */
    record Unmoved() implements LawChange {}
}
