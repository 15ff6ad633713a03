// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.agent.port.SessionNote;
import reve.core.file.RuleChanges;
import reve.core.world.WorldChange;
import reve.core.world.WorldEvent;
import reve.pe.adapter.LawChange;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/**
 * The data of one frame that the world's thread passes to the journal's writer thread. Entries are
 * reused.
 */
final class Entry {
    /**
     * A change of the world. The field {@code columnRows} contains the rows of a column that was
     * edited directly, after the change. It is null for other changes.
     */
    record Noted(WorldChange change, byte @Nullable [] columnRows) {}

    long frame;

    /**
     * Changes before PHYSICS (the frame's phase in which laws act). The next field contains the
     * changes after it.
     */
    final List<Noted> early = new ArrayList<>();

    final List<Noted> late = new ArrayList<>();
    final List<LawChange> laws = new ArrayList<>();
    final List<RuleChanges.Change> rules = new ArrayList<>();
    List<WorldEvent> events = List.of();
    final long[] digest;

    /** Digest of the world before PHYSICS. It is valid only if there are early changes. */
    final long[] earlyDigest;

    /** Image (complete state) of the world at the end of this frame; null if none is due. */
    @Nullable SimulationImage image;

    /**
     * True if the journal stores the image instead of the frame, because the frame's changes do not
     * describe the world completely.
     */
    boolean begins;

    /** True if this entry is only the journal's final image, which belongs to no frame. */
    boolean last;

    Map<String, Long> members = Map.of();

    /** All changes of the rules since the world file, for the image. */
    RuleChanges allRules = RuleChanges.NONE;

    /** The changes of sessions that belong to this frame. */
    List<SessionNote> sessions = List.of();

    Entry(int digestSize) {
        digest = new long[digestSize];
        earlyDigest = new long[digestSize];
    }

    /** Removes all references to the frame's data, so that the entry can be reused. */
    void clear() {
        early.clear();
        late.clear();
        laws.clear();
        rules.clear();
        events = List.of();
        sessions = List.of();
        image = null;
        begins = false;
    }
}
