// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.Experiment;
import reve.core.file.Measure;
import reve.core.file.Problem;
import reve.core.file.RunPlan;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.core.world.WorldEvent;
import reve.pe.PhysicsException;
import reve.pe.adapter.LawLibrary;
import reve.worlds.journal.SqliteStore;
import reve.worlds.server.LawPath;
import reve.worlds.server.LawSchedule;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.Simulation;
import reve.worlds.server.WorldPlan;
import reve.worlds.server.WorldServer;

import java.io.IOException;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Collection;
import java.util.HashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.function.Consumer;
import java.util.stream.Collectors;

/**
 * One run of an experiment. For one thread, except {@link #stop}, which may be called on any
 * thread.
 */
final class ExperimentRun {
    private final Experiment experiment;
    private final int index;
    private final LawPath laws;
    private final Path agentLogs;
    private final Consumer<Problem> warnings;
    private final RunProgress progress;
    private final RunJournal journal;
    private volatile boolean stopped;
    private volatile Runnable stop = () -> {};

    /**
     * @param index number of the run, from 0
     * @param laws search path of laws
     * @param agentLogs folder for the output of agents' programs
     * @param warnings receives warnings about the run's world
     * @param journal receives the files and laws on which the run depends
     */
    ExperimentRun(
            Experiment experiment,
            int index,
            LawPath laws,
            Path agentLogs,
            Consumer<Problem> warnings,
            RunProgress progress,
            RunJournal journal) {
        this.experiment = experiment;
        this.index = index;
        this.laws = laws;
        this.agentLogs = agentLogs;
        this.warnings = warnings;
        this.progress = progress;
        this.journal = journal;
    }

    /** Ends the run after its current frame. */
    void stop() {
        stopped = true;
        stop.run();
    }

    /**
     * Runs the world. A failure of the run becomes part of the result.
     *
     * @throws IOException if the journal cannot be written
     */
    RunResult run() throws IOException {
        RunPlan plan;
        try {
            plan = experiment.plan(index);
        } catch (WorldFileException invalid) {
            return failed(
                    invalid.problems().stream()
                            .map(Problem::toString)
                            .collect(Collectors.joining("; ")));
        } catch (RuntimeException failure) {
            return failed(failure);
        }
        journal.uses(plan);
        try {
            return plan.agents().isEmpty() ? alone(plan) : withAgents(plan);
        } catch (IOException | RuntimeException failure) {
            return failed(failure);
        }
    }

    private RunResult failed(Exception failure) {
        return failed(failure.getMessage() == null ? failure.toString() : failure.getMessage());
    }

    private RunResult failed(String message) {
        return RunResult.failed(experiment.point(index), message, experiment.measures().size());
    }

    private RunResult alone(RunPlan plan) {
        try (var simulation =
                        new Simulation(
                                plan.world(),
                                Pacing.FAST,
                                laws.forWorld(experiment.worldFolder()));
                var schedule = new LawSchedule(simulation, plan.steps())) {
            simulation.usePluginListeners();
            Sampler sampler = observe(simulation, plan);
            stopWith(simulation.loop()::stop);
            simulation.loop().run(plan.frames());
            return result(plan, simulation, sampler, schedule, Optional.empty());
        }
    }

    private RunResult withAgents(RunPlan plan) throws IOException {
        var deadline = Duration.ofNanos(Math.round(experiment.deadlineSeconds() * 1e9));
        WorldServer[] served = new WorldServer[1];
        try (var agents = new AgentPrograms(plan, experiment.folder(), agentLogs, deadline);
                var server =
                        new WorldServer(
                                List.of(worldPlan(plan)),
                                Pacing.FAST,
                                agents.config(),
                                Optional.empty(),
                                (event, fields) -> agents.happened(event, fields, served[0]))) {
            served[0] = server;
            Simulation simulation = server.simulations().getFirst();
            RunResult result;
            try (var schedule = new LawSchedule(simulation, plan.steps())) {
                Sampler sampler = observe(simulation, plan);
                simulation.onPublish(
                        "agents",
                        frame -> {
                            if (frame.frame() == 1) {
                                agents.begun(server);
                            }
                        });
                stopWith(server::stop);
                agents.start(server);
                server.run();
                simulation.world().guard().claim();
                result = result(plan, simulation, sampler, schedule, agents.failure());
            }
            return result;
        }
    }

