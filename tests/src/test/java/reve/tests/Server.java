// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.BufferedReader;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.TimeUnit;
import java.util.function.Predicate;

/** A {@code ./reve serve --json} process. Closing this object ends the process. */
record Server(Process process, Events events) implements AutoCloseable {
    private static final long PATIENCE_SECONDS = 300;

    /** Time after which a server that does not write an expected event is ended. */
    private static final long EVENT_SECONDS = 300;

    /** The server's events, which are kept, so that the order of requests does not matter. */
    static final class Events {
        private final JsonMapper mapper = new JsonMapper();
        private final List<JsonNode> seen = new ArrayList<>();
        private final Process process;
        private final BufferedReader output;
        private final Path errors;

        Events(Process process, Path errors) {
            this.process = process;
            this.output = process.inputReader();
            this.errors = errors;
        }

        /** Returns the first event of this kind that meets the condition, past or future. */
        JsonNode await(String event, Predicate<JsonNode> wanted) throws IOException {
            CompletableFuture<Void> late =
                    CompletableFuture.runAsync(
                            process::destroyForcibly,
                            CompletableFuture.delayedExecutor(EVENT_SECONDS, TimeUnit.SECONDS));
            try {
                return read(event, wanted);
            } finally {
                late.cancel(false);
            }
        }

        private JsonNode read(String event, Predicate<JsonNode> wanted) throws IOException {
            for (int i = 0; ; i++) {
                if (i == seen.size()) {
                    String line = output.readLine();
                    if (line == null) {
                        throw new AssertionError(
                                "the server ended, or wrote nothing for "
                                        + EVENT_SECONDS
                                        + " s, without '"
                                        + event
                                        + "': "
                                        + seen
                                        + "\n"
                                        + Files.readString(errors));
                    }
                    seen.add(mapper.readTree(line));
                }
                JsonNode candidate = seen.get(i);
                if (candidate.path("event").asString("").equals(event) && wanted.test(candidate)) {
                    return candidate;
                }
            }
        }

        /** Returns the number of events that were read. */
        int count() {
            return seen.size();
        }

        /** Returns whether an event is none of the first {@code count}. */
        boolean isAfter(JsonNode event, int count) {
            return seen.subList(count, seen.size()).stream().anyMatch(later -> later == event);
        }

        /**
         * Returns all events of a server that has ended or is about to end, as far as it wrote
         * them.
         */
        List<JsonNode> untilEnd() throws IOException {
            try {
                for (String line = output.readLine(); line != null; line = output.readLine()) {
                    seen.add(mapper.readTree(line));
                }
            } catch (JacksonException cut) {
                // the server was killed in the middle of a line
            }
            return List.copyOf(seen);
        }
    }

    /**
     * @param folder contains the server's standard error
     */
    static Server start(Path folder, String... arguments) throws IOException {
        return start(folder, List.of(), Map.of(), arguments);
    }

    /**
     * @param folder contains the server's standard error
     * @param before words before the command, such as those that enter a namespace
     * @param environment variables that the server gets besides those of the tests
     */
    static Server start(
            Path folder, List<String> before, Map<String, String> environment, String... arguments)
            throws IOException {
        Path errors = folder.resolve("server.err");
        List<String> command = new ArrayList<>(before);
        command.addAll(Reve.command(arguments));
        ProcessBuilder builder = new ProcessBuilder(command).redirectError(errors.toFile());
        builder.environment().putAll(environment);
        Process process = builder.start();
        return new Server(process, new Events(process, errors));
    }

    /** Returns whether an event reports a fault, other than that a busy machine writes slowly. */
    static boolean isFault(JsonNode event) {
        return isFault(event.path("event").asString(""), event.path("message").asString(""));
    }

    /** Returns whether an event reports a fault, other than that a busy machine writes slowly. */
    static boolean isFault(String event, String message) {
        return event.equals("fault")
                && !message.startsWith("the disk is slow: ")
                && !message.startsWith("the disk is too slow: ");
    }

    /** Returns the port for agents. */
    String port() throws IOException {
        return events.await("ready", ready -> true).get("agentPort").asString();
    }

    /** Waits until the server ends by itself. */
    int exitCode() throws InterruptedException {
        if (!process.waitFor(PATIENCE_SECONDS, TimeUnit.SECONDS)) {
            throw new AssertionError("the server did not end within " + PATIENCE_SECONDS + " s");
        }
        return process.exitValue();
    }

    @Override
    public void close() {
        process.descendants().forEach(ProcessHandle::destroyForcibly);
        process.destroyForcibly();
        process.onExit().join();
    }
}
