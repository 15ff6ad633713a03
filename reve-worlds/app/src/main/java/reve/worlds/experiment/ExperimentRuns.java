// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.Experiment;
import reve.core.file.Problem;
import reve.worlds.server.LawPath;

import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicReferenceArray;
import java.util.function.Consumer;

/**
 * Runs all runs of an experiment on several threads. A result does not depend on the number of
 * threads, because runs share nothing.
 */
public final class ExperimentRuns {
    private final Experiment experiment;
    private final LawPath laws;
    private final Path agentLogs;
    private final Consumer<Problem> warnings;
    private final RunProgress progress;
    private final Set<ExperimentRun> active = ConcurrentHashMap.newKeySet();
    private volatile boolean stopped;

    /**
     * @param laws search path of laws
     * @param agentLogs folder for the output of agents' programs
     * @param warnings receives warnings about the worlds; called by several threads
     */
    public ExperimentRuns(
            Experiment experiment,
            LawPath laws,
            Path agentLogs,
            Consumer<Problem> warnings,
            RunProgress progress) {
        this.experiment = experiment;
        this.laws = laws;
        this.agentLogs = agentLogs;
        this.warnings = warnings;
        this.progress = progress;
    }

    /**
     * Runs all runs, and returns their results in order. Returns fewer results if {@link #stop} was
     * called.
     *
     * @param jobs number of runs at a time
     */
    public List<RunResult> run(int jobs) throws InterruptedException {
        var results = new AtomicReferenceArray<RunResult>(experiment.runs());
        var next = new AtomicInteger();
        List<Thread> threads = new ArrayList<>();
        for (int i = 0; i < Math.min(jobs, experiment.runs()); i++) {
            threads.add(
                    Thread.ofPlatform()
                            .name("run " + (i + 1))
                            .start(
                                    () -> {
                                        int index = next.getAndIncrement();
                                        while (index < experiment.runs() && !stopped) {
                                            run(index, results);
                                            index = next.getAndIncrement();
                                        }
                                    }));
        }
        for (Thread thread : threads) {
            thread.join();
        }
        List<RunResult> ended = new ArrayList<>();
        for (int i = 0; i < results.length(); i++) {
            RunResult result = results.get(i);
            if (result != null) {
                ended.add(result);
            }
        }
        return ended;
    }

    private void run(int index, AtomicReferenceArray<RunResult> results) {
        var run = new ExperimentRun(experiment, index, laws, agentLogs, warnings, progress);
        active.add(run);
        try {
            if (stopped) {
                run.stop();
            }
            RunResult result = run.run();
            if (!stopped) {
                results.set(index, result);
                progress.ended(result);
            }
        } finally {
            active.remove(run);
        }
    }

    /**
     * Ends all runs that are in progress after their current frames, and begins no further runs.
     * For any thread.
     */
    public void stop() {
        stopped = true;
        active.forEach(ExperimentRun::stop);
    }
}
