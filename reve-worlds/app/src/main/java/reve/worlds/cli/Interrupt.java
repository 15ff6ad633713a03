// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.Model.CommandSpec;

import reve.core.disk.PartFile;

import java.time.Duration;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;

/**
 * Handling of Ctrl-C and SIGTERM for a long command. The command stops after the signal, and prints
 * its report as usual. Then the process exits with the command's exit code. A command that is still
 * starting exits at once. The command's thread opens this object before the command runs, and
 * closes it after the report is printed.
 */
final class Interrupt implements AutoCloseable {
    private static final Duration PATIENCE = Duration.ofSeconds(10);

    private final CountDownLatch reported = new CountDownLatch(1);
    private final Thread hook;
    private final CommandSpec spec;
    private volatile @Nullable Runnable stop;
    private final int codeBefore;
    private volatile int code = ExitCode.FAILURE;
    private volatile boolean asked;
    private volatile Duration patience = PATIENCE;

    /**
     * @param codeBefore exit code of a command that is interrupted before it has begun its work
     */
    Interrupt(CommandSpec spec, int codeBefore) {
        this.spec = spec;
        this.codeBefore = codeBefore;
        PartFile.leave(true);
        hook = new Thread(this::end, "interrupt");
        Runtime.getRuntime().addShutdownHook(hook);
    }

    /**
     * Registers the action that makes the command stop.
     *
     * @param asks the action; called on another thread
     */
    void stopWith(Runnable asks) {
        stopWith(asks, PATIENCE);
    }

    /**
     * Registers the action that makes the command stop.
     *
     * @param asks the action; called on another thread
     * @param limit time after which the process ends without a report
     */
    void stopWith(Runnable asks, Duration limit) {
        patience = limit;
        stop = asks;
    }

    /** Returns whether Ctrl-C or SIGTERM has asked the command to stop. */
    boolean wasAsked() {
        return asked;
    }

    /**
     * Sets the exit code of a command that was interrupted before its work was complete. Returns
     * this code.
     */
    int endsCut() {
        code = ExitCode.INTERRUPTED;
        return code;
    }

    /**
     * Returns the command's exit code for success or failure. The code does not depend on whether
     * the command was interrupted.
     */
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
            // The command was still starting, so no frame was made.
            halt(codeBefore);
            return;
        }
        asked = true;
        asks.run();
        try {
            if (!reported.await(patience.toMillis(), TimeUnit.MILLISECONDS)) {
                System.err.println(
                        "reve: asked to stop "
                                + patience.toSeconds()
                                + " s ago and still busy, perhaps with a law that never returns, or"
                                + " with a disk that does not answer; ended without a report");
                halt(ExitCode.FAILURE);
            }
        } catch (InterruptedException impatient) {
            Thread.currentThread().interrupt();
        }
        // The process exits with the command's code, not with 128 + signal, because the command
        // ended as the user requested.
        halt(code);
    }

    private static void halt(int with) {
        PartFile.removeUnfinished();
        Runtime.getRuntime().halt(with);
    }

    @Override
    public void close() {
        System.err.flush();
        reported.countDown();
        PartFile.leave(false);
        try {
            Runtime.getRuntime().removeShutdownHook(hook);
        } catch (IllegalStateException ending) {
            // The exception is ignored. It means that the JVM is already shutting down, and the
            // shutdown hook then sets the exit code.
        }
    }
}
