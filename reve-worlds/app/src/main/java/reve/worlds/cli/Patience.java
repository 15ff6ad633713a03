// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import java.io.PrintStream;
import java.time.Duration;

/**
 * A notice on standard error about work that takes longer than two seconds and reports no progress.
 * One thread opens it before the work and closes it after the work.
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
                                        out.println(what + " ...");
                                    } catch (InterruptedException done) {
                                        // Interrupted: the work ended before the notice was due.
                                    }
                                });
    }

    @Override
    public void close() {
        watch.interrupt();
    }
}
