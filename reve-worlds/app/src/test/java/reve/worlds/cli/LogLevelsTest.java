// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.slf4j.LoggerFactory;

/** What the program logs by default. */
class LogLevelsTest {

    @Test
    void clientsOfTheWebPortCannotFillTheLog() {
        // This logger warns about requests that name two hosts, and prints both values.
        var jetty = LoggerFactory.getLogger("org.eclipse.jetty.http.HttpParser");
        assertThat(jetty.isWarnEnabled()).isFalse();
        assertThat(jetty.isErrorEnabled()).isTrue();
        assertThat(LoggerFactory.getLogger("reve.agents").isWarnEnabled()).isTrue();
    }
}
