// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.ClientMessage;

import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.Iterator;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.function.Consumer;
import java.util.function.LongPredicate;
import java.util.function.LongSupplier;

/**
 * The turns of queries that read many items, or a large answer, on the event loop. They are
 * answered in slices of the event loop's time, in which clients take turns; clients with the role
 * control come first. A query that needs more than one slice continues after a turn of each other
 * client. Together the queries take at most a tenth of the time on average. A query may have to
 * wait for a frame first. For any thread.
 */
final class QueryTurns {

    /** Maximum number of queries of one client that wait. */
    static final int MOST = 8;

    /** Duration of a slice [ns]. A query that needs longer continues in the next slice. */
    private static final long SLICE_NANOS = 1_000_000;

    /**
     * Maximum time that a query waits for a frame [ns]. A world in lock-step may wait much longer
     * for its agents.
     */
    private static final long LONGEST_WAIT_NANOS = 1_000_000_000;

    /** A query that is being answered. For the event loop's thread only. */
    interface Work {
        /**
         * Continues the query, at most for some milliseconds.
         *
         * @param end time at which it shall pause [ns]
         * @return true if the query was answered or refused
         */
        boolean proceed(long end);
    }

    private final Consumer<Runnable> loop;
    private final LongSupplier clock;

    private final LongPredicate isReadable;

    private record Waiting(Requester requester, ClientMessage.Query query, Work work) {}

    /** A query that reads a frame which the world has not made yet. */
    private record Early(long frame, long until, Waiting query) {}

    /** Queries that wait for a frame, in order of their arrival. Guarded by this object's lock. */
    private final Deque<Early> early = new ArrayDeque<>();

    /** Queries by client, in order of their turns. Guarded by this object's lock. */
    private final Map<Requester, Deque<Waiting>> waiting = new LinkedHashMap<>();

    /** The query that is being answered. Guarded by this object's lock. */
    private @Nullable Waiting current;

    /** True while a slice is queued or runs. Guarded by this object's lock. */
    private boolean isRunning;

    /** The time of the queries answered so far. Guarded by this object's lock. */
    private final TimeShare share;

    /**
     * @param loop runs code on the event loop, soon
     * @param clock returns the time since a fixed moment [ns], not negative
     * @param isReadable returns whether queries need not wait for a frame, given by its number;
     *     called on any thread with this object's lock
     */
    QueryTurns(Consumer<Runnable> loop, LongSupplier clock, LongPredicate isReadable) {
        this.loop = loop;
        this.clock = clock;
        this.share = new TimeShare(clock);
        this.isReadable = isReadable;
    }

    /** Returns the time by the clock of these turns [ns]. */
    long now() {
        return clock.getAsLong();
    }

    /**
     * Queues a query. Refuses it if too many queries of the client wait.
     *
     * @param frame number of the earliest frame that the query shall read. It reads an older frame
     *     if the world does not make this one within a second
     */
    void ask(Requester requester, ClientMessage.Query query, long frame, Work work) {
        boolean hasRoom;
        synchronized (this) {
            hasRoom = count(requester) < MOST;
            if (hasRoom) {
                long until = clock.getAsLong() + LONGEST_WAIT_NANOS;
                early.add(new Early(frame, until, new Waiting(requester, query, work)));
            }
        }
        if (!hasRoom) {
            refuseBusy(requester, query);
        }
        proceed();
    }

    /** Refuses a query of a client of which {@link #MOST} queries wait. */
    static void refuseBusy(Requester requester, ClientMessage.Query query) {
        requester.refuse(
                query,
                "world-busy",
                "you have sent " + MOST + " such queries that wait for their turn; try again");
    }

    private boolean isDue(Early query) {
        return isReadable.test(query.frame) || clock.getAsLong() >= query.until;
    }

    private int count(Requester requester) {
        Deque<Waiting> own = waiting.get(requester);
        int count = own == null ? 0 : own.size();
        for (Early each : early) {
            count += each.query.requester.equals(requester) ? 1 : 0;
        }
        return count;
    }

    /** Runs a slice if queries wait and have not exceeded their part of the time. */
    void proceed() {
        synchronized (this) {
            while (!early.isEmpty() && isDue(early.getFirst())) {
                Waiting query = early.removeFirst().query;
                waiting.computeIfAbsent(query.requester, any -> new ArrayDeque<>()).add(query);
            }
            if (isRunning || waiting.isEmpty() || !share.isOpen()) {
                return;
            }
            isRunning = true;
        }
        loop.accept(this::slice);
    }

    /** Drops the waiting queries of a client that has no connection any more. */
    void forget(Requester requester) {
        var dropped = new ArrayList<Waiting>();
        synchronized (this) {
            dropped.addAll(waiting.getOrDefault(requester, new ArrayDeque<>()));
            waiting.remove(requester);
            for (Iterator<Early> all = early.iterator(); all.hasNext(); ) {
                Waiting query = all.next().query;
                if (query.requester.equals(requester)) {
                    dropped.add(query);
                    all.remove();
                }
            }
            if (current != null && current.requester.equals(requester)) {
                current = null;
            }
        }
        dropped.forEach(each -> refuseGone(each.requester, each.query));
    }

    private void slice() {
        long begin = clock.getAsLong();
        long end = begin + SLICE_NANOS;
        try {
            Waiting next = take();
            while (next != null) {
                if (!next.work.proceed(end) && !putBack(next)) {
                    refuseGone(next.requester, next.query);
                }
                next = clock.getAsLong() < end ? take() : null;
            }
        } finally {
            synchronized (this) {
                share.pay(clock.getAsLong() - begin);
                isRunning = false;
                current = null;
            }
        }
        proceed();
    }

    /** Removes and returns the query that has its turn. */
    private synchronized @Nullable Waiting take() {
        Deque<Waiting> own = null;
        for (Map.Entry<Requester, Deque<Waiting>> each : waiting.entrySet()) {
            if (each.getKey().controls()) {
                own = each.getValue();
                break;
            }
            own = own == null ? each.getValue() : own;
        }
        if (own == null) {
            return null;
        }
        Waiting next = own.removeFirst();
        waiting.remove(next.requester);
        if (!own.isEmpty()) {
            waiting.put(next.requester, own); // the next turn of this client comes after all others
        }
        current = next;
        return next;
    }

    /** Returns a query to the queue. Returns false if its client has gone. */
    private synchronized boolean putBack(Waiting query) {
        if (current != query) {
            return false;
        }
        waiting.computeIfAbsent(query.requester, any -> new ArrayDeque<>()).addFirst(query);
        return true;
    }

    static void refuseGone(Requester requester, ClientMessage.Query query) {
        requester.refuse(query, "world-busy", "the connection ended; ask again");
    }
}
