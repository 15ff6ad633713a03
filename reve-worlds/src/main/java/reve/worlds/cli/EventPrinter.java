package reve.worlds.cli;

import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.atomic.AtomicLong;
import java.util.stream.Collectors;
import reve.worlds.server.ServerEvents;
import reve.worlds.server.ServerReport;

/**
 * Writes what happens in a server to standard output on a thread of its own, so that a reader who
 * does not read never holds a frame up: past 10,000 waiting lines, lines are dropped and counted.
 */
final class EventPrinter implements ServerEvents, AutoCloseable {
    private static final int CAPACITY = 10_000;
    private static final String END = "";

    private final PrintWriter out;
    private final boolean json;
    private final BlockingQueue<String> lines = new ArrayBlockingQueue<>(CAPACITY);
    private final AtomicLong dropped = new AtomicLong();
    private final Thread printer = new Thread(this::print, "event printer");

    EventPrinter(PrintWriter out, boolean json) {
        this.out = out;
        this.json = json;
        printer.setDaemon(true);
        printer.start();
    }

    @Override
    public void happened(String event, Map<String, Object> fields) {
        if (!lines.offer(json ? jsonLine(event, fields) : textLine(event, fields))) {
            dropped.incrementAndGet();
        }
    }

    /** The last event: how the run ended. Waits until everything is written. */
    void end(ServerReport report) throws InterruptedException {
        Map<String, Object> fields = report.fields();
        if (dropped.get() > 0) {
            fields.put("droppedEvents", dropped.get());
        }
        if (json) {
            lines.put(jsonLine("end", fields));
        }
        close();
        if (!json) {
            report.print(out);
        }
        out.flush();
    }

    @Override
    public void close() {
        try {
            if (printer.isAlive()) {
                lines.put(END);
                printer.join();
            }
        } catch (InterruptedException stopped) {
            Thread.currentThread().interrupt();
        }
    }

    private void print() {
        try {
            for (String line = lines.take(); !line.equals(END); line = lines.take()) {
                out.println(line);
                out.flush();
            }
        } catch (InterruptedException stopped) {
            Thread.currentThread().interrupt();
        }
    }

    private static String jsonLine(String event, Map<String, Object> fields) {
        Map<String, Object> line = new LinkedHashMap<>();
        line.put("event", event);
        line.putAll(fields);
        return Json.line(line);
    }

    private static String textLine(String event, Map<String, Object> fields) {
        return event + fields.entrySet().stream()
                .map(field -> " " + field.getKey() + "=" + field.getValue())
                .collect(Collectors.joining());
    }
}
