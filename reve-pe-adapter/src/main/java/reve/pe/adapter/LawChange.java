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

    /** A library was loaded, as the last one in the order. */
    record Loaded(LawLibrary library) implements LawChange {}

    /**
     * The library at a place was replaced by another library. The new library has the same place.
     * It also has the state of the old laws, where the layout of this state is the same.
     */
    record Replaced(int place, LawLibrary library) implements LawChange {}

    /** The library at a place was unloaded. */
    record Unloaded(int place) implements LawChange {}

    /**
     * Parameters of the library at a place were changed; the laws keep their SCRATCH memory.
     *
     * @param changed values, keyed by {@code parameter} or {@code law.parameter}
     */
    record ParametersSet(int place, Map<String, Double> changed) implements LawChange {}

    /** The budget of the library at a place was changed or removed; its interval is 1 again. */
    record BudgetSet(int place, Optional<TimeBudget> budget) implements LawChange {}

    /** The laws of the library at a place are evaluated in every n-th step only. */
    record IntervalSet(int place, int interval) implements LawChange {}

    /**
     * The library at a place failed in PHYSICS, the frame's phase in which laws act. It was
     * unloaded and quarantined.
     */
    record Failed(int place, Quarantined reason) implements LawChange {}

    /**
     * The library at a place failed in PHYSICS soon after it had replaced another library. It is
     * quarantined, and the replaced library has its place again.
     *
     * @param library the library that was replaced and is loaded again
     */
    record RolledBack(int place, Quarantined reason, LawLibrary library) implements LawChange {}

    /** A law failed in PHYSICS at an item, which was arrested: laws cannot access it any more. */
    record Arrested(ItemId item) implements LawChange {}

    /** The quarantine of a library's bytes was ended, so it may be loaded again. */
    record Released(String sha256) implements LawChange {}

    /** PHYSICS failed and no law was the cause: the laws did not act in this frame. */
    record Unmoved() implements LawChange {}
}
