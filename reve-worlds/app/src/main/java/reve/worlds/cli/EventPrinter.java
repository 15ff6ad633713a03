// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.worlds.server.ServerEvents;
import reve.worlds.server.ServerReport;

import java.io.PrintWriter;
import java.time.Duration;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.locks.LockSupport;
import java.util.stream.Collectors;

/**
 * Printer of server events to standard output. It has its own thread, so a slow reader never delays
 * a frame. At most 10,000 lines wait. Further lines are dropped and counted. Lines that cannot be
 * written because the output is full or closed are counted, too. The thread polls its queue every
 * few milliseconds, so threads that report events never have to wake it.
 */
final class EventPrinter implements ServerEvents, AutoCloseable {
    private static final int CAPACITY = 10_000;
    private static final long LOOK_NANOS = 10_000_000;
    private static final Event LAST = new Event("", Map.of());

    private final LinePrinter out;
    private final PrintWriter err;
    private final boolean json;
    private final Printed printed;
    private final Queue<Event> events = new ConcurrentLinkedQueue<>();
    private final AtomicInteger waiting = new AtomicInteger();
    private final AtomicLong dropped = new AtomicLong();

    /** True if the last event could not be written. Only the printer's thread uses the field. */
    private boolean failing;

    private final Thread printer = new Thread(this::print, "event printer");

    private record Event(String name, Map<String, Object> fields) {}

    /**
     * @param err receives a report when events are lost because they cannot be written
     */
    EventPrinter(LinePrinter out, PrintWriter err, boolean json, Printed printed) {
        this.out = out;
        this.err = err;
        this.json = json;
        this.printed = printed;
        printer.setDaemon(true);
        printer.start();
    }

    @Override
    public boolean wants(String event) {
        return printed.includes(event);
    }

    @Override
    public void happened(String event, Map<String, Object> fields) {
        if (!wants(event)) {
            return;
        }
        if (waiting.incrementAndGet() > CAPACITY) {
            waiting.decrementAndGet();
            dropped.incrementAndGet();
        } else {
            events.add(new Event(event, fields));
        }
    }

    /** Prints the final report, and waits until everything is written. */
    void end(ServerReport report) {
        Map<String, Object> fields = report.fields();
        if (dropped.get() > 0) {
            fields.put("droppedEvents", dropped.get());
        }
        if (json) {
            events.add(new Event("end", fields));
        }
        close();
        if (!json) {
            report.print(out);
        }
        out.flush();
    }

    /** Ends the thread after it has written the waiting lines. Idempotent. */
    @Override
    public void close() {
        close(Duration.ofMillis(Long.MAX_VALUE));
    }

    /**
     * Closes the printer like {@link #close()}. Stops waiting for the output after {@code limit}.
     */
    void close(Duration limit) {
        events.add(LAST);
        LockSupport.unpark(printer);
        try {
            if (printer.join(limit)) {
                out.flush();
            }
        } catch (InterruptedException stopped) {
            Thread.currentThread().interrupt();
        }
    }

    private void print() {
        while (true) {
            Event event = events.poll();
            if (event == LAST) {
                return;
            }
            if (event == null) {
                out.flush();
                LockSupport.parkNanos(LOOK_NANOS);
            } else {
                waiting.decrementAndGet();
                print(event);
            }
        }
    }

    /**
     * Prints one event. The event is lost and the worlds continue if the output is full or closed.
     */
    private void print(Event event) {
        long failures = out.watched().failures();
        out.println(json ? jsonLine(event) : textLine(event));
        if (out.watched().failures() > failures) {
            dropped.incrementAndGet();
            if (!failing) {
                err.println(
                        "reve: standard output cannot be written: "
                                + out.watched().reason().orElseThrow()
                                + "; the worlds continue, and events are lost until it can");
            }
            failing = true;
        } else if (failing) {
            failing = false;
            err.println(
                    "reve: standard output can be written again; "
                            + dropped.get()
                            + " events have been lost so far");
        }
    }

    private static String jsonLine(Event event) {
        Map<String, Object> line = new LinkedHashMap<>();
        line.put("event", event.name);
        event.fields.forEach(line::putIfAbsent); // the server's own fields are kept
        return Json.line(line);
    }

    /**
     * Returns an event as a line for people, with rounded numbers and shortened hashes. Omits the
     * field with warnings, because warnings are printed to standard error.
     */
    private static String textLine(Event event) {
        return event.name
                + event.fields.entrySet().stream()
                        .filter(field -> !field.getKey().equals("warnings"))
                        .map(field -> " " + field.getKey() + "=" + Shortened.of(field.getValue()))
                        .collect(Collectors.joining());
    }
}
