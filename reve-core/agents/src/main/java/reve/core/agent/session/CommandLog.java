// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.ServerMessage;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;

/**
 * The ids and results of a client's commands. They prevent a command that the client repeats from
 * being executed twice. Results of the last {@value #REMEMBERED} commands are stored, or of fewer
 * commands if their results exceed {@value #CHARACTERS} characters. The result {@link
 * Known.Forgotten} means that an unknown id may belong to an older command. Guarded by the lock of
 * its session.
 *
 * <p>Most results contain only a frame number. Such results are stored as numbers, which take
 * little memory and cause no work for the garbage collector.
 */
final class CommandLog {

    static final int REMEMBERED = 1024;

    /** Maximum size of all stored results except the last one [characters]. */
    static final int CHARACTERS = 1 << 18;

    /**
     * Size that is counted for a number, a truth value, and the frame of a list or map
     * [characters].
     */
    private static final int FRAME = 16;

    private static final int FEW = 16;

    private long[] pending = new long[FEW];
    private int pendingCount;

    // Finished commands in a ring buffer, which grows when needed.
    private long[] ids = new long[FEW];
    private long[] frames = new long[FEW];

    /**
     * Results that are not of the type {@link ServerMessage.Accepted}; null for results of this
     * type.
     */
    private @Nullable ServerMessage[] others = new ServerMessage[FEW];

    private int[] sizes = new int[FEW];

    private int count;
    private int oldest;
    private long characters;

    private long highest = -1;
    private long highestForgotten = -1;

    /** The state of the command with an id. */
    sealed interface Known {

        /** Reports that no command had this id. */
        record Fresh() implements Known {}

        /** Reports that the command is being executed and has no result yet. */
        record Pending() implements Known {}

        record Done(ServerMessage result) implements Known {}

        /** Reports that the command may have been executed, but that its result was discarded. */
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
            int place = (oldest + i) % ids.length;
            if (ids[place] == id) {
                ServerMessage other = others[place];
                return new Known.Done(
                        other != null ? other : new ServerMessage.Accepted(id, frames[place]));
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

    /**
     * Records that a command was not accepted for execution after all. The client may send it
     * again.
     */
    void cancel(long id) {
        int place = pendingPlace(id);
        if (place >= 0) {
            pending[place] = pending[--pendingCount];
        }
    }

    void finish(long id, ServerMessage result) {
        cancel(id);
        int size = size(result);
        while (count == REMEMBERED || count > 0 && characters + size > CHARACTERS) {
            forgetOldest();
        }
        if (count == ids.length) {
            grow();
        }
        int place = (oldest + count++) % ids.length;
        ids[place] = id;
        frames[place] = result instanceof ServerMessage.Accepted accepted ? accepted.frame() : 0;
        others[place] = result instanceof ServerMessage.Accepted ? null : result;
        sizes[place] = size;
        characters += size;
        highest = Math.max(highest, id);
    }

    /** Returns the stored results, oldest first. */
    List<ServerMessage> results() {
        List<ServerMessage> results = new ArrayList<>();
        for (int i = 0; i < count; i++) {
            int place = (oldest + i) % ids.length;
            ServerMessage other = others[place];
            results.add(
                    other != null ? other : new ServerMessage.Accepted(ids[place], frames[place]));
        }
        return results;
    }

    /** Returns the highest id of a command whose result is not stored any more; -1 if none. */
    long highestForgotten() {
        return highestForgotten;
    }

    /** Records that the results of commands up to this id may be missing. */
    void forget(long id) {
        highestForgotten = Math.max(highestForgotten, id);
        highest = Math.max(highest, id);
    }

    private void forgetOldest() {
        highestForgotten = Math.max(highestForgotten, ids[oldest]);
        characters -= sizes[oldest];
        others[oldest] = null;
        oldest = (oldest + 1) % ids.length;
        count--;
    }

    /** Doubles the size of the ring buffer. The oldest result gets the index 0. */
    private void grow() {
        int room = Math.min(2 * count, REMEMBERED);
        var grownIds = new long[room];
        var grownFrames = new long[room];
        var grownOthers = new ServerMessage[room];
        var grownSizes = new int[room];
        for (int i = 0; i < count; i++) {
            int place = (oldest + i) % ids.length;
            grownIds[i] = ids[place];
            grownFrames[i] = frames[place];
            grownOthers[i] = others[place];
            grownSizes[i] = sizes[place];
        }
        ids = grownIds;
        frames = grownFrames;
        others = grownOthers;
        sizes = grownSizes;
        oldest = 0;
    }

    /**
     * Returns the approximate size of the part of a result that is not stored as numbers
     * [characters].
     */
    private static int size(ServerMessage result) {
        return switch (result) {
            case ServerMessage.Refused refused -> refused.reason().length();
            case ServerMessage.Answer answer ->
                    (int) Math.min(size(answer.value()), Integer.MAX_VALUE);
            default -> 0;
        };
    }

    private static long size(@Nullable Object value) {
        return switch (value) {
            case String text -> text.length();
            case Map<?, ?> map ->
                    FRAME
                            + map.entrySet().stream()
                                    .mapToLong(e -> size(e.getKey()) + size(e.getValue()))
                                    .sum();
            case Iterable<?> list -> {
                long sum = FRAME;
                for (Object element : list) {
                    sum += size(element);
                }
                yield sum;
            }
            case null, default -> FRAME;
        };
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
