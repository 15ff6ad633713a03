// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.world.WorldChange;
import reve.core.world.WorldEvent;
import reve.pe.adapter.LawChange;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** What the world's thread hands over of one frame; used again and again. */
final class Entry {
    /** A change, with what a directly edited column held after it. */
    record Noted(WorldChange change, byte @Nullable [] columnRows) {}

    long frame;

    /** Changes made before PHYSICS, then those made after it. */
    final List<Noted> early = new ArrayList<>();

    final List<Noted> late = new ArrayList<>();
    final List<LawChange> laws = new ArrayList<>();
    List<WorldEvent> events = List.of();
    final long[] digest;

    /** Of the world before PHYSICS, if there are changes before it. */
    final long[] earlyDigest;

    /** Of the end of this frame, if one is due. */
    @Nullable SimulationImage image;

    /** Whether the image stands for the frame: its changes do not tell what became of the world. */
    boolean begins;

    /** Whether it is the image that ends the journal, without a frame. */
    boolean last;

    Map<String, Long> members = Map.of();

    Entry(int digestSize) {
        digest = new long[digestSize];
        earlyDigest = new long[digestSize];
    }

    /** Forgets the frame, so that nothing is kept alive. */
    void clear() {
        early.clear();
        late.clear();
        laws.clear();
        events = List.of();
        image = null;
        begins = false;
    }
}
