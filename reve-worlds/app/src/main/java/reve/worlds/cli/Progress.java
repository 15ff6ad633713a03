// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import java.io.PrintStream;
import java.util.Locale;
import java.util.function.LongSupplier;

/**
 * A progress line on standard error for a long run. It is printed every two seconds, beginning with
 * the third second. It shows the remaining time if the end of the run is known. The line is
 * rewritten in place on a terminal. Other outputs receive one line after another. For one thread.
 */
final class Progress {
    private static final long EVERY_NANOS = 2_000_000_000L;

    /** Fraction of the work that must be done before the remaining time is estimated. */
    private static final double LEAST_PART = 0.02;

    private final PrintStream out;
    private final boolean terminal;
    private final long total;
    private final LongSupplier clock;
    private final long startNanos;
    private long nextNanos;
    private int length;

    /**
     * @param total frames of the whole run; 0 if their number is unknown
     */
    Progress(PrintStream out, long total) {
        this(
                out,
                System.console() != null && System.console().isTerminal(),
                total,
                System::nanoTime);
    }

    /**
     * @param clock returns the time [ns]
     */
    Progress(PrintStream out, boolean terminal, long total, LongSupplier clock) {
        this.out = out;
        this.terminal = terminal;
        this.total = total;
        this.clock = clock;
        this.startNanos = clock.getAsLong();
        this.nextNanos = startNanos + EVERY_NANOS;
    }

    /** Prints the progress of a run if the next line is due. May be called in every frame. */
    void at(long frame, double worldSeconds) {
        long now = clock.getAsLong();
        if (now < nextNanos) {
            return;
        }
        double seconds = (now - startNanos) * 1e-9;
        String whole =
                total == 0
                        ? ""
                        : String.format(Locale.ROOT, " of %d (%d %%)", total, 100 * frame / total);
        show(
                now,
                String.format(
                        Locale.ROOT,
                        "frame %d%s, %.2f s of world time, %.2f x real time",
                        frame,
                        whole,
                        worldSeconds,
                        worldSeconds / seconds),
                total == 0 ? 0 : (double) frame / total);
    }

    /**
     * Prints the progress of other work if the next line is due. May be called in every frame.
     *
     * @param part the fraction of the work that is done, from 0 to 1
     */
    void at(String what, double part) {
        long now = clock.getAsLong();
        if (now >= nextNanos) {
            show(now, String.format(Locale.ROOT, "%s, %d %%", what, (int) (100 * part)), part);
        }
    }

    private void show(long now, String line, double part) {
        nextNanos = now + EVERY_NANOS;
        double left = (now - startNanos) * 1e-9 * (1 - part) / part;
        String all =
                part < LEAST_PART || part > 1 ? line : line + ", about " + duration(left) + " left";
        String rest = " ".repeat(Math.max(0, length - all.length()));
        length = all.length();
        out.print(terminal ? "\r" + all + rest : all + System.lineSeparator());
        out.flush();
    }

    /** Returns a time in words: {@code 8 s}, {@code 3 min 20 s}, {@code 2 h 5 min}. */
    static String duration(double seconds) {
        long whole = Math.round(seconds);
        if (whole < 60) {
            return whole + " s";
        }
        if (whole < 3600) {
            return whole / 60 + " min " + whole % 60 + " s";
        }
        return whole / 3600 + " h " + whole % 3600 / 60 + " min";
    }

    /** Ends the line that was rewritten in place, if there is one. */
    void done() {
        if (length > 0 && terminal) {
            out.println();
            length = 0;
        }
    }
}
