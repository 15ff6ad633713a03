// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.agent.AgentServerConfig;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Rights;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.protocol.Role;
import reve.core.file.AgentProgram;
import reve.core.file.RunPlan;
import reve.worlds.server.WorldServer;

import java.io.File;
import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.nio.charset.StandardCharsets;
import java.nio.file.DirectoryStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;

/**
 * The programs of a run's agents. Each program is a process with its own token. The server waits
 * for all agents to join before the first frame.
 */
final class AgentPrograms implements AutoCloseable {
    private static final long GRACE_SECONDS = 5;
    private static final int LAST_WORDS = 300;

    /** Reason in the event {@code left} of an agent that has sent bye. */
    private static final String GOODBYE = "goodbye";

    /** Maximum wait for the rest of a program's output after the program has ended. */
    private static final Duration OUTPUT_ENDS = Duration.ofSeconds(1);

    private final RunPlan plan;
    private final Path folder;
    private final Path logs;
    private final Duration deadline;
    private final Path secrets;
    private final Map<String, String> tokens = new LinkedHashMap<>();
    private final Map<String, Process> processes = new LinkedHashMap<>();
    private final Map<String, ProgramOutput> outputs = new ConcurrentHashMap<>();
    private final CountDownLatch begun = new CountDownLatch(1);
    private Optional<String> failure = Optional.empty();

    /**
     * Creates a token for each agent.
     *
     * @param folder the folder of the experiment file, in which the programs run
     * @param logs folder for the output of the programs
     * @param deadline maximum time until an agent has joined, and maximum time for one answer
     */
    AgentPrograms(RunPlan plan, Path folder, Path logs, Duration deadline) throws IOException {
        this.plan = plan;
        this.folder = folder;
        this.logs = Files.createDirectories(logs);
        this.deadline = deadline;
        this.secrets = Files.createTempDirectory("reve-experiment");
        var rights =
                new Rights(
                        Set.of(Role.AGENT),
                        Optional.of(Set.of(plan.world().name())),
                        Optional.empty(),
                        Optional.empty(),
                        true);
        for (AgentProgram program : plan.agents()) {
            AgentToken.Issued issued = AgentToken.issue(program.name(), rights, Optional.empty());
            TokenFile.add(tokenFile(), issued.token());
            tokens.put(program.name(), issued.secret());
        }
    }

    private Path tokenFile() {
        return secrets.resolve("tokens.json");
    }

