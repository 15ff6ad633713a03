// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/** What happened to a world in the frame that is being made. World's thread. */
final class FrameRecord {

    /** Changes that a frame keeps; more are only counted. */
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

    /** Returns a number, 1 or more, that rises when entries begin to belong to another frame. */
    long period() {
        return period;
    }

    /** In the order raised; a copy. */
    List<WorldEvent> events() {
        return events.entries();
    }

    /** In the order made; a copy. */
    List<WorldChange> changes() {
        return changes.entries();
    }

    /** How many changes were too many to keep. */
    long changesLost() {
        return changes.lost();
    }

    /** Begins PUBLISH: what is added from now on belongs to the next frame. */
    void fix() {
        events.fix();
        changes.fix();
        period++;
    }

    /** Forgets this frame, fixed or not. */
    void end() {
        if (!changes.isFixed()) {
            period++;
        }
        events.end();
        changes.end();
    }
}
