// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.protocol.ClientMessage;

import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.List;
import java.util.Map;
import java.util.function.Consumer;
import java.util.function.Function;
import java.util.function.LongSupplier;
import java.util.stream.Stream;

/**
 * The readings of laws' own columns, for reports of items. Snapshots do not contain these columns,
 * so the world's thread reads them between two frames, for several queries at once. Together the
 * readings take at most a tenth of the time on average. If the world does not read the columns
 * within a second, for example because a law does not return, the report lacks them. For any
 * thread.
 */
final class ColumnReadings {
    /** Maximum number of queries that the world's thread serves between two frames. */
    private static final int MOST_AT_ONCE = 8;

    /** Maximum time that a query waits for a reading [ns]. */
    private static final long LONGEST_WAIT_NANOS = 1_000_000_000;

    /** The receiver of a query after its reading. */
    @FunctionalInterface
    interface Next {
        /**
         * Answers the query.
         *
         * @param columns the fields of the report; empty if the columns could not be read
         */
        void accept(Requester requester, ClientMessage.Inspect query, Map<String, Object> columns);
    }

    private record Waiting(Requester requester, ClientMessage.Inspect query, long until) {}

    private final Consumer<Runnable> betweenFrames;
    private final Consumer<Runnable> later;
    private final Function<String, Map<String, Object>> read;
    private final Next next;
    private final LongSupplier clock;

    /**
     * Queries in order of their arrival: those of clients with the role control, which come first,
     * and all others. Guarded by this object's lock.
     */
    private final List<Deque<Waiting>> waiting = List.of(new ArrayDeque<>(), new ArrayDeque<>());

    /** Queries of the reading in progress. Guarded by this object's lock. */
    private final List<Waiting> reading = new ArrayList<>();

    /** True while a reading is in progress. Guarded by this object's lock. */
    private boolean isReading;

    /** The time of the readings so far. Guarded by this object's lock. */
    private final TimeShare share;

    /**
     * @param betweenFrames runs code on the world's thread between two frames
     * @param later runs code on the event loop
     * @param read returns the fields of the report of an item, by its name; called on the world's
     *     thread
     * @param next receives each query after its reading, on the event loop or the asking thread
     * @param clock returns the time since a fixed moment [ns], not negative
     */
    ColumnReadings(
            Consumer<Runnable> betweenFrames,
            Consumer<Runnable> later,
            Function<String, Map<String, Object>> read,
            Next next,
            LongSupplier clock) {
        this.betweenFrames = betweenFrames;
        this.later = later;
        this.read = read;
        this.next = next;
        this.clock = clock;
        this.share = new TimeShare(clock);
    }

    /** Queues a query. Refuses it if too many queries of the client wait. */
    void ask(Requester requester, ClientMessage.Inspect query) {
        boolean hasRoom;
        synchronized (this) {
            hasRoom = count(requester) < QueryTurns.MOST;
            if (hasRoom) {
                long until = clock.getAsLong() + LONGEST_WAIT_NANOS;
                waiting.get(requester.controls() ? 0 : 1).add(new Waiting(requester, query, until));
            }
        }
        if (!hasRoom) {
            QueryTurns.refuseBusy(requester, query);
        }
        proceed();
    }

    private long count(Requester requester) {
        return of(requester).count();
    }

    /** Returns the waiting queries of a client. */
    private Stream<Waiting> of(Requester requester) {
        return Stream.concat(reading.stream(), waiting.stream().flatMap(Deque::stream))
                .filter(each -> each.requester.equals(requester));
    }

    /** Begins a reading if queries wait, and gives up queries that wait too long. */
    void proceed() {
        List<Waiting> late = new ArrayList<>();
        List<Waiting> batch = new ArrayList<>();
        synchronized (this) {
            long now = clock.getAsLong();
            takeLate(late, now);
            if (!isReading && share.isOpen()) {
                for (Deque<Waiting> each : waiting) {
                    while (!each.isEmpty() && batch.size() < MOST_AT_ONCE) {
                        batch.add(each.removeFirst());
                    }
                }
                reading.addAll(batch);
                isReading = !batch.isEmpty();
            }
        }
        late.forEach(each -> next.accept(each.requester, each.query, Map.of()));
        if (!batch.isEmpty()) {
            betweenFrames.accept(() -> read(batch));
        }
    }

    private void takeLate(List<Waiting> late, long now) {
        reading.stream().filter(each -> now >= each.until).forEach(late::add);
        reading.removeAll(late);
        for (Deque<Waiting> each : waiting) {
            while (!each.isEmpty() && now >= each.getFirst().until) {
                late.add(each.removeFirst());
            }
        }
    }

    /** Reads the columns. For the world's thread, between two frames. */
    private void read(List<Waiting> batch) {
        long begin = clock.getAsLong();
        List<Map<String, Object>> columns = new ArrayList<>();
        for (Waiting each : batch) {
            columns.add(read.apply(each.query.item()));
        }
        long nanos = clock.getAsLong() - begin;
        later.accept(() -> finish(batch, columns, nanos));
    }

    /** Passes the queries on that still wait. */
    private void finish(List<Waiting> batch, List<Map<String, Object>> columns, long nanos) {
        List<Runnable> ready = new ArrayList<>();
        synchronized (this) {
            for (int i = 0; i < batch.size(); i++) {
                Waiting each = batch.get(i);
                Map<String, Object> found = columns.get(i);
                if (reading.remove(each)) {
                    ready.add(() -> next.accept(each.requester, each.query, found));
                }
            }
            share.pay(nanos);
            isReading = false;
        }
        ready.forEach(Runnable::run);
        proceed();
    }

    /** Drops the waiting queries of a client that has no connection any more. */
    void forget(Requester requester) {
        List<Waiting> dropped;
        synchronized (this) {
            dropped = of(requester).toList();
            waiting.forEach(each -> each.removeAll(dropped));
            reading.removeAll(dropped);
        }
        dropped.forEach(each -> QueryTurns.refuseGone(each.requester, each.query));
    }
}