    private WorldPlan worldPlan(RunPlan plan) {
        Path folder = experiment.worldFolder();
        return new WorldPlan(
                plan.world(),
                plan.frames(),
                new Persistence(
                        folder,
                        Optional.empty(),
                        Optional.empty(),
                        Optional.empty(),
                        1,
                        SqliteStore.Durability.NORMAL),
                new Pictures(agentLogs, List.of()),
                laws.forWorld(folder));
    }

    private Sampler observe(Simulation simulation, RunPlan plan) {
        simulation.warnings(true).forEach(warnings);
        var sampler = new Sampler(simulation, plan, experiment.every());
        simulation.onPublish("measures", sampler);
        double part = 1.0 / plan.frames();
        simulation.onPublish(
                "progress",
                frame -> {
                    if (frame.frame() > 0) {
                        progress.advanced(part);
                    }
                });
        return sampler;
    }

    private void stopWith(Runnable action) {
        stop = action;
        if (stopped) {
            action.run();
        }
    }

    private RunResult result(
            RunPlan plan,
            Simulation simulation,
            Sampler sampler,
            LawSchedule schedule,
            Optional<String> agentFailure) {
        long frames = simulation.loop().frame();
        Optional<String> failure =
                schedule.failure()
                        .map(PhysicsException::getMessage)
                        .or(() -> agentFailure)
                        .or(() -> fault(simulation))
                        .or(
                                () ->
                                        frames == plan.frames()
                                                ? Optional.empty()
                                                : Optional.of(
                                                        "ended after "
                                                                + frames
                                                                + " of "
                                                                + plan.frames()
                                                                + " frames"));
        List<Optional<Object>> values = new ArrayList<>();
        List<Optional<Double>> expected = new ArrayList<>();
        List<String> notes = new ArrayList<>(sampler.notes());
        for (int i = 0; i < plan.measures().size(); i++) {
            Measure measure = plan.measures().get(i);
            Optional<Object> value =
                    failure.isPresent()
                            ? Optional.empty()
                            : Summary.of(measure.take(), sampler.samples(), i);
            if (measure.take() == Measure.Take.PERIOD && value.isEmpty() && failure.isEmpty()) {
                notes.add(
                        measure.name()
                                + " has no period: it passes through 0 from below less than twice");
            }
            values.add(value);
            OptionalDouble right = measure.expected();
            expected.add(right.isPresent() ? Optional.of(right.getAsDouble()) : Optional.empty());
        }
        Map<String, String> libraries = new HashMap<>();
        Collection<LawLibrary> loaded = simulation.physics().laws().libraries();
        loaded.forEach(library -> libraries.put(library.name(), library.sha256()));
        Optional<String> outside =
                failure.isPresent() ? Optional.empty() : outside(plan, values, expected);
        return new RunResult(
                plan.point(),
                failure.isPresent()
                        ? RunResult.State.FAILED
                        : outside.isPresent() ? RunResult.State.OUTSIDE : RunResult.State.OK,
                failure.or(() -> outside).orElse(""),
                frames,
                failure.isPresent()
                        ? ""
                        : String.format(Locale.ROOT, "%016x", simulation.physics().stateHash()),
                sampler.samples(),
                values,
                expected,
                notes,
                libraries);
    }

    private static Optional<String> fault(Simulation simulation) {
        List<WorldEvent> faults = simulation.events().faults();
        return faults.isEmpty()
                ? Optional.empty()
                : Optional.of(
                        "fault in frame "
                                + faults.getFirst().frame()
                                + ": "
                                + faults.getFirst().fields().get("message"));
    }

    /**
     * Returns a message about the first value that is outside of its tolerance; empty if there is
     * none.
     */
    private static Optional<String> outside(
            RunPlan plan, List<Optional<Object>> values, List<Optional<Double>> expected) {
        for (int i = 0; i < values.size(); i++) {
            Measure measure = plan.measures().get(i);
            if (measure.tolerance().isEmpty()) {
                continue;
            }
            double right = expected.get(i).orElseThrow();
            if (!(values.get(i).orElse(null) instanceof Double value)) {
                return Optional.of(measure.name() + " has no value, expected " + right);
            }
            double error = RunResult.relativeError(value, right);
            if (!(Math.abs(error) <= measure.tolerance().getAsDouble())) {
                return Optional.of(
                        measure.name()
                                + " is "
                                + value
                                + ", expected "
                                + right
                                + ": an error of "
                                + error
                                + ", accepted is "
                                + measure.tolerance().getAsDouble());
            }
        }
        return Optional.empty();
    }
}
