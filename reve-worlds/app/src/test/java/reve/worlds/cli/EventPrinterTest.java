// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.io.PrintWriter;
import java.io.StringWriter;
import java.io.Writer;
import java.nio.charset.StandardCharsets;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.concurrent.atomic.AtomicBoolean;

class EventPrinterTest {
    private static final List<String> EVENTS =
            List.of(
                    "ready",
                    "joined",
                    "acted",
                    "spoke",
                    "rang",
                    "late",
                    "away",
                    "back",
                    "law-loaded",
                    "fault",
                    "detached",
                    "removed",
                    "left");

    /** Returns the names of the events that were printed. */
    private static List<String> printed(Printed printed) {
        var out = new StringWriter();
        try (var printer =
                new EventPrinter(
                        new LinePrinter(out),
                        new PrintWriter(Writer.nullWriter()),
                        false,
                        printed)) {
            EVENTS.forEach(event -> printer.happened(event, Map.of("frame", 1L)));
            EVENTS.forEach(
                    event ->
                            assertThat(printer.wants(event))
                                    .as(event)
                                    .isEqualTo(printed.includes(event)));
        }
        return out.toString().lines().map(line -> line.split(" ")[0]).toList();
    }

    @Test
    void nothingThatAgentsDoInEveryFrameIsPrintedUnlessAskedFor() {
        assertThat(printed(Printed.NORMAL))
                .containsExactly(
                        "ready",
                        "joined",
                        "late",
                        "away",
                        "back",
                        "law-loaded",
                        "fault",
                        "removed",
                        "left");
        assertThat(printed(Printed.ACTIONS)).isEqualTo(EVENTS);
    }

    @Test
    void numbersAndHashesAreShortInTextAndCompleteInJson() {
        String hash = "0123456789abcdef".repeat(4);
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("time", 1.8166666666666667);
        fields.put("sha256", hash);
        fields.put("parameters", Map.of("c", List.of(0.333333333333, 3600.0)));
        fields.put("law", "drag");
        assertThat(line(fields, false))
                .isEqualTo(
                        "law-loaded time=1.817 sha256=0123456789ab… parameters={c=[0.3333, 3600]}"
                                + " law=drag");
        assertThat(line(fields, true)).contains("1.8166666666666667", hash, "0.333333333333");
    }

    private static String line(Map<String, Object> fields, boolean json) {
        var out = new StringWriter();
        try (var printer =
                new EventPrinter(
                        new LinePrinter(out),
                        new PrintWriter(Writer.nullWriter()),
                        json,
                        Printed.ACTIONS)) {
            printer.happened("law-loaded", fields);
        }
        return out.toString().strip();
    }

    @Test
    void aFieldOfAnEventDoesNotReplaceItsType() {
        var out = new StringWriter();
        try (var printer =
                new EventPrinter(
                        new LinePrinter(out),
                        new PrintWriter(Writer.nullWriter()),
                        true,
                        Printed.ACTIONS)) {
            printer.happened("rang", Map.of("event", "fault"));
        }
        assertThat(out.toString().strip()).isEqualTo("{\"event\":\"rang\"}");
    }

    @Test
    void eventsThatTheOutputDoesNotTakeAreCountedAndReportedOnce() {
        var file = new ByteArrayOutputStream();
        var full = new AtomicBoolean();
        var disk =
                new OutputStream() {
                    @Override
                    public void write(int one) throws IOException {
                        if (full.get()) {
                            throw new IOException("No space left on device");
                        }
                        file.write(one);
                    }
                };
        var messages = new StringWriter();
        var out = new LinePrinter(disk);
        var err = new PrintWriter(messages);
        tell(out, err, "ready");
        full.set(true);
        tell(out, err, "joined", "left");
        full.set(false);
        tell(out, err, "fault");

        assertThat(file.toString(StandardCharsets.UTF_8).lines())
                .containsExactly("ready frame=1", "", "fault frame=1");
        assertThat(messages.toString().lines())
                .containsExactly(
                        "reve: standard output cannot be written: No space left on device; the"
                                + " worlds continue, and events are lost until it can");
        assertThat(out.codeAfter(ExitCode.OK, err)).isEqualTo(ExitCode.FAILURE);
        assertThat(messages.toString()).contains("results are lost");
    }

    private static void tell(LinePrinter out, PrintWriter err, String... events) {
        try (var printer = new EventPrinter(out, err, false, Printed.ACTIONS)) {
            for (String event : events) {
                printer.happened(event, Map.of("frame", 1L));
            }
        }
    }

    @Test
    void quietlyOnlyWhatWentWrongIsPrinted() {
        assertThat(printed(Printed.LITTLE)).containsExactly("ready", "fault");
    }
}
