package reve.worlds.cli;

import java.io.OutputStreamWriter;
import java.io.PrintStream;
import java.io.PrintWriter;
import java.io.Writer;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.Locale;
import reve.core.text.Visible;

/**
 * Prints for people. A {@code println} is one line whatever text is in it, and so is each argument
 * of a {@code printf}: their control characters are escaped. {@code print} passes text unchanged,
 * for layouts of our own such as help and JSON documents.
 */
public final class LinePrinter extends PrintWriter {

    /** Prints UTF-8, and flushes after each line. */
    public LinePrinter(PrintStream stream) {
        this(new OutputStreamWriter(stream, StandardCharsets.UTF_8));
    }

    LinePrinter(Writer out) {
        super(out, true);
    }

    /**
     * Prints a message that may have several lines. All but the first are indented, so that none
     * of them can pass for an event or a log line.
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
