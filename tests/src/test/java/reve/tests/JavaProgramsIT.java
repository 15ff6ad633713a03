// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.nio.file.Files;
import java.nio.file.Path;

/** {@code docs/java.md}: its program needs only the jars of the runtime. */
class JavaProgramsIT {
    @TempDir private Path folder;

    @Test
    void theProgramRunsWithTheJarsOfTheRuntimeOnly() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/java.md"));
        Files.writeString(folder.resolve("Fall.java"), page.titled("Fall.java").text());
        String bin = System.getProperty("java.home") + "/bin";

        String printed =
                new Shell(folder)
                        .run("PATH=\"" + bin + ":$PATH\"\n" + page.titled("fall.sh").text());

        assertThat(page.titled("fall.sh").text()).contains("reve-worlds-runtime.jar");
        assertThat(printed).isEqualTo(page.blocks().get(2).text());
        assertThat(Jars.broughtBy("reve-worlds-runtime"))
                .contains("reve-core-world.jar", "reve-pe-adapter.jar")
                .noneMatch(jar -> jar.matches("(reve-worlds-app|agents-java|picocli|logback).*"));
    }
}
