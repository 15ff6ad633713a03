// SPDX-License-Identifier: Apache-2.0
package reve.worlds.demo;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.BufferedReader;
import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.concurrent.TimeUnit;
import java.util.function.Predicate;

/**
 * A child process that writes JSON objects to its standard output, one object per line. Its
 * standard error is written to a log file. Closing this object ends the process.
 */
final class JsonProcess implements AutoCloseable {
    private static final JsonMapper MAPPER = new JsonMapper();
    private static final long GRACE_SECONDS = 5;

    private final String name;
    private final Path log;
    private final Process process;
    private final Thread reader;

    /**
     * The lines that were read so far. The monitor of this list guards the list and {@link
     * #reading}.
     */
    private final List<JsonNode> lines = new ArrayList<>();

    private boolean reading = true;

    JsonProcess(String name, List<String> command, Map<String, String> environment, Path log)
            throws IOException {
        this.name = name;
        this.log = log;
        ProcessBuilder builder = new ProcessBuilder(command).redirectError(log.toFile());
        builder.environment().putAll(environment);
        process = start(name, builder);
        reader = Thread.ofPlatform().daemon().name(name + " output").start(this::read);
    }

    private static Process start(String name, ProcessBuilder builder) throws IOException {
        try {
            return builder.start();
        } catch (IOException e) {
            throw new IOException(
                    "the %s needs the program %s, which cannot be started; `reve doctor` says what is missing"
                            .formatted(name, builder.command().getFirst()),
                    e);
        }
    }

    private void read() {
        try (BufferedReader output = process.inputReader()) {
            for (String line = output.readLine(); line != null; line = output.readLine()) {
                JsonNode node = MAPPER.readTree(line);
                synchronized (lines) {
                    lines.add(node);
                    lines.notifyAll();
                }
            }
        } catch (IOException ended) {
            // The exception is ignored. The pipe broke because the process ended, and the method
            // await() then reports the missing line.
        } catch (JacksonException notJson) {
            process.destroy();
        } finally {
            synchronized (lines) {
                reading = false;
                lines.notifyAll();
            }
        }
    }

    /**
     * Returns the first line of this event that matches the condition. Waits for the line until the
     * process ends or reports a failure.
     */
    JsonNode await(String event, Predicate<JsonNode> wanted) throws InterruptedException {
        synchronized (lines) {
            for (int seen = 0; ; seen++) {
                while (seen == lines.size()) {
                    if (!reading) {
                        throw new IllegalStateException(
                                name
                                        + " ended without telling '"
                                        + event
                                        + "'; its messages are in "
                                        + log);
                    }
                    lines.wait();
                }
                JsonNode line = lines.get(seen);
                if (line.path("event").asString("").equals(event) && wanted.test(line)) {
                    return line;
                }
                if (line.path("event").asString("").equals(event + "-failed")) {
                    throw new IllegalStateException(
                            name + ": " + event + " failed: " + line.path("message").asString());
                }
            }
        }
    }

    /** Asks the process to end, as Ctrl-C does. Its output is still read. */
    void interrupt() {
        process.toHandle().destroy();
    }

    /** Kills the process (SIGKILL), and waits for its end. */
    void kill() {
        process.destroyForcibly().onExit().join();
    }

    /** Waits for the process to end, and returns the last line that it wrote. */
    JsonNode awaitEnd(long seconds) throws InterruptedException {
        if (!process.waitFor(seconds, TimeUnit.SECONDS)) {
            throw new IllegalStateException(
                    name + " did not end within " + seconds + " s; see " + log);
        }
        reader.join();
        if (process.exitValue() != 0 || lines.isEmpty()) {
            throw new IllegalStateException(
                    name + " ended with code " + process.exitValue() + "; see " + log);
        }
        return lines.getLast();
    }

    @Override
    public void close() {
        process.destroy();
        try {
            if (!process.waitFor(GRACE_SECONDS, TimeUnit.SECONDS)) {
                process.destroyForcibly();
            }
        } catch (InterruptedException hurried) {
            process.destroyForcibly();
            Thread.currentThread().interrupt();
        }
    }
}
