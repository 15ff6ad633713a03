// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.pe.LedgerLine;

import java.io.PrintWriter;
import java.io.StringWriter;
import java.util.List;

class LedgerReportTest {
    private static final LedgerLine NOBODY = line("client", false, 0, 0);

    @Test
    void theTableMarksWhatDriftsAndLeavesOutWhoDidNothing() {
        LedgerLine spring =
                new LedgerLine(
                        "spring",
                        true,
                        List.of(1e-15, 0.0, 0.0),
                        List.of(0.0, 0.0, 0.0),
                        -1.5,
                        true,
                        2,
                        3.25,
                        0,
                        0);
        LedgerLine leak = line("leak", true, 12.345678, 2);
        LedgerLine total = line("total", false, 12.3, 0.5);
        StringWriter text = new StringWriter();
        PrintWriter out = new PrintWriter(text);
        new LedgerReport(List.of(spring, leak, NOBODY, total)).print(out);
        out.flush();
        assertThat(text.toString().lines())
                .containsExactly(
                        "  ledger  momentum [kg*m/s]  angular momentum [kg*m^2/s]  work [J] "
                                + " potential [J]  work + potential [J]",
                        "  spring  (0 0 0)            (0 0 0)                      -1.5      1.25  "
                                + "         -0.25",
                        "  leak    (12.35 0 0) *      (0 0 0)                      2         -     "
                                + "         2 *",
                        "  total   (12.3 0 0)         (0 0 0)                      0.5       -     "
                                + "         0.5");
    }

    @Test
    void numbersAreWrittenAsByC() {
        assertThat(List.of(0.0001, 0.00001234567, 9999.4, 9999.6, -123456.0, 1e-300, 0.5, 100.0))
                .extracting(value -> LedgerReport.number(value, 0))
                .containsExactly(
                        "0.0001",
                        "1.235e-05",
                        "9999",
                        "1e+04",
                        "-1.235e+05",
                        "1e-300",
                        "0.5",
                        "100");
        assertThat(LedgerReport.number(-1e-13, 1)).isEqualTo("0");
    }

    private static LedgerLine line(String name, boolean law, double momentum, double energy) {
        return new LedgerLine(
                name,
                law,
                List.of(momentum, 0.0, 0.0),
                List.of(0.0, 0.0, 0.0),
                energy,
                false,
                0,
                0,
                0,
                0);
    }
}
