// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.ItemId;

import java.util.Map;

/**
 * A change to the laws of a world. Libraries are identified by their index in the order of loading.
 */
public sealed interface LawChange {
    /** A library was loaded after all others. */
    record Loaded(LawLibrary library) implements LawChange {}

    /** The library at an index, from 0, was unloaded. */
    record Unloaded(int place) implements LawChange {}

    /**
     * Parameters of the library at an index were changed; laws keep what they remember.
     *
     * @param changed by {@code parameter} or {@code law.parameter}
     */
    record ParametersSet(int place, Map<String, Double> changed) implements LawChange {}

    /** The library at an index failed in PHYSICS, was unloaded and is quarantined. */
    record Failed(int place, Quarantined reason) implements LawChange {}

    /** A law failed in PHYSICS at an item, which was made unreachable for laws. */
    record Arrested(ItemId item) implements LawChange {}

    /** A library's bytes were released from quarantine. */
    record Released(String sha256) implements LawChange {}

    /** PHYSICS failed and no law was the cause: the laws did not act in this frame. */
    record Unmoved() implements LawChange {}
}
