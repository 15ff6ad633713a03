// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.core.text.Visible;
import reve.worlds.experiment.RunProgress;
import reve.worlds.experiment.RunResult;

import java.io.PrintStream;
import java.util.Locale;
import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.atomic.DoubleAdder;
import java.util.function.LongSupplier;

/**
 * A progress line on standard error for an experiment. It is printed every two seconds and shows
 * the remaining time. A separate line names each run that has failed. The progress line is
 * rewritten in place on a terminal.
 */
final class ExperimentProgress implements RunProgress {
    private static final long EVERY_NANOS = 2_000_000_000L;

    /** Fraction of all runs that must be done before the remaining time is estimated. */
    private static final double LEAST_PART = 0.02;

    private final PrintStream out;
    private final boolean terminal;
    private final int runs;
    private final LongSupplier clock;
    private final long startNanos;
    private final AtomicLong nextNanos;
    private final DoubleAdder done = new DoubleAdder();
    private int ended;
    private int resumed;
    private boolean shown;

    ExperimentProgress(PrintStream out, int runs) {
        this(
                out,
                System.console() != null && System.console().isTerminal(),
                runs,
                System::nanoTime);
    }

    /**
     * @param clock returns the time [ns]
     */
    ExperimentProgress(PrintStream out, boolean terminal, int runs, LongSupplier clock) {
        this.out = out;
        this.terminal = terminal;
        this.runs = runs;
        this.clock = clock;
        this.startNanos = clock.getAsLong();
        this.nextNanos = new AtomicLong(startNanos + EVERY_NANOS);
    }

    /** Counts runs that an earlier process has made. They do not change the remaining time. */
    synchronized void resumed(int earlier) {
        resumed = earlier;
        ended += earlier;
    }

    @Override
    public void advanced(double part) {
        done.add(part);
        long now = clock.getAsLong();
        long next = nextNanos.get();
        if (now >= next && nextNanos.compareAndSet(next, now + EVERY_NANOS)) {
            show(now);
        }
    }

    private synchronized void show(long now) {
        double own = Math.min(1, done.sum() / (runs - resumed));
        double part = (resumed + own * (runs - resumed)) / runs;
        double left = (now - startNanos) * 1e-9 * (1 - own) / own;
        String line =
                String.format(
                        Locale.ROOT,
                        "%d of %d runs, %.0f %%%s",
                        ended,
                        runs,
                        Math.floor(100 * part),
                        own < LEAST_PART ? "" : ", about " + Progress.duration(left) + " left");
        out.print(terminal ? "\r" + line + "   " : line + System.lineSeparator());
        out.flush();
        shown = terminal;
    }

    @Override
    public synchronized void ended(RunResult result) {
        ended++;
        if (result.state() == RunResult.State.FAILED) {
            endLine();
            out.println(
                    "reve: run "
                            + result.point().number()
                            + " failed: "
                            + Visible.line(result.message()));
            out.flush();
        }
    }

    /** Ends the line that was rewritten in place, if there is one. */
    synchronized void endLine() {
        if (shown) {
            out.println();
            shown = false;
        }
    }
}
