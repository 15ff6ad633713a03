// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import java.io.PrintStream;
import java.util.Locale;

/**
 * A progress line on standard error for a long run, every two seconds, from the third second on.
 * Used by one thread. On a terminal the line is rewritten in place; other outputs receive appended
 * lines.
 */
final class Progress {
    private static final long FIRST_NANOS = 2_000_000_000L;
    private static final long EVERY_NANOS = 2_000_000_000L;

    private final PrintStream out;
    private final boolean terminal;
    private final long total;
    private final long startNanos = System.nanoTime();
    private long nextNanos = startNanos + FIRST_NANOS;
    private boolean shown;

    /**
     * @param total frames of the whole run; 0 if the run has no end
     */
    Progress(PrintStream out, long total) {
        this.out = out;
        this.terminal = System.console() != null && System.console().isTerminal();
        this.total = total;
    }

    /** Prints the progress if the next line is due. May be called in every frame. */
    void at(long frame, double worldSeconds) {
        long now = System.nanoTime();
        if (now < nextNanos) {
            return;
        }
        nextNanos = now + EVERY_NANOS;
        shown = true;
        double factor = worldSeconds / ((now - startNanos) * 1e-9);
        String part =
                total == 0
                        ? ""
                        : String.format(Locale.ROOT, " of %d (%d %%)", total, 100 * frame / total);
        String line =
                String.format(
                        Locale.ROOT,
                        "frame %d%s, %.2f s of world time, %.2f x real time",
                        frame,
                        part,
                        worldSeconds,
                        factor);
        out.print(terminal ? "\r" + line + "   " : line + System.lineSeparator());
        out.flush();
    }

    /** Ends the line that was rewritten in place, if there is one. */
    void done() {
        if (shown && terminal) {
            out.println();
        }
    }
}
