// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.core.text.Visible;

import java.io.OutputStream;
import java.io.OutputStreamWriter;
import java.io.PrintWriter;
import java.io.Writer;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.List;
import java.util.Locale;

/**
 * A printer of lines for people. {@code println} prints exactly one line. Each argument of {@code
 * printf} stays on its line, because control characters are escaped. {@code print} writes text
 * unchanged, for layouts such as help and JSON documents.
 */
public final class LinePrinter extends PrintWriter {

    private final WatchedOutput watched;
    private boolean lossTold;

    /** Creates a printer that writes UTF-8 and flushes after each line. */
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

    /**
     * Returns the standard output to which this printer writes. A printer that writes elsewhere has
     * none.
     */
    WatchedOutput watched() {
        return watched;
    }

    /**
     * Returns the exit code of a command that has printed its results. Reports once if output was
     * lost because the disk is full. Does not report a closed pipe, because the reader closed it on
     * purpose.
     *
     * @param code exit code of the command if no output was lost
     */
    public synchronized int codeAfter(int code, PrintWriter err) {
        flush();
        if (watched.reason().isEmpty()) {
            return code;
        }
        if (!watched.isClosedPipe() && !lossTold) {
            lossTold = true;
            err.println(
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
     * Prints a message of one or more lines. All lines except the first are indented, so that
     * foreign text cannot look like an event or a log line. A line end within a line is escaped.
     */
    static void message(PrintWriter out, List<String> lines) {
        String indent = "";
        for (String line : lines) {
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
