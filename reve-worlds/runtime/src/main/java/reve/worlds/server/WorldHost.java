// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.Elsewhere;
import reve.core.frame.Pacing;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.locks.ReentrantLock;

/**
 * A server that opens and closes worlds while it runs, and serves them to agents at one address.
 * Each world has its own thread, which builds, runs and closes it. For any thread.
 */
public final class WorldHost implements AutoCloseable {
    /** Time after which a copy that has failed is tried again [ns]. */
    private static final long RETRY_NANOSECONDS = 10_000_000_000L;

    private final Pacing pacing;
    private final Optional<Path> lawsFolder;
    private final ServerEvents events;
    private final AgentServer agents;
    private final Watchdog watchdog;
    private final Map<String, Hosting> worlds = new ConcurrentHashMap<>();

    /** The copies of worlds of other servers, by name. Added with the lock of this map. */
    private final Map<String, WatchedWorld> copies = new ConcurrentHashMap<>();

    /** The times at which copies failed [ns], by the name of the world. */
    private final Map<String, Long> failedCopies = new ConcurrentHashMap<>();

    /**
     * This lock is held while a world is built. Only one world at a time is built, so that it can
     * use all processors.
     */
    private final ReentrantLock building = new ReentrantLock();

    /** Reports of the closed worlds. Guarded by the lock of this list. */
    private final List<RunReport> reports = new ArrayList<>();

    /** Messages about data that the stores lack. Guarded by the lock of this list. */
    private final List<String> unkept = new ArrayList<>();

    private volatile Optional<HostCluster> cluster = Optional.empty();
    private volatile Optional<HostPage> page = Optional.empty();
    private volatile boolean closing;

    /**
     * Starts to listen for agents, without a world. Until the host has joined a cluster, agents are
     * told to try again.
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
        agents.sendTo(Elsewhere.UNKNOWN); // until the host joins a cluster
        this.watchdog = new Watchdog(watch, List.of());
        watchdog.start();
    }

    /** Returns the address for agents. */
    public InetSocketAddress address() {
        return agents.address();
    }

    /**
     * Joins a cluster. The host then refers agents to the worlds of other servers, and passes on
     * operators' questions and orders about the cluster.
     */
    public void join(HostCluster joined) {
        cluster = Optional.of(joined);
        agents.sendTo(joined);
    }

    /** Shows the worlds that are opened from now on in a web page. The caller closes the page. */
    public void show(HostPage shown) {
        page = Optional.of(shown);
    }

    /** Returns the address of the web page; empty if there is none. */
    public Optional<String> web() {
        return page.map(HostPage::address);
    }

    /** Returns the cluster; empty until the host has joined it. */
    public Optional<ClusterPort> cluster() {
        return cluster.map(ClusterPort.class::cast);
    }

    /**
     * Returns the server for agents. Other servers of this process may connect clients to it
     * directly.
     */
    public AgentServer agents() {
        return agents;
    }

    /**
     * Opens a world on a separate thread, and runs it until it is stopped or ends.
     *
     * @param plan makes the plan of the world, on the thread of the world
     * @param whenClosed is called on the thread of the world when the world was closed, or could
     *     not be opened
     * @throws IllegalStateException if the host has the world already
     */
    public Hosting open(String world, Callable<WorldPlan> plan, CloseListener whenClosed) {
        Hosting hosting = new Hosting(world, plan, whenClosed);
        if (worlds.putIfAbsent(world, hosting) != null) {
            throw new IllegalStateException("the world " + world + " is open already");
        }
        hosting.thread.start();
        return hosting;
    }

    /**
     * Shows a copy of a world that another server runs to observers, as long as there are any.
     * Returns at once; does nothing if the host has the copy already or is being closed.
     *
     * @param plan makes the plan of the world, of which the copy uses the files; on a thread of the
     *     copy
     * @return false if the copy failed a short time ago, which was reported
     */
    public boolean watch(String world, Callable<WorldPlan> plan, FrameSource.Connector connector) {
        Long failed = failedCopies.get(world);
        if (failed != null && System.nanoTime() - failed < RETRY_NANOSECONDS) {
            return false;
        }
        synchronized (copies) {
            if (closing || copies.containsKey(world)) {
                return true;
            }
            var copy =
                    new WatchedWorld(
                            world,
                            plan,
                            connector,
                            this,
                            new NamedEvents(world, events),
                            hasFailed -> copyEnded(world, hasFailed));
            copies.put(world, copy);
            copy.start();
            return true;
        }
    }

