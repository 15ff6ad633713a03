// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.frame.Pacing;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Running worlds that agents join over TCP and law libraries are dropped into. Each world has a
 * thread of its own and shares nothing with the others but the address: what it does is the same,
 * to the bit, as alone, and when it fails the others go on. Made, started, run and closed by one
 * thread; {@link #stop} is for any.
 */
public final class WorldServer implements AutoCloseable {
    private final Closing closing = new Closing();
    private final ServerEvents events;
    private final List<HostedWorld> worlds = new ArrayList<>();
    private final AgentServer agents;
    private final Watchdog watchdog;

    /** The same, without a watchdog. */
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
     * Builds the worlds, loads their laws, and begins to listen.
     *
     * @param plans of worlds of different names, at least one
     * @param lawsFolder watched for law libraries, which act in every world, if given
     * @throws IOException if the port cannot be bound, or a file not opened
     * @throws reve.core.store.CorruptException if a store is damaged, or no store of its world
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
                ServerEvents own = plans.size() == 1 ? events : eventsOf(plan.description().name());
                worlds.add(closing.add(new HostedWorld(plan, pacing, lawsFolder, own)));
            }
            agents =
                    closing.add(
                            AgentServer.start(
                                    config,
                                    worlds.stream().map(HostedWorld::port).toList(),
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

    /** The fields of a fault that is no matter of one law. */
    static Map<String, Object> fault(String source, String message) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", source);
        fields.put("message", message);
        return fields;
    }

    /** Says of which world each event is. */
    private ServerEvents eventsOf(String world) {
        return new ServerEvents() {
            @Override
            public void happened(String event, Map<String, Object> fields) {
                Map<String, Object> all = new LinkedHashMap<>();
                all.put("world", world);
                all.putAll(fields);
                events.happened(event, all);
            }

            @Override
            public boolean wants(String event) {
                return events.wants(event);
            }
        };
    }

    /** The port that agents join at. */
    public int port() {
        return agents.address().getPort();
    }

    /** Begins to watch the laws folder, and says that the worlds are ready. */
    public void start() {
        worlds.forEach(world -> world.start(agents.address()));
        watchdog.start();
    }

    /** Runs the worlds until each has made its frames or was stopped, and reports on them. */
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

    /** One world on a thread of its own. */
    private final class Run {
        private final HostedWorld world;
        private final Thread thread;
        private @Nullable RunReport report;

        Run(HostedWorld world) {
            this.world = world;
            this.thread = Thread.ofPlatform().name("world " + world.name()).unstarted(this::run);
        }

        /** Whatever goes wrong in a world is no matter of the others. */
        private void run() {
            try {
                report = world.run();
            } catch (RuntimeException | Error failure) {
                world.tellProblem("world", "the world " + world.name() + " has ended: " + failure);
            } finally {
                agents.end(world.name());
            }
        }

        /** An interrupt of the waiting thread stops all worlds. */
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

    /** Ends {@link #run} after the worlds' frames. Any thread. */
    public void stop() {
        worlds.forEach(HostedWorld::stop);
    }

    /** After close: what the stores of the worlds lack, one message for each such store. */
    public List<String> unkept() {
        return worlds.stream().flatMap(world -> world.unkept().stream()).toList();
    }

    /** After close: what recordings lack. */
    public List<String> gaps() {
        return worlds.stream().flatMap(world -> world.gap().stream()).toList();
    }

    /** Says goodbye to agents, finishes pictures, frees everything. May be called twice. */
    @Override
    public void close() {
        closing.close();
    }
}
