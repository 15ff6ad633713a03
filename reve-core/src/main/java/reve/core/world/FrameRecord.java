// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.ArrayList;
import java.util.List;

/** What happened to a world in the frame that is being made. World's thread. */
final class FrameRecord {

    /** Changes that a frame keeps; more are only counted. */
    private static final int MAX_CHANGES = 1 << 20;

    private final FrameLog<WorldEvent> events = new FrameLog<>(Integer.MAX_VALUE);
    private final FrameLog<WorldChange> changes = new FrameLog<>(MAX_CHANGES);
    private final List<Column> directlyEdited = new ArrayList<>();

    void raise(WorldEvent event) {
        events.add(event);
    }

    void note(WorldChange change) {
        changes.add(change);
    }

    /** Told by a column once a frame, until it is told to forget it. */
    void noteEdited(Column column) {
        directlyEdited.add(column);
        note(new WorldChange.ColumnEdited(column.descriptor().kind(), column.name()));
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
        forgetDirectEdits();
    }

    /** Forgets this frame, fixed or not. */
    void end() {
        if (!changes.isFixed()) {
            forgetDirectEdits();
        }
        events.end();
        changes.end();
    }

    private void forgetDirectEdits() {
        directlyEdited.forEach(Column::forgetEdit);
        directlyEdited.clear();
    }
}
