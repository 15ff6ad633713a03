// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import io.prometheus.metrics.core.metrics.CounterWithCallback;
import io.prometheus.metrics.core.metrics.GaugeWithCallback;
import io.prometheus.metrics.expositionformats.PrometheusTextFormatWriter;
import io.prometheus.metrics.model.registry.PrometheusRegistry;
import io.prometheus.metrics.model.snapshots.ClassicHistogramBuckets;
import io.prometheus.metrics.model.snapshots.HistogramSnapshot;
import io.prometheus.metrics.model.snapshots.Labels;
import io.prometheus.metrics.model.snapshots.MetricSnapshot;
import io.prometheus.metrics.model.snapshots.Unit;

import reve.core.agent.AgentServer;
import reve.core.agent.AgentStats;
import reve.core.agent.port.WorldPort;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.FrameProfile;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.lang.management.ManagementFactory;
import java.lang.management.MemoryUsage;
import java.util.ArrayList;
import java.util.List;
import java.util.Locale;
import java.util.Optional;
import java.util.function.ToDoubleFunction;
import java.util.function.ToLongFunction;

/**
 * The counters of a server, or of some of its worlds, in the text format of Prometheus. The
 * counters are read only when a client requests them, so frames take no longer. For any thread.
 */
final class Metrics {

    /** Content type of {@link #text}. */
    static final String TYPE = "text/plain; version=0.0.4; charset=utf-8";

    private final PrometheusRegistry registry = new PrometheusRegistry();
    private final List<WorldPort> worlds;

    /**
     * @param agents if empty, the text does not contain the counters of the whole server
     */
    Metrics(List<WorldPort> worlds, Optional<AgentServer> agents) {
        this.worlds = List.copyOf(worlds);
        perFrame("reve_frames", "Completed frames.", FrameProfile::frames);
        perFrame(
                "reve_overruns",
                "Frames that ended after the next one was due.",
                FrameProfile::overruns);
        perFrame(
                "reve_dropped_frames",
                "Frames by which the world gave up catching up with the clock.",
                FrameProfile::droppedFrames);
        phases();
        registry.register(this::frameTimes);
        perWorld("reve_paused", "1 while the world is paused.", loop -> loop.isPaused() ? 1 : 0);
        perWorld("reve_speed", "World time per time of the clock.", FrameLoop::speed);
        perWorld("reve_running", "1 while frames are made.", loop -> isRunning(loop) ? 1 : 0);
        agents.ifPresent(this::ofServer);
    }

    private void ofServer(AgentServer agents) {
        gauge(agents, "reve_connections", "Open connections.", AgentStats::open);
        gauge(agents, "reve_agents", "Agents in the worlds.", AgentStats::agents);
        counter(agents, "reve_joined", "Agents that have joined.", AgentStats::joined);
        counter(agents, "reve_messages", "Messages of clients.", AgentStats::lines);
        counter(agents, "reve_refused_messages", "Messages that were refused.", AgentStats::errors);
        counter(agents, "reve_perceptions", "Perceptions that were sent.", AgentStats::perceptions);
        counter(
                agents,
                "reve_acts_accepted",
                "Actions that took effect.",
                AgentStats::actsAccepted);
        counter(agents, "reve_acts_refused", "Actions that were refused.", AgentStats::actsRefused);
        counter(
                agents,
                "reve_disconnected",
                "Clients that the server disconnected.",
                AgentStats::cut);
        counter(
                agents,
                "reve_unrecorded",
                "Messages without an audit record.",
                AgentStats::unrecorded);
        heap();
    }

    /** Registers the sizes of the Java heap. */
    private void heap() {
        heap("reve_heap_max_bytes", "Size to which the Java heap may grow.", MemoryUsage::getMax);
        heap("reve_heap_used_bytes", "Size of the objects in the Java heap.", MemoryUsage::getUsed);
    }

