// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.port.Elsewhere;
import reve.core.frame.Pacing;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.locks.ReentrantLock;
import java.util.function.Consumer;
import java.util.function.Supplier;

/**
 * A server that opens and closes worlds while it runs, and serves them to agents at one address.
 * Each world has its own thread, which builds, runs and closes it. For any thread.
 */
public final class WorldHost implements AutoCloseable {
    private final Pacing pacing;
    private final Optional<Path> lawsFolder;
    private final ServerEvents events;
    private final AgentServer agents;
    private final Watchdog watchdog;
    private final Map<String, Hosting> worlds = new ConcurrentHashMap<>();

    /** One world at a time is built, so that each has the processors for itself. */
    private final ReentrantLock building = new ReentrantLock();

    /** Guarded by itself. */
    private final List<RunReport> reports = new ArrayList<>();

    /** Guarded by itself. */
    private final List<String> unkept = new ArrayList<>();

    private volatile Supplier<Optional<Map<String, Object>>> cluster = Optional::empty;
    private volatile boolean closing;

    /**
     * Starts to listen for agents, without a world.
     *
     * @param lawsFolder folder that is watched for law libraries, if present; they act in all
     *     worlds
     * @throws IOException if the port cannot be bound
     */
    public WorldHost(
            Pacing pacing,
            AgentServerConfig config,
            Optional<Path> lawsFolder,
            WatchdogPlan watch,
            ServerEvents events)
            throws IOException {
        this.pacing = pacing;
        this.lawsFolder = lawsFolder;
        this.events = events;
        this.agents =
                AgentServer.start(
                        config,
                        List.of(),
                        (source, message) ->
                                events.happened("fault", WorldServer.fault(source, message)));
        this.watchdog = new Watchdog(watch, List.of());
        watchdog.start();
    }

    /** Returns the address for agents. */
    public InetSocketAddress address() {
        return agents.address();
    }

    /**
     * Joins a cluster: sends agents to the worlds of other servers from now on, and answers
     * operators' questions about the cluster.
     *
     * @param state returns the answer, for any thread and at once
     */
    public void join(Elsewhere others, Supplier<Map<String, Object>> state) {
        cluster = () -> Optional.of(state.get());
        agents.sendTo(others);
    }

    /**
     * Opens a world on a thread of its own, and runs it until it is stopped or ends.
     *
     * @param plan makes the plan of the world, on the thread of the world
     * @param whenClosed is called on the thread of the world when the world was closed, or could
     *     not be opened. The argument is the reason, which was reported; it is empty if the world
     *     was stopped
     * @throws IllegalStateException if the host has the world already
     */
    public Hosting open(
            String world, Callable<WorldPlan> plan, Consumer<Optional<String>> whenClosed) {
        Hosting hosting = new Hosting(world, plan, whenClosed);
        if (worlds.putIfAbsent(world, hosting) != null) {
            throw new IllegalStateException("the world " + world + " is open already");
        }
        hosting.thread.start();
        return hosting;
    }

    /** A world of a host. For any thread. */
    public final class Hosting {
        private final String name;
        private final Callable<WorldPlan> plan;
        private final Consumer<Optional<String>> whenClosed;
        private final Thread thread;

        // Guarded by this object's lock.
        private @Nullable HostedWorld hosted;
        private boolean stopped;
        private boolean isOpening = true;

        private Hosting(
                String name, Callable<WorldPlan> plan, Consumer<Optional<String>> whenClosed) {
            this.name = name;
            this.plan = plan;
            this.whenClosed = whenClosed;
            this.thread = Thread.ofPlatform().name("world " + name).unstarted(this::live);
        }

        /** Closes the world after its current frame. Returns at once. Idempotent. */
        public synchronized void stop() {
            if (stopped) {
                return;
            }
            stopped = true;
            HostedWorld running = hosted;
            if (running != null) {
                running.stop();
            } else if (isOpening) {
                thread.interrupt(); // it may wait for the lease of another server
            }
        }

        private void live() {
            Optional<String> problem = Optional.empty();
            try {
                WorldPlan made = plan.call();
                HostedWorld world = build(made);
                try (world) {
                    if (hasOpened(world)) {
                        problem = run(world);
                    }
                }
                keep(world);
            } catch (Exception | Error failure) {
                problem = isStopped() ? Optional.empty() : Optional.of(reported(failure));
            } finally {
                worlds.remove(name, this);
                whenClosed.accept(problem);
            }
        }

        private HostedWorld build(WorldPlan made) throws IOException, InterruptedException {
            building.lockInterruptibly();
            try {
                return new HostedWorld(
                        made,
                        pacing,
                        lawsFolder,
                        new NamedEvents(name, events),
                        () -> cluster.get());
            } finally {
                building.unlock();
            }
        }

        /** Ends the time in which {@link #stop} interrupts; returns whether the world shall run. */
        private synchronized boolean hasOpened(HostedWorld world) {
            isOpening = false;
            Thread.interrupted();
            hosted = stopped ? null : world;
            return !stopped;
        }

        private synchronized boolean isStopped() {
            return stopped;
        }

        private Optional<String> run(HostedWorld world) {
            Watchdog.Subject watched = world.watched();
            agents.add(world.port());
            try {
                watchdog.add(watched);
                world.start(agents.address(), Optional.empty());
                RunReport report = world.run();
                if (closing) {
                    synchronized (reports) {
                        reports.add(report);
                    }
                }
                return isStopped()
                        ? Optional.empty()
                        : Optional.of(
                                world.isLost()
                                        ? "another server has taken the world " + name
                                        : "the world " + name + " was shut down");
            } finally {
                watchdog.remove(watched);
                agents.remove(name);
            }
        }

        private void keep(HostedWorld world) {
            if (world.unkept().isPresent() && !world.isLost()) {
                synchronized (unkept) {
                    unkept.add(world.unkept().get());
                }
            }
        }

        private String reported(Throwable failure) {
            HostedWorld world;
            synchronized (this) {
                world = hosted;
            }
            String message =
                    "the world "
                            + name
                            + (world == null ? " could not be opened: " : " has ended: ")
                            + (failure.getMessage() == null ? failure : failure.getMessage());
            if (world == null || !world.isLost()) { // otherwise the reason was reported
                new NamedEvents(name, events)
                        .happened("fault", WorldServer.fault("world", message));
            }
            return message;
        }
    }

    /** Returns the names of the worlds that are open, or are being opened or closed. */
    public List<String> worlds() {
        return worlds.keySet().stream().sorted().toList();
    }

    /**
     * Returns the report of the worlds that were open when the host was closed. Valid after close.
     */
    public ServerReport report() {
        synchronized (reports) {
            synchronized (unkept) {
                return new ServerReport(reports, reports.size(), agents.stats(), unkept, List.of());
            }
        }
    }

    /** Announces that the worlds that close from now on belong into the report. */
    public void willClose() {
        closing = true;
    }

    /** Closes all worlds, and disconnects all agents. Idempotent. */
    @Override
    public void close() {
        willClose();
        List<Hosting> open = List.copyOf(worlds.values());
        open.forEach(Hosting::stop);
        boolean interrupted = false;
        for (Hosting hosting : open) {
            while (hosting.thread.isAlive()) {
                try {
                    hosting.thread.join();
                } catch (InterruptedException e) {
                    interrupted = true; // a world must be closed before the server of its agents
                }
            }
        }
        watchdog.close();
        agents.close();
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
    }
}
