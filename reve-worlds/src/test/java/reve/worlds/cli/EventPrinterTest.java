package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.PrintWriter;
import java.io.StringWriter;
import java.util.List;
import java.util.Map;
import org.junit.jupiter.api.Test;

class EventPrinterTest {
    private static final List<String> EVENTS = List.of("ready", "joined", "acted", "rang", "late",
            "away", "back", "law-loaded", "fault", "left");

    /** The names of the events that are printed. */
    private static List<String> printed(Printed printed) {
        var out = new StringWriter();
        try (var printer = new EventPrinter(new PrintWriter(out), false, printed)) {
            EVENTS.forEach(event -> printer.happened(event, Map.of("frame", 1L)));
            EVENTS.forEach(event -> assertThat(printer.wants(event)).as(event)
                    .isEqualTo(printed.includes(event)));
        }
        return out.toString().lines().map(line -> line.split(" ")[0]).toList();
    }

    @Test
    void nothingThatAgentsDoInEveryFrameIsPrintedUnlessAskedFor() {
        assertThat(printed(Printed.NORMAL))
                .containsExactly("ready", "joined", "late", "away", "back", "law-loaded", "fault",
                        "left");
        assertThat(printed(Printed.ACTIONS)).isEqualTo(EVENTS);
    }

    @Test
    void quietlyOnlyWhatWentWrongIsPrinted() {
        assertThat(printed(Printed.LITTLE)).containsExactly("ready", "fault");
    }
}