    private void copyEnded(String world, boolean hasFailed) {
        if (hasFailed) {
            failedCopies.put(world, System.nanoTime());
        } else {
            failedCopies.remove(world);
        }
        copies.remove(world);
    }

    /** Returns the cluster of the host; empty until the host has joined it. */
    Optional<HostCluster> hostCluster() {
        return cluster;
    }

    /** Returns the page that shows the worlds; empty if there is none. */
    Optional<HostPage> page() {
        return page;
    }

    /**
     * Puts the worlds to sleep that have no clients, and had none for a time: each of them writes
     * its state and is closed, until a client asks for it. A world whose store accepts no frames
     * continues. Waits for the event loop of the agent server, but for no world.
     */
    public void sleepUnused(Duration time) {
        worlds.values().forEach(hosting -> hosting.sleepIfUnused(time));
    }

    /**
     * Prevents all worlds from making frames, or permits it again, because another server may run
     * them. Returns at once.
     */
    public void suspend(boolean isSuspended) {
        worlds.values().forEach(hosting -> hosting.suspend(isSuspended));
    }

    /** Receives the end of a world. */
    @FunctionalInterface
    public interface CloseListener {
        /**
         * @param reason why the world has ended, which was reported; empty if it was stopped
         * @param isAsleep whether the world sleeps until a client asks for it
         */
        void closed(Optional<String> reason, boolean isAsleep);
    }

    /** A world of a host. For any thread. */
    public final class Hosting {
        private final String name;
        private final Callable<WorldPlan> plan;
        private final CloseListener whenClosed;
        private final Thread thread;

        /** The readers of the world's frames on other servers. Guarded by this object's lock. */
        private final List<FrameFeed> feeds = new ArrayList<>();

        /** The last time at which a feed was closed [ns]. */
        private volatile long fedNanos = System.nanoTime() - Duration.ofDays(365).toNanos();

        /** Whether {@link #feed} may open feeds. Guarded by this object's lock. */
        private boolean isServing;

        // The world; null before it is built. Guarded by this object's lock.
        private @Nullable HostedWorld hosted;
        private boolean stopped;
        private boolean handsOver;
        private boolean shallSleep;
        private boolean isOpening = true;

        private Hosting(String name, Callable<WorldPlan> plan, CloseListener whenClosed) {
            this.name = name;
            this.plan = plan;
            this.whenClosed = whenClosed;
            this.thread = Thread.ofPlatform().name("world " + name).unstarted(this::live);
        }

        /**
         * Closes the world like {@link #stop}, because another server of the cluster shall run it:
         * sends its agents there.
         */
        public synchronized void handOver() {
            if (!stopped) {
                handsOver = true;
                stop();
            }
        }

        /**
         * @param mayContinue whether another server may run the world, so that its agents ask there
         */
        private void close(boolean mayContinue) {
            if (mayContinue) {
                handOver();
            } else {
                stop();
            }
            synchronized (this) {
                if (hosted != null) {
                    hosted.hurry();
                }
            }
        }

        /**
         * Opens a feed of the world's frames for another server, which closes it. The feed ends
         * when the world is closed.
         *
         * @return empty if the world is not open
         */
        public synchronized Optional<FrameFeed> feed() {
            HostedWorld world = hosted;
            if (!isServing || world == null) {
                return Optional.empty();
            }
            var feed = new FrameFeed(world.simulation(), world.header(), this::forgetClosedFeeds);
            feeds.add(feed);
            return Optional.of(feed);
        }

        private synchronized void forgetClosedFeeds() {
            feeds.removeIf(FrameFeed::isClosed);
            fedNanos = System.nanoTime();
        }

        private void beginFeeds() {
            synchronized (this) {
                isServing = true;
            }
        }

        /** Closes all feeds. Waits until no feed reads the world. */
        private void endFeeds() {
            List<FrameFeed> open;
            synchronized (this) {
                isServing = false;
                open = List.copyOf(feeds);
            }
            open.forEach(FrameFeed::finish); // without the lock, which the end of a feed takes
        }

