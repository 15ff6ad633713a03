// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.core.text.Visible;

import java.io.OutputStream;
import java.io.OutputStreamWriter;
import java.io.PrintWriter;
import java.io.Writer;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.Locale;

/**
 * Prints for people. A {@code println} is one line whatever text is in it, and so is each argument
 * of a {@code printf}: their control characters are escaped. {@code print} passes text unchanged,
 * for layouts of our own such as help and JSON documents.
 */
public final class LinePrinter extends PrintWriter {

    private final WatchedOutput watched;
    private boolean lossTold;

    /** Prints UTF-8, and flushes after each line. */
    public LinePrinter(OutputStream stream) {
        this(new WatchedOutput(stream));
    }

    private LinePrinter(WatchedOutput watched) {
        super(new OutputStreamWriter(watched, StandardCharsets.UTF_8), true);
        this.watched = watched;
    }

    LinePrinter(Writer out) {
        super(out, true);
        watched = new WatchedOutput(OutputStream.nullOutputStream());
    }

    /** Where it prints, unless it prints to a writer. */
    WatchedOutput watched() {
        return watched;
    }

    /**
     * The exit code of a command that has printed its results. A full standard output is reported
     * once; a closed pipe is not, because whoever reads wants no more.
     *
     * @param code of the command apart from that
     */
    public synchronized int codeAfter(int code, PrintWriter err) {
        flush();
        if (watched.reason().isEmpty()) {
            return code;
        }
        if (!watched.isClosedPipe() && !lossTold) {
            lossTold = true;
            message(
                    err,
                    "reve: standard output could not be written: "
                            + watched.reason().orElseThrow()
                            + "; results are lost");
        }
        if (code != ExitCode.OK) {
            return code;
        }
        return watched.isClosedPipe() ? ExitCode.CLOSED_PIPE : ExitCode.FAILURE;
    }

    /**
     * Prints a message that may have several lines. All but the first are indented, so that none of
     * them can pass for an event or a log line.
     */
    public static void message(PrintWriter out, String message) {
        String indent = "";
        for (String line : message.lines().toList()) {
            out.println(indent + line);
            indent = "  ";
        }
    }

    @Override
    public void println(String text) {
        super.println(Visible.line(String.valueOf(text)));
    }

    @Override
    public void println(Object value) {
        println(String.valueOf(value));
    }

    @Override
    public PrintWriter format(String format, Object... arguments) {
        return super.format(format, visible(arguments));
    }

    @Override
    public PrintWriter format(Locale locale, String format, Object... arguments) {
        return super.format(locale, format, visible(arguments));
    }

    private static Object[] visible(Object... arguments) {
        return Arrays.stream(arguments)
                .map(each -> each instanceof Number ? each : Visible.line(String.valueOf(each)))
                .toArray();
    }
}
