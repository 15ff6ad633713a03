// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;

import reve.tests.Reve.Outcome;

import java.nio.file.Files;
import java.nio.file.Path;

/** {@code ./reve docs} finds no mistake in the comments of the public API, and writes its pages. */
@Tag("slow")
class ApiPagesIT {
    private static final Path PAGES = Project.ROOT.resolve("build/docs");

    @Test
    void thePagesOfAllPublicApiAreWritten() throws Exception {
        Outcome outcome = Reve.launch("docs");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(outcome.err())
                .contains(
                        "they begin at " + PAGES.resolve("java/index.html"),
                        "they begin at " + PAGES.resolve("native/index.html"));
        for (String type :
                new String[] {
                    "reve/core/world/World",
                    "reve/pe/PhysicsEngine",
                    "reve/worlds/cli/Main",
                    "reve/agent/AgentClient"
                }) {
            assertThat(PAGES.resolve("java").resolve(type + ".html")).isRegularFile();
        }
        for (String header : new String[] {"engine_8h", "types_8h", "units_8h", "law_8h"}) {
            assertThat(PAGES.resolve("native").resolve(header + ".html")).isRegularFile();
        }
        assertThat(Files.readString(PAGES.resolve("native/law_8hpp.html")))
                .contains("authors of physics laws");
    }
}
