// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.world.WorldChange;
import reve.core.world.WorldEvent;
import reve.pe.adapter.LawChange;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** The data of one frame that the world's thread passes to the writer. Entries are reused. */
final class Entry {
    /** A change, with the rows of an edited column after the change. */
    record Noted(WorldChange change, byte @Nullable [] columnRows) {}

    long frame;

    /** Changes made before PHYSICS, and changes made after it. */
    final List<Noted> early = new ArrayList<>();

    final List<Noted> late = new ArrayList<>();
    final List<LawChange> laws = new ArrayList<>();
    List<WorldEvent> events = List.of();
    final long[] digest;

    /** Digest of the world before PHYSICS, valid if there are changes before it. */
    final long[] earlyDigest;

    /** Image of the end of this frame, if one is due. */
    @Nullable SimulationImage image;

    /**
     * Whether the image replaces the frame, because its changes do not describe the world
     * completely.
     */
    boolean begins;

    /** Whether the image ends the journal and belongs to no frame. */
    boolean last;

    Map<String, Long> members = Map.of();

    Entry(int digestSize) {
        digest = new long[digestSize];
        earlyDigest = new long[digestSize];
    }

    /** Drops all references to the frame's data. */
    void clear() {
        early.clear();
        late.clear();
        laws.clear();
        events = List.of();
        image = null;
        begins = false;
    }
}
