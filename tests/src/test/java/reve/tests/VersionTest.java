// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.worlds.Product;

import java.io.IOException;
import java.nio.file.Files;
import java.util.List;

/** The project has one version number. */
class VersionTest {
    private final String version;

    VersionTest() throws IOException {
        version = Files.readString(Project.ROOT.resolve("VERSION")).strip();
    }

    @Test
    void theProgramNamesIt() throws Exception {
        assertThat(Product.version()).isEqualTo(version);
        assertThat(Reve.launch("--version").out()).startsWith("REVE x Vesper " + version + "\n");
    }

    @Test
    void theEngineNamesIt() throws Exception {
        Reve.Outcome engine =
                Reve.run(List.of(Project.NATIVE.resolve("vesper").toString(), "--version"));
        assertThat(engine.out()).startsWith("Vesper " + version + ",");
    }

    @Test
    void thePythonPackageHasIt() throws IOException {
        assertThat(Files.readString(Project.ROOT.resolve("agents/python/reve/__init__.py")))
                .contains("\n__version__ = \"" + version + "\"\n");
    }
}
