// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import ch.qos.logback.classic.pattern.ThrowableHandlingConverter;
import ch.qos.logback.classic.spi.ILoggingEvent;
import ch.qos.logback.classic.spi.IThrowableProxy;
import ch.qos.logback.classic.spi.StackTraceElementProxy;

import reve.core.text.Visible;

/**
 * Converter of {@code %text} in a log pattern. It prints the message, then each exception with the
 * location that threw it. The result is always one line.
 */
public final class LogText extends ThrowableHandlingConverter {
    private static final int CAUSES_SHOWN = 8;

    @Override
    public String convert(ILoggingEvent event) {
        var text = new StringBuilder(String.valueOf(event.getFormattedMessage()));
        IThrowableProxy thrown = event.getThrowableProxy();
        for (int i = 0; thrown != null && i < CAUSES_SHOWN; i++) {
            text.append(i == 0 ? ": " : "; caused by ")
                    .append(thrown.getClassName())
                    .append(": ")
                    .append(thrown.getMessage());
            StackTraceElementProxy[] trace = thrown.getStackTraceElementProxyArray();
            if (trace.length > 0) {
                text.append(' ').append(trace[0].getSTEAsString());
            }
            thrown = thrown.getCause();
        }
        return Visible.line(text.toString());
    }
}
