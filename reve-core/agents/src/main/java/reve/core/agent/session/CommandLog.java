// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.ServerMessage;

import java.util.Arrays;

/**
 * The ids and results of a client's commands, so that a command which the client repeats is
 * executed once. Stores the results of the last {@value #REMEMBERED} commands; an unknown id that
 * may belong to an older command is {@link Known.Forgotten}. Guarded by its session.
 *
 * <p>Most results only contain a frame. They are stored as numbers, which takes little memory and
 * no work of the garbage collector.
 */
final class CommandLog {

    static final int REMEMBERED = 1024;

    private static final int FEW = 16;

    private long[] pending = new long[FEW];
    private int pendingCount;

    // Finished commands in a ring buffer, which grows when needed.
    private long[] ids = new long[FEW];
    private long[] frames = new long[FEW];

    /** Results other than {@link ServerMessage.Accepted}; null for these. */
    private @Nullable ServerMessage[] others = new ServerMessage[FEW];

    private int count;
    private int oldest;

    private long highest = -1;
    private long highestForgotten = -1;

    /** The state of the command with an id. */
    sealed interface Known {

        /** No command had this id before. */
        record Fresh() implements Known {}

        /** The command is being executed and has no result yet. */
        record Pending() implements Known {}

        record Done(ServerMessage result) implements Known {}

        /** The command may have been executed; its result is no longer stored. */
        record Forgotten() implements Known {}
    }

    Known look(long id) {
        if (id > highest) {
            return new Known.Fresh();
        }
        if (pendingPlace(id) >= 0) {
            return new Known.Pending();
        }
        for (int i = 0; i < count; i++) {
            if (ids[i] == id) {
                ServerMessage other = others[i];
                return new Known.Done(
                        other != null ? other : new ServerMessage.Accepted(id, frames[i]));
            }
        }
        return id > highestForgotten ? new Known.Fresh() : new Known.Forgotten();
    }

    /** Records that a command was accepted for execution. */
    void begin(long id) {
        if (pendingCount == pending.length) {
            pending = Arrays.copyOf(pending, 2 * pendingCount);
        }
        pending[pendingCount++] = id;
        highest = Math.max(highest, id);
    }

    /** Records that a command was not accepted after all; the client may send it again. */
    void cancel(long id) {
        int place = pendingPlace(id);
        if (place >= 0) {
            pending[place] = pending[--pendingCount];
        }
    }

    void finish(long id, ServerMessage result) {
        cancel(id);
        int place = placeOfNext();
        ids[place] = id;
        frames[place] = result instanceof ServerMessage.Accepted accepted ? accepted.frame() : 0;
        others[place] = result instanceof ServerMessage.Accepted ? null : result;
        highest = Math.max(highest, id);
    }

    private int placeOfNext() {
        if (count == REMEMBERED) {
            int place = oldest;
            highestForgotten = Math.max(highestForgotten, ids[place]);
            oldest = (oldest + 1) % REMEMBERED;
            return place;
        }
        if (count == ids.length) {
            int room = Math.min(2 * count, REMEMBERED);
            ids = Arrays.copyOf(ids, room);
            frames = Arrays.copyOf(frames, room);
            others = Arrays.copyOf(others, room);
        }
        return count++;
    }

    private int pendingPlace(long id) {
        for (int i = 0; i < pendingCount; i++) {
            if (pending[i] == id) {
                return i;
            }
        }
        return -1;
    }
}
