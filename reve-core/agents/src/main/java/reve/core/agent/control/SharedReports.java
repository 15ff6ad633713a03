// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import org.jspecify.annotations.Nullable;

import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Fragment;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.publish.Publisher;
import reve.core.world.ActionRefused;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.EnumMap;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Objects;
import java.util.concurrent.atomic.AtomicIntegerArray;
import java.util.concurrent.atomic.AtomicReferenceArray;
import java.util.function.LongSupplier;
import java.util.function.UnaryOperator;

/**
 * Answers to queries that many clients may send at the same time. The world's thread reads the
 * content of each kind of report once for all waiting queries, and the event loop encodes this
 * content once. Answers are sent in slices of the event loop's time, in which clients take turns.
 * Queries that find no time in a slice wait for the next one. Reports take at most a tenth of the
 * time on average.
 */
final class SharedReports {

    /** The kinds of reports that clients share. */
    enum Kind {
        STATE,
        LAWS,
        LAWS_WITH_FAULTS
    }

    /**
     * Duration of a slice, after which no further answer is begun [ns]. At least one answer is sent
     * in each slice.
     */
    private static final long SLICE_NANOS = 1_000_000;

    private static final Kind[] KINDS = Kind.values();

    private final WorldPort port;
    private final Publisher publisher;
    private final RateLimitedLog log;

    /** Functions that add to the content of a report on the event loop's thread, by kind. */
    private final Map<Kind, UnaryOperator<Map<String, Object>>> completions;

    private record Waiting(Requester requester, ClientMessage.Query query, Kind kind) {}

    /**
     * The result of a reading by the world's thread. It contains the content, or the reason why
     * there is none.
     */
    private record Read(@Nullable Map<String, Object> content, @Nullable Exception failure) {}

    /** Queries by client, in order of their turns. Guarded by this object's lock. */
    private final Map<Requester, Deque<Waiting>> waiting = new LinkedHashMap<>();

    /**
     * True while a reading is requested from the world's thread or its answers are not sent yet.
     * Guarded by this object's lock.
     */
    private boolean isReading;

    /** The time of the reports made so far. Guarded by this object's lock. */
    private final TimeShare share;

    private final LongSupplier clock;

    /** Number of waiting queries by kind. */
    private final AtomicIntegerArray wanted = new AtomicIntegerArray(KINDS.length);

    /** The newest function to read the content, by kind. */
    private final AtomicReferenceArray<WorldControl.Reading> readings =
            new AtomicReferenceArray<>(KINDS.length);

    /**
     * @param completions functions that complete the content of a report, by kind of report; called
     *     on the event loop
     * @param clock returns the time since a fixed moment [ns], not negative
     */
    SharedReports(
            WorldPort port,
            Publisher publisher,
            RateLimitedLog log,
            Map<Kind, UnaryOperator<Map<String, Object>>> completions,
            LongSupplier clock) {
        this.clock = clock;
        this.share = new TimeShare(clock);
        this.port = port;
        this.publisher = publisher;
        this.log = log;
        this.completions = Map.copyOf(completions);
    }

    /**
     * Queues a query. It is answered when its client has its turn. For any thread.
     *
     * @param reading reads the content for all queries of this kind
     */
    void ask(
            Requester requester,
            ClientMessage.Query query,
            Kind kind,
            WorldControl.Reading reading) {
        synchronized (this) {
            waiting.computeIfAbsent(requester, any -> new ArrayDeque<>())
                    .add(new Waiting(requester, query, kind));
            readings.set(kind.ordinal(), reading);
            wanted.incrementAndGet(kind.ordinal());
        }
        proceed();
    }

    /** Drops the waiting queries of a client that has no connection any more. */
    void forget(Requester requester) {
        Deque<Waiting> dropped;
        synchronized (this) {
            dropped = waiting.remove(requester);
            if (dropped != null) {
                dropped.forEach(each -> wanted.decrementAndGet(each.kind.ordinal()));
            }
        }
        if (dropped != null) {
            for (Waiting each : dropped) {
                requester.refuse(each.query, "world-busy", "the connection ended; ask again");
            }
        }
    }

    /**
     * Requests a reading if queries wait and reports have not exceeded their part of the time.
     * Called periodically.
     */
    void proceed() {
        synchronized (this) {
            if (isReading || waiting.isEmpty() || !share.isOpen()) {
                return;
            }
            isReading = true;
        }
        port.loop().betweenFrames(this::read);
    }

    /**
     * Reads the content of each kind for which queries wait. For the world's thread, between
     * frames.
     */
    private void read() {
        long begin = clock.getAsLong();
        long frame = port.loop().frame();
        var read = new EnumMap<Kind, Read>(Kind.class);
        for (Kind kind : KINDS) {
            if (wanted.get(kind.ordinal()) > 0) {
                read.put(kind, read(readings.get(kind.ordinal())));
            }
        }
        long nanos = clock.getAsLong() - begin;
        publisher.later(() -> answer(frame, read, nanos));
    }

    private static Read read(WorldControl.Reading reading) {
        try {
            return new Read(reading.read(), null);
        } catch (ActionRefused | RuntimeException e) {
            return new Read(null, e);
        }
    }

    /** Answers queries for the duration of one slice. For the event loop's thread only. */
    private void answer(long frame, Map<Kind, Read> read, long readNanos) {
        long begin = clock.getAsLong();
        var contents = new EnumMap<Kind, Fragment>(Kind.class);
        try {
            Waiting next = next(read);
            while (next != null) {
                answer(next, frame, Objects.requireNonNull(read.get(next.kind)), contents);
                next = clock.getAsLong() - begin < SLICE_NANOS ? next(read) : null;
            }
        } finally {
            synchronized (this) {
                share.pay(readNanos + clock.getAsLong() - begin);
                isReading = false;
            }
        }
        proceed();
    }

    /**
     * Removes and returns the query that must be answered next. Returns null if there is none, or
     * if its kind of report was not read.
     */
    private synchronized @Nullable Waiting next(Map<Kind, Read> read) {
        if (waiting.isEmpty()) {
            return null;
        }
        Map.Entry<Requester, Deque<Waiting>> first = waiting.entrySet().iterator().next();
        Deque<Waiting> queries = first.getValue();
        if (!read.containsKey(queries.getFirst().kind)) {
            // The query arrived after the content was read, so it waits for the next time.
            return null;
        }
        Waiting next = queries.removeFirst();
        wanted.decrementAndGet(next.kind.ordinal());
        waiting.remove(next.requester);
        if (!queries.isEmpty()) {
            waiting.put(next.requester, queries);
        }
        return next;
    }

    private void answer(Waiting next, long frame, Read read, Map<Kind, Fragment> contents) {
        Requester requester = next.requester;
        ClientMessage.Query query = next.query;
        switch (read.failure) {
            case null -> {
                Fragment content = contents.computeIfAbsent(next.kind, kind -> content(kind, read));
                Reports.answer(
                        requester,
                        query,
                        new ServerMessage.Report(query.id(), frame, query.type(), content)
                                .in(requester.encoding()));
            }
            case ActionRefused e -> requester.refuse(query, e.code(), e.getMessage());
            case Exception e -> Reports.fail(requester, query, log, e);
        }
    }

    private Fragment content(Kind kind, Read read) {
        Map<String, Object> content =
                completions
                        .getOrDefault(kind, UnaryOperator.identity())
                        .apply(Objects.requireNonNull(read.content));
        return new Fragment(writer -> writer.value(content));
    }
}
