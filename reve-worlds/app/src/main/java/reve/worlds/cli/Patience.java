// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.core.text.Visible;

import java.io.PrintStream;
import java.time.Duration;

/**
 * A notice on standard error for work that reports no progress. It appears if the work takes longer
 * than two seconds. The thread that does the work opens this object before the work and closes it
 * after the work.
 */
final class Patience implements AutoCloseable {
    private static final Duration UNTIL_TOLD = Duration.ofSeconds(2);

    private final Thread watch;

    Patience(PrintStream out, String what) {
        watch =
                Thread.ofVirtual()
                        .start(
                                () -> {
                                    try {
                                        Thread.sleep(UNTIL_TOLD);
                                        out.println(Visible.line(what) + " ...");
                                    } catch (InterruptedException done) {
                                        // The thread ends without a notice, because an interrupt
                                        // means that the work ended before the notice was due.
                                    }
                                });
    }

    @Override
    public void close() {
        watch.interrupt();
    }
}
