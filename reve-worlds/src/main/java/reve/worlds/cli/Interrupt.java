// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.Model.CommandSpec;

import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;

/**
 * What Ctrl-C and SIGTERM do to a command that runs for long: it is asked to stop, reports as
 * usual, and the process exits with the code of its report. While it still starts, the process
 * exits at once. Open around the command; close is called by the command's own thread when the
 * report is out.
 */
final class Interrupt implements AutoCloseable {
    private static final long PATIENCE_SECONDS = 10;

    private final CountDownLatch reported = new CountDownLatch(1);
    private final Thread hook;
    private final CommandSpec spec;
    private volatile @Nullable Runnable stop;
    private volatile int code = ExitCode.FAILURE;

    Interrupt(CommandSpec spec) {
        this.spec = spec;
        hook = new Thread(this::end, "interrupt");
        Runtime.getRuntime().addShutdownHook(hook);
    }

    /**
     * @param asks the command to end soon, from now on; called on another thread
     */
    void stopWith(Runnable asks) {
        stop = asks;
    }

    /** Returns the exit code of the command, which holds for an interrupted one, too. */
    int endsWith(boolean failed) {
        code =
                ((LinePrinter) spec.commandLine().getOut())
                        .codeAfter(
                                failed ? ExitCode.FAILURE : ExitCode.OK,
                                spec.commandLine().getErr());
        return code;
    }

    private void end() {
        Runnable asks = stop;
        if (asks == null) {
            Runtime.getRuntime().halt(ExitCode.OK); // no frame has been made
            return;
        }
        asks.run();
        try {
            if (!reported.await(PATIENCE_SECONDS, TimeUnit.SECONDS)) {
                System.err.println(
                        "reve: asked to stop "
                                + PATIENCE_SECONDS
                                + " s ago and still busy, perhaps with a law that never returns; "
                                + "ended without a report");
                Runtime.getRuntime().halt(ExitCode.FAILURE);
            }
        } catch (InterruptedException impatient) {
            Thread.currentThread().interrupt();
        }
        // Not with 128 + signal: the command did all that it was asked to do.
        Runtime.getRuntime().halt(code);
    }

    @Override
    public void close() {
        System.err.flush();
        reported.countDown();
        try {
            Runtime.getRuntime().removeShutdownHook(hook);
        } catch (IllegalStateException ending) {
            // The process is ending and the hook will see to it.
        }
    }
}
