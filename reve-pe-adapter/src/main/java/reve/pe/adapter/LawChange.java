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
    /** Returns the library that the change brings, if it brings one. */
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
     * The library at a place was replaced by another one, which has its place and the state of its
     * laws where the layout is the same.
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

    /** The library at a place got another budget, or none; its laws act in every step again. */
    record BudgetSet(int place, Optional<TimeBudget> budget) implements LawChange {}

    /** The laws of the library at a place are evaluated in every n-th step only. */
    record IntervalSet(int place, int interval) implements LawChange {}

    /**
     * The library at a place failed in PHYSICS, the frame's phase in which laws act, was unloaded
     * and is quarantined.
     */
    record Failed(int place, Quarantined reason) implements LawChange {}

    /**
     * The library at a place failed in PHYSICS soon after it had replaced another one. It is
     * quarantined, and the other one has its place again.
     *
     * @param library the one that was there before
     */
    record RolledBack(int place, Quarantined reason, LawLibrary library) implements LawChange {}

    /** A law failed in PHYSICS at an item, which was arrested: laws no longer reach it. */
    record Arrested(ItemId item) implements LawChange {}

    /** The quarantine of a library's bytes was ended, so it may be loaded again. */
    record Released(String sha256) implements LawChange {}

    /** PHYSICS failed and no law was the cause: the laws did not act in this frame. */
    record Unmoved() implements LawChange {}
}
