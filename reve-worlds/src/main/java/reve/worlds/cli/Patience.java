// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import java.io.PrintStream;
import java.time.Duration;

/**
 * Says on standard error what is going on, if that takes longer than two seconds and has no
 * progress to show. Open around the work; used by one thread.
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
                                        // It did not take that long.
                                    }
                                });
    }

    @Override
    public void close() {
        watch.interrupt();
    }
}