    /** Returns the settings of a server that admits only these agents, on a free port. */
    AgentServerConfig config() throws IOException {
        return AgentServerConfig.on(
                        new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), 0),
                        new AgentSecurity(
                                Optional.of(TokenFile.open(tokenFile())), Optional.empty()))
                .withDeadline(deadline)
                .withWaiting(Optional.empty());
    }

    /** Starts the programs. Stops the server if not all of them join in time. */
    void start(WorldServer server) throws IOException {
        server.agents().expect(plan.world().name(), plan.agents().size());
        for (AgentProgram program : plan.agents()) {
            Process process = start(program, server.port());
            processes.put(program.name(), process);
            process.onExit()
                    .thenAccept(
                            ended -> {
                                if (begun.getCount() > 0) {
                                    fail(ended(program.name(), ended) + " before it had joined");
                                    server.stop();
                                }
                            });
        }
        Thread.ofVirtual().start(() -> awaitBeginning(server));
    }

    private void awaitBeginning(WorldServer server) {
        try {
            if (!begun.await(deadline.toMillis(), TimeUnit.MILLISECONDS)) {
                fail(
                        "the agents did not all join within "
                                + deadline.toMillis() / 1000.0
                                + " s: "
                                + String.join(", ", processes.keySet()));
                server.stop();
            }
        } catch (InterruptedException ended) {
            Thread.currentThread().interrupt();
        }
    }

    private Process start(AgentProgram program, int port) throws IOException {
        List<String> command = new ArrayList<>(program.command(port));
        Path file = Path.of(command.getFirst());
        if (file.getNameCount() > 1 && !file.isAbsolute()) {
            command.set(0, folder.resolve(file).toString());
        }
        ProcessBuilder builder =
                new ProcessBuilder(command)
                        .directory(folder.toFile())
                        .redirectInput(new File("/dev/null"))
                        .redirectErrorStream(true);
        Map<String, String> environment = builder.environment();
        environment.put("REVE_HOST", "127.0.0.1");
        environment.put("REVE_PORT", Integer.toString(port));
        environment.put("REVE_WORLD", plan.world().name());
        environment.put("REVE_NAME", program.name());
        environment.put("REVE_TOKEN", tokens.get(program.name()));
        environment.put("REVE_SEED", Long.toString(plan.point().seed()));
        environment.put("REVE_RUN", Integer.toString(plan.point().number()));
        String client = Path.of(System.getProperty("reve.root", "")).resolve("agents/python") + "";
        environment.merge("PYTHONPATH", client, (own, ours) -> own + File.pathSeparator + ours);
        try {
            Process process = builder.start();
            outputs.put(
                    program.name(),
                    new ProgramOutput(
                            process.getInputStream(),
                            log(program.name()),
                            ProgramOutput.MAX_BYTES));
            return process;
        } catch (IOException refused) {
            throw new IOException(
                    "the program of agent "
                            + program.name()
                            + " cannot be started: "
                            + refused.getMessage(),
                    refused);
        }
    }

    private Path log(String agent) {
        return logs.resolve("run-" + plan.point().number() + "-" + agent + ".log");
    }

    /** Records that the first frame was made. For the world's thread only. */
    void begun(WorldServer server) {
        begun.countDown();
        int count = server.agents().inLockStep(plan.world().name());
        if (count < plan.agents().size()) {
            fail(
                    count
                            + " of "
                            + plan.agents().size()
                            + " agents are in lock-step, expected all: join with time=LockStep()"
                            + " in Python, withLockStep in Java");
            server.stop();
        }
    }

    /** Handles an event of the world. For the world's thread only. */
    void happened(String event, Map<String, Object> fields, WorldServer server) {
        if (event.equals("late")) {
            fail(
                    "agent "
                            + fields.get("agent")
                            + " did not answer in time in frame "
                            + fields.get("frame")
                            + "; the result would depend on the clock");
            server.stop();
        } else if (event.equals("left")
                && fields.get("frame") instanceof Number frame
                && frame.longValue() < plan.frames()) {
            left(String.valueOf(fields.get("agent")), frame.longValue(), fields, server);
        }
    }

    private void left(String agent, long frame, Map<String, Object> fields, WorldServer server) {
        if (!GOODBYE.equals(fields.get("reason"))) {
            fail(
                    "agent "
                            + agent
                            + " lost its connection in frame "
                            + frame
                            + " of "
                            + plan.frames()
                            + lastWords(agent));
            server.stop();
        }
    }

    private synchronized void fail(String why) {
        if (failure.isEmpty()) {
            failure = Optional.of(why);
        }
    }

    /** Returns the reason why the run has no valid result; empty if no agent failed. */
    synchronized Optional<String> failure() {
        return failure;
    }

    private String ended(String agent, Process process) {
        return "the program of agent "
                + agent
                + " ended with code "
                + process.exitValue()
                + lastWords(agent);
    }

    /** Returns the last part of a program's output, for a message. */
    private String lastWords(String agent) {
        try {
            outputs.get(agent).await(OUTPUT_ENDS);
            List<String> lines =
                    new String(Files.readAllBytes(log(agent)), StandardCharsets.UTF_8)
                            .lines()
                            .filter(line -> !line.isBlank())
                            .toList();
            String last = lines.isEmpty() ? "" : lines.getLast();
            return last.isEmpty()
                    ? ""
                    : " (" + last.substring(0, Math.min(LAST_WORDS, last.length())) + ")";
        } catch (IOException unreadable) {
            return "";
        } catch (InterruptedException hurried) {
            Thread.currentThread().interrupt();
            return "";
        }
    }

    /** Ends the programs, and removes the tokens. */
    @Override
    public void close() {
        begun.countDown();
        for (Process process : processes.values()) {
            try {
                if (!process.waitFor(GRACE_SECONDS, TimeUnit.SECONDS)) {
                    process.descendants().forEach(ProcessHandle::destroyForcibly);
                    process.destroyForcibly();
                }
            } catch (InterruptedException hurried) {
                process.destroyForcibly();
                Thread.currentThread().interrupt();
            }
        }
        try {
            for (ProgramOutput output : outputs.values()) {
                output.await(OUTPUT_ENDS);
            }
        } catch (InterruptedException hurried) {
            Thread.currentThread().interrupt();
        }
        try (DirectoryStream<Path> files = Files.newDirectoryStream(secrets)) {
            for (Path file : files) {
                Files.deleteIfExists(file); // the tokens and their lock
            }
            Files.deleteIfExists(secrets);
        } catch (IOException remains) {
            // The exception is ignored, because the folder is private and its tokens are valid only
            // for a server that has ended.
        }
    }
}