        private synchronized boolean isFed(Duration time) {
            return !feeds.isEmpty() || System.nanoTime() - fedNanos < time.toNanos();
        }

        private void sleepIfUnused(Duration time) {
            if (isOpen() && isKept() && !isFed(time) && agents.endIfUnused(name, time)) {
                synchronized (this) {
                    if (!stopped) {
                        shallSleep = true;
                        stop();
                    }
                }
            }
        }

        private synchronized void suspend(boolean isSuspended) {
            if (hosted != null) {
                hosted.simulation().loop().suspend(isSuspended);
            }
        }

        private synchronized boolean isOpen() {
            return hosted != null && !stopped;
        }

        /** Returns whether the world's store, if it has one, accepts its frames. */
        public synchronized boolean isKept() {
            return hosted == null || hosted.isKept();
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
                thread.interrupt(); // the thread may wait for the lease of another server
            }
        }

        private void live() {
            Optional<String> problem = Optional.empty();
            boolean isAsleep = false;
            try {
                WorldPlan made = plan.call();
                HostedWorld world = build(made);
                try (world) {
                    if (hasOpened(world)) {
                        problem = run(world);
                        isAsleep = shallSleep() && world.fallAsleep();
                    }
                }
                keep(world);
                if (isAsleep) {
                    new NamedEvents(name, events).happened("world-asleep", world.asleepFields());
                }
            } catch (Exception | Error failure) {
                problem = isStopped() ? Optional.empty() : Optional.of(reported(failure));
            } finally {
                worlds.remove(name, this);
                whenClosed.closed(problem, isAsleep);
            }
        }

        private synchronized boolean shallSleep() {
            return shallSleep;
        }

        private HostedWorld build(WorldPlan made) throws IOException, InterruptedException {
            building.lockInterruptibly();
            try {
                return new HostedWorld(
                        made,
                        pacing,
                        lawsFolder,
                        new NamedEvents(name, events),
                        WorldHost.this::cluster);
            } finally {
                building.unlock();
            }
        }

        /**
         * Records that the world is open, so that {@link #stop} does not interrupt its thread after
         * this call. Returns whether the world shall run.
         */
        private synchronized boolean hasOpened(HostedWorld world) {
            isOpening = false;
            Thread.interrupted();
            hosted = stopped ? null : world;
            return !stopped;
        }

        /** Returns whether the world was told to stop. */
        public synchronized boolean isStopped() {
            return stopped;
        }

        private Optional<String> run(HostedWorld world) {
            Optional<HostPage> shows = page;
            shows.ifPresent(
                    shown -> shown.add(world.port(), world.simulation().description().camera()));
            try {
                return serve(world);
            } finally {
                shows.ifPresent(shown -> shown.remove(name));
            }
        }

        private Optional<String> serve(HostedWorld world) {
            Watchdog.Subject watched = world.watched();
            agents.add(world.port(), world.sessions());
            try {
                watchdog.add(watched);
                world.start(agents.address(), web());
                beginFeeds();
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
                endFeeds();
                watchdog.remove(watched);
                page.ifPresent(shown -> shown.remove(name)); // it is no failure that the world ends
                world.handOver(agents.remove(name, next(world)));
            }
        }

        /** Returns the address at which the agents of the world ask for it from now on. */
        private synchronized Optional<String> next(HostedWorld world) {
            if (world.isLost()) {
                return cluster.flatMap(known -> known.refuge(name));
            }
            return handsOver ? cluster.flatMap(known -> known.next(name)) : Optional.empty();
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
            if (world == null || !world.isLost()) {
                // Only other failures are reported here, because the loss of a world was already
                // reported.
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

    /** Makes the report include the worlds that are closed after this call. */
    public void willClose() {
        closing = true;
    }

    /** Closes all worlds, and disconnects all agents. Idempotent. */
    @Override
    public void close() {
        willClose();
        List<WatchedWorld> shown;
        synchronized (copies) {
            shown = List.copyOf(copies.values());
        }
        shown.forEach(WatchedWorld::close);
        List<Hosting> open = List.copyOf(worlds.values());
        open.forEach(hosting -> hosting.close(cluster.isPresent()));
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