    private void heap(String name, String help, ToLongFunction<MemoryUsage> value) {
        GaugeWithCallback.builder()
                .name(name)
                .help(help)
                .unit(Unit.BYTES)
                .callback(
                        callback ->
                                callback.call(
                                        value.applyAsLong(
                                                ManagementFactory.getMemoryMXBean()
                                                        .getHeapMemoryUsage())))
                .register(registry);
    }

    /** Returns whether a world's frame loop is running. A loop runs while a thread owns it. */
    static boolean isRunning(FrameLoop loop) {
        return loop.thread() != null && !loop.isStopped();
    }

    private void phases() {
        CounterWithCallback.builder()
                .name("reve_phase_seconds")
                .help("Time in each phase of the frame.")
                .unit(Unit.SECONDS)
                .labelNames("world", "phase")
                .callback(
                        callback -> {
                            for (WorldPort world : worlds) {
                                FrameProfile profile = world.loop().profile();
                                for (FramePhase phase : FramePhase.values()) {
                                    callback.call(
                                            profile.phaseNanoseconds().getOrDefault(phase, 0L)
                                                    / 1e9,
                                            world.world(),
                                            phase.name().toLowerCase(Locale.ROOT));
                                }
                            }
                        })
                .register(registry);
    }

    /** Returns the histogram of the durations of frames. */
    private MetricSnapshot frameTimes() {
        HistogramSnapshot.Builder histogram =
                HistogramSnapshot.builder()
                        .name("reve_frame_seconds")
                        .help("Durations of frames without waiting.")
                        .unit(Unit.SECONDS);
        for (WorldPort world : worlds) {
            FrameProfile profile = world.loop().profile();
            List<Double> bounds = new ArrayList<>(FrameProfile.TIME_BOUNDS_SECONDS);
            bounds.add(Double.POSITIVE_INFINITY);
            histogram.dataPoint(
                    HistogramSnapshot.HistogramDataPointSnapshot.builder()
                            .labels(Labels.of("world", world.world()))
                            .classicHistogramBuckets(
                                    ClassicHistogramBuckets.of(bounds, profile.framesByTime()))
                            .sum(profile.busyNanoseconds() / 1e9)
                            .build());
        }
        return histogram.build();
    }

    private void perFrame(String name, String help, ToLongFunction<FrameProfile> value) {
        CounterWithCallback.builder()
                .name(name)
                .help(help)
                .labelNames("world")
                .callback(
                        callback ->
                                worlds.forEach(
                                        world ->
                                                callback.call(
                                                        value.applyAsLong(world.loop().profile()),
                                                        world.world())))
                .register(registry);
    }

    private void perWorld(String name, String help, ToDoubleFunction<FrameLoop> value) {
        GaugeWithCallback.builder()
                .name(name)
                .help(help)
                .labelNames("world")
                .callback(
                        callback ->
                                worlds.forEach(
                                        world ->
                                                callback.call(
                                                        value.applyAsDouble(world.loop()),
                                                        world.world())))
                .register(registry);
    }

    private void gauge(
            AgentServer agents, String name, String help, ToLongFunction<AgentStats> value) {
        GaugeWithCallback.builder()
                .name(name)
                .help(help)
                .callback(callback -> callback.call(value.applyAsLong(agents.stats())))
                .register(registry);
    }

    private void counter(
            AgentServer agents, String name, String help, ToLongFunction<AgentStats> value) {
        CounterWithCallback.builder()
                .name(name)
                .help(help)
                .callback(callback -> callback.call(value.applyAsLong(agents.stats())))
                .register(registry);
    }

    /** Returns the present values of the counters as text. */
    byte[] text() {
        var out = new ByteArrayOutputStream();
        try {
            PrometheusTextFormatWriter.create().write(out, registry.scrape());
        } catch (IOException e) {
            throw new UncheckedIOException(e); // cannot happen: it writes to memory
        }
        return out.toByteArray();
    }
}
