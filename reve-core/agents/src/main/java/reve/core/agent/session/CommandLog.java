// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.ServerMessage;

import java.util.Arrays;

/**
 * Which commands a client has given, by their ids, so that one sent twice is done once. Of the last
 * {@value #REMEMBERED} it knows the result; an id that could be older is not taken. Guarded by its
 * session.
 *
 * <p>Results are kept for as long as a client plays, and most say the same: they are kept as
 * numbers, so that they cost little memory and collectors of garbage need not look at each.
 */
final class CommandLog {

    static final int REMEMBERED = 1024;

    private static final int FEW = 16;

    private long[] pending = new long[FEW];
    private int pendingCount;

    // Finished commands, by turns; room grows as it is needed.
    private long[] ids = new long[FEW];
    private long[] frames = new long[FEW];

    /** What is more than accepted. */
    private @Nullable ServerMessage[] others = new ServerMessage[FEW];

    private int count;
    private int oldest;

    private long highest = -1;
    private long highestForgotten = -1;

    /** What is known of an id. */
    sealed interface Known {

        /** It has not been seen. */
        record Fresh() implements Known {}

        /** The result will come. */
        record Pending() implements Known {}

        record Done(ServerMessage result) implements Known {}

        /** It may have been done; nobody remembers. */
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

    /** The command was taken. */
    void begin(long id) {
        if (pendingCount == pending.length) {
            pending = Arrays.copyOf(pending, 2 * pendingCount);
        }
        pending[pendingCount++] = id;
        highest = Math.max(highest, id);
    }

    /** The command was not taken after all, and may be sent again. */
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
