// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.nio.file.Path;
import java.time.Duration;

/** The output of programs, in a file of limited size. */
class ProgramOutputTest {
    private static final Duration PATIENCE = Duration.ofSeconds(300);

    @TempDir private Path folder;

    private Path outputOf(int most, String... command) throws Exception {
        Path file = folder.resolve("out.log");
        Process process = new ProcessBuilder(command).redirectErrorStream(true).start();
        var output = new ProgramOutput(process.getInputStream(), file, most);
        assertThat(process.waitFor(PATIENCE)).as("the program never waits for a reader").isTrue();
        output.await(PATIENCE);
        return file;
    }

    @Test
    void shortOutputIsWhole() throws Exception {
        assertThat(outputOf(100, "sh", "-c", "echo one; echo two >&2")).hasContent("one\ntwo");
    }

    @Test
    void furtherOutputIsDropped() throws Exception {
        Path file = outputOf(1000, "sh", "-c", "head -c 3000000 /dev/zero | tr '\\0' x");
        assertThat(file)
                .hasContent(
                        "x".repeat(1000)
                                + "\n(further output is dropped: the file has 1000 bytes)");
    }
}
