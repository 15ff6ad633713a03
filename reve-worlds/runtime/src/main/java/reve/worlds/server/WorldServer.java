// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.WorldPort;
import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.frame.Pacing;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * A server of worlds that agents join over TCP and that load law libraries while they run. Each
 * world has its own thread and shares only the address with the other worlds. A world computes the
 * same bits as it would alone. Its failure does not affect the other worlds. One thread creates,
 * starts, runs and closes the server; {@link #stop} may be called on any thread.
 */
public final class WorldServer implements AutoCloseable {
    private final Closing closing = new Closing();
    private final ServerEvents events;
    private final List<HostedWorld> worlds = new ArrayList<>();
    private final List<WorldDescription> descriptions;
    private final List<WorldPort> ports;
    private final AgentServer agents;
    private final Watchdog watchdog;

    /** Creates a server without a watchdog. */
    public WorldServer(
            List<WorldPlan> plans,
            Pacing pacing,
            AgentServerConfig config,
            Optional<Path> lawsFolder,
            ServerEvents events)
            throws IOException {
        this(plans, pacing, config, lawsFolder, WatchdogPlan.OFF, events);
    }

    /**
     * Builds the worlds, loads their laws, and starts to listen.
     *
     * @param plans the plans of the worlds, at least one; the worlds must have different names
     * @param lawsFolder folder that is watched for law libraries, if present; they act in all
     *     worlds
     * @throws IOException if the port cannot be bound, or a file cannot be opened
     * @throws reve.core.image.CorruptException if a store is damaged or belongs to another world
     * @throws reve.pe.PhysicsException if a law of a world file does not load
     */
    public WorldServer(
            List<WorldPlan> plans,
            Pacing pacing,
            AgentServerConfig config,
            Optional<Path> lawsFolder,
            WatchdogPlan watch,
            ServerEvents events)
            throws IOException {
        this.events = events;
        try {
            for (WorldPlan plan : plans) {
                ServerEvents own =
                        plans.size() == 1
                                ? events
                                : new NamedEvents(plan.description().name(), events);
                worlds.add(closing.add(new HostedWorld(plan, pacing, lawsFolder, own)));
            }
            descriptions = plans.stream().map(WorldPlan::description).toList();
            ports = worlds.stream().map(HostedWorld::port).toList();
            Map<String, List<CarriedSession>> carried = new LinkedHashMap<>();
            worlds.forEach(world -> carried.put(world.name(), world.sessions()));
            agents =
                    closing.add(
                            AgentServer.start(
                                    config,
                                    ports,
                                    carried, // a node of a cluster may have had the worlds before
                                    (source, message) ->
                                            events.happened("fault", fault(source, message))));
            watchdog =
                    closing.add(
                            new Watchdog(
                                    watch, worlds.stream().map(HostedWorld::watched).toList()));
        } catch (IOException | RuntimeException refused) {
            closing.closeAfter(refused);
            throw refused;
        }
    }

    /** Returns the fields of a fault event that was not caused by a single law. */
    static Map<String, Object> fault(String source, String message) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", source);
        fields.put("message", message);
        return fields;
    }

    /**
     * Returns the server for agents. Programs in this process may also connect clients to it
     * directly.
     */
    public AgentServer agents() {
        return agents;
    }

    /** Returns the descriptions from which the worlds were built, in the order of the plans. */
    public List<WorldDescription> descriptions() {
        return descriptions;
    }

    /**
     * Returns the interfaces of the worlds, for other servers such as that of the web page, in the
     * order of the plans.
     */
    public List<WorldPort> ports() {
        return ports;
    }

    /**
     * Returns the worlds with their laws, in the order of the plans. A program may subscribe to
     * their frames before {@link #run}.
     */
    public List<Simulation> simulations() {
        return worlds.stream().map(HostedWorld::simulation).toList();
    }

    /** Returns the TCP port for agents. */
    public int port() {
        return agents.address().getPort();
    }

    /**
     * Returns the warnings about the worlds, in the order of the plans. Call it before {@link
     * #start}.
     */
    public List<Problem> warnings() {
        return worlds.stream().flatMap(world -> world.warnings().stream()).toList();
    }

    /** Starts to watch the laws folder, and reports that the worlds are ready. */
    public void start() {
        start(Optional.empty());
    }

    /**
     * Starts the server like {@link #start()}, and reports the address of the web page.
     *
     * @param page address of the web page that shows the worlds
     */
    public void start(Optional<String> page) {
        worlds.forEach(world -> world.start(agents.address(), page));
        watchdog.start();
    }

    /** Runs the worlds until each has made its frames or was stopped, and returns the report. */
    public ServerReport run() {
        List<Run> runs = worlds.stream().map(Run::new).toList();
        runs.forEach(run -> run.thread.start());
        runs.forEach(Run::join);
        return new ServerReport(
                runs.stream().flatMap(run -> Optional.ofNullable(run.report).stream()).toList(),
                worlds.size(),
                agents.stats(),
                List.of(),
                List.of());
    }

    /** The run of one world on its own thread. */
    private final class Run {
        private final HostedWorld world;
        private final Thread thread;
        private @Nullable RunReport report;

        Run(HostedWorld world) {
            this.world = world;
            this.thread = Thread.ofPlatform().name("world " + world.name()).unstarted(this::run);
        }

        /** Runs the world. Catches every failure, so that the other worlds continue. */
        private void run() {
            try {
                report = world.run();
            } catch (RuntimeException | Error failure) {
                if (!world.isLost()) {
                    // Only other failures are reported here, because the loss of a world was
                    // already reported.
                    world.tellProblem(
                            "world", "the world " + world.name() + " has ended: " + failure);
                }
            } finally {
                agents.end(world.name());
            }
        }

        /** Waits for the world. An interrupt of the waiting thread stops all worlds. */
        private void join() {
            while (thread.isAlive()) {
                try {
                    thread.join();
                } catch (InterruptedException e) {
                    stop();
                }
            }
        }
    }

    /** Ends {@link #run} after the worlds' current frames. For any thread. */
    public void stop() {
        worlds.forEach(HostedWorld::stop);
        worlds.forEach(HostedWorld::hurry);
    }

    /**
     * Returns messages about data that the stores of the worlds lack, one for each incomplete
     * store. Valid after close.
     */
    public List<String> unkept() {
        return worlds.stream().flatMap(world -> world.unkept().stream()).toList();
    }

    /** Returns messages about frames that the recordings lack. Valid after close. */
    public List<String> gaps() {
        return worlds.stream().flatMap(world -> world.gap().stream()).toList();
    }

    /** Disconnects agents, finishes pictures, and frees all resources. Idempotent. */
    @Override
    public void close() {
        closing.close();
    }
}
