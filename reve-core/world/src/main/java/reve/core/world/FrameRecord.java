// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/** The events and changes of the frame that is being made. For the world's thread only. */
final class FrameRecord {

    /** Maximum number of stored changes per frame. Further changes are counted, but not stored. */
    private static final int MAX_CHANGES = 1 << 20;

    private final FrameLog<WorldEvent> events = new FrameLog<>(Integer.MAX_VALUE);
    private final FrameLog<WorldChange> changes = new FrameLog<>(MAX_CHANGES);
    private final Charges charges = new Charges();
    private long period = 1;

    void raise(WorldEvent event) {
        events.add(event);
    }

    void note(WorldChange change) {
        changes.add(change);
        charges.note(change);
    }

    Charges charges() {
        return charges;
    }

    /**
     * Returns a number, at least 1, that identifies the frame to which new entries belong. It
     * increases as soon as entries belong to the next frame.
     */
    long period() {
        return period;
    }

    /** Returns a copy of the events, in the order in which they were raised. */
    List<WorldEvent> events() {
        return events.entries();
    }

    /** Returns a copy of the changes, in the order in which they were made. */
    List<WorldChange> changes() {
        return changes.entries();
    }

    /** Returns how many changes were not stored because of the limit. */
    long changesLost() {
        return changes.lost();
    }

    /** Begins the phase PUBLISH. Events and changes from now on belong to the next frame. */
    void fix() {
        events.fix();
        changes.fix();
        period++;
    }

    /** Discards the entries of this frame, whether {@link #fix()} was called or not. */
    void end() {
        if (!changes.isFixed()) {
            period++;
        }
        events.end();
        changes.end();
    }
}
