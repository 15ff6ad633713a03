// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.nio.file.Files;
import java.nio.file.Path;

class NativeFolderTest {
    @Test
    void aMissingPropertyIsNamedWithWhatToDo() {
        assertThatIllegalStateException()
                .isThrownBy(() -> NativeFolder.libvesper(null))
                .withMessage(
                        "system property reve.native.path is not set: start Java with"
                                + " -Dreve.native.path=FOLDER, the folder that holds libvesper.so");
    }

    @Test
    void aMissingLibraryIsNamedWithItsPath(@TempDir Path folder) {
        assertThatIllegalStateException()
                .isThrownBy(() -> NativeFolder.libvesper(folder.toString()))
                .withMessageStartingWith(
                        folder.resolve("libvesper.so") + " is not there: build it");
    }

    @Test
    void aLibraryInTheFolderIsFound(@TempDir Path folder) throws Exception {
        Path library = Files.createFile(folder.resolve("libvesper.so"));
        assertThat(NativeFolder.libvesper(folder.toString())).isEqualTo(library);
    }
}
