// SPDX-License-Identifier: Apache-2.0
package reve.worlds.demo;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.PrintWriter;
import java.io.StringWriter;

class DemoReportTest {
    private static JsonNode json(String text) {
        return new JsonMapper().readTree(text);
    }

    @Test
    void theReportIsInSentences() {
        var report =
                new DemoReport(
                        json(
                                """
                                {"world": "orbit", "frames": 362, "worldSeconds": 6.0333333,
                                 "realTimeFactor": 0.99876, "laws": [{"law": "a"}, {"law": "b"}]}
                                """),
                        json("{\"library\": \"gravity_field\", \"time\": 2.0333333}"),
                        json("{\"library\": \"gravity_field\", \"time\": 5.0166667}"),
                        json("{\"time\": 2.0, \"file\": \"one.png\"}"),
                        json("{\"time\": 5.0, \"file\": \"two.png\"}"),
                        json(
                                """
                                {"agent": "curious", "perceptions": 51, "pushes": 1,
                                 "actsRefused": {"too-fast": 2, "late": 1}}
                                """),
                        json(
                                """
                                {"agent": "painter", "perceptions": 50, "actsAccepted": 8,
                                 "fastestMetresPerSecond": 3.8004325635159155,
                                 "painted": {"red": "#ff4000"}, "actsRefused": {}}
                                """));
        var text = new StringWriter();
        var out = new PrintWriter(text);
        report.print(out);
        out.flush();
        assertThat(text.toString().strip().lines())
                .containsExactly(
                        "The world orbit ran for 6.0 s of world time (362 frames), at 1.00 x real"
                                + " time.",
                        "The law gravity_field was added while the world ran, at 2.03 s, and"
                                + " removed at 5.02 s. At the end the laws were a, b.",
                        "The Python agent curious perceived the world 51 times and pushed items once."
                                + " The server refused 3 of its actions.",
                        "The Java agent painter perceived the world 50 times and painted items 8"
                                + " times: red is now #ff4000. The fastest item moved at 3.8 m/s.",
                        "The picture at 2.00 s, without gravity_field, is one.png",
                        "The picture at 5.00 s, with gravity_field, is two.png");
    }
}
