// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.ItemId;

/** A change to the laws of a world. Libraries are named by their place in the order of loading. */
public sealed interface LawChange {
    /** A library was loaded, behind all others. */
    record Loaded(LawLibrary library) implements LawChange {}

    /** The library in a place, 0 for the first, was unloaded. */
    record Unloaded(int place) implements LawChange {}

    /** The library in a place failed in PHYSICS, was unloaded and stays out. */
    record Failed(int place, Quarantined reason) implements LawChange {}

    /** A law failed in PHYSICS at an item, which was taken out of the reach of laws. */
    record Arrested(ItemId item) implements LawChange {}
}
