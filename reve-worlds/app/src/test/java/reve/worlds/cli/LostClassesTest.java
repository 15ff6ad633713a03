// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.concurrent.TimeUnit;

/** A process whose files were overwritten ends, so that a supervisor can start it again. */
class LostClassesTest {

    /** A program whose worker ends because a class cannot be loaded. */
    static final class Program {
        public static void main(String[] arguments) throws InterruptedException {
            Thread.setDefaultUncaughtExceptionHandler(Main::reportEnd);
            Thread.ofPlatform()
                    .start(
                            () -> {
                                throw new NoClassDefFoundError("reve/Lost");
                            });
            Thread.sleep(400_000);
        }
    }

    @Test
    void theProcessEndsWithAMessage() throws Exception {
        Process process =
                new ProcessBuilder(
                                Path.of(System.getProperty("java.home"), "bin", "java").toString(),
                                "-XX:TieredStopAtLevel=1",
                                "-cp",
                                System.getProperty("java.class.path"),
                                Program.class.getName())
                        .redirectErrorStream(true)
                        .start();
        assertThat(process.waitFor(300, TimeUnit.SECONDS)).isTrue();
        assertThat(process.exitValue()).isEqualTo(ExitCode.FAILURE);
        assertThat(new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8))
                .isEqualTo(
                        "reve: the process ends, because the program's files have changed while it"
                                + " ran (NoClassDefFoundError); install a new version into a new"
                                + " folder\n");
    }
}
