// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import org.jspecify.annotations.Nullable;

import reve.core.file.Experiment;
import reve.core.file.Problem;
import reve.worlds.server.LawPath;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicReference;
import java.util.concurrent.atomic.AtomicReferenceArray;
import java.util.function.Consumer;

/**
 * All runs of an experiment, executed on several threads. The results do not depend on the number
 * of threads, because the runs share no state.
 */
public final class ExperimentRuns {
    private final Experiment experiment;
    private final LawPath laws;
    private final Path agentLogs;
    private final Consumer<Problem> warnings;
    private final RunProgress progress;
    private final RunJournal journal;
    private final Set<ExperimentRun> active = ConcurrentHashMap.newKeySet();
    private final AtomicReference<@Nullable IOException> failure = new AtomicReference<>();
    private volatile boolean stopped;

    /**
     * @param laws search path of laws
     * @param agentLogs folder for the output of agents' programs
     * @param warnings receives warnings about the worlds; called by several threads
     * @param journal contains the results of an earlier process, and receives those of this one
     */
    public ExperimentRuns(
            Experiment experiment,
            LawPath laws,
            Path agentLogs,
            Consumer<Problem> warnings,
            RunProgress progress,
            RunJournal journal) {
        this.experiment = experiment;
        this.laws = laws;
        this.agentLogs = agentLogs;
        this.warnings = warnings;
        this.progress = progress;
        this.journal = journal;
    }

    /**
     * Runs all runs that the journal does not contain, and returns the results of all runs in
     * order. Returns fewer results if {@link #stop} was called.
     *
     * @param jobs number of runs at a time
     * @throws IOException if the journal cannot be written
     */
    public List<RunResult> run(int jobs) throws InterruptedException, IOException {
        var results = new AtomicReferenceArray<RunResult>(experiment.runs());
        journal.earlier().forEach(results::set);
        int left = experiment.runs() - journal.earlier().size();
        var next = new AtomicInteger();
        List<Thread> threads = new ArrayList<>();
        for (int i = 0; i < Math.min(jobs, left); i++) {
            threads.add(
                    Thread.ofPlatform()
                            .name("run " + (i + 1))
                            .start(
                                    () -> {
                                        int index = next.getAndIncrement();
                                        while (index < experiment.runs() && !stopped) {
                                            if (results.get(index) == null) {
                                                run(index, results);
                                            }
                                            index = next.getAndIncrement();
                                        }
                                    }));
        }
        for (Thread thread : threads) {
            thread.join();
        }
        IOException unwritten = failure.get();
        if (unwritten != null) {
            throw unwritten;
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
        var run =
                new ExperimentRun(experiment, index, laws, agentLogs, warnings, progress, journal);
        active.add(run);
        try {
            if (stopped) {
                run.stop();
            }
            RunResult result = run.run();
            if (!stopped) {
                journal.add(result);
                results.set(index, result);
                progress.ended(result);
            }
        } catch (IOException unwritten) {
            failure.compareAndSet(null, unwritten);
            stop();
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
