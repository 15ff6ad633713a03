// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;

import java.io.IOException;
import java.io.RandomAccessFile;
import java.nio.file.Files;
import java.nio.file.Path;

/** The files that are read as law libraries. */
class LibraryFileTest {
    @TempDir private Path folder;

    @Test
    void aLawInPythonIsReadUpToAMebibyte() throws IOException {
        Path whole = sparse("whole.py", PreparedLibrary.MAX_PYTHON_BYTES);
        assertThat(LibraryFile.read(whole)).hasSize(1 << 20);
        Path large = sparse("large.py", PreparedLibrary.MAX_PYTHON_BYTES + 1L);
        assertThatThrownBy(() -> LibraryFile.read(large))
                .isInstanceOf(PhysicsException.class)
                .hasMessage(
                        large + " has 1048577 bytes, expected a law library of at most 1048576");
    }

    @Test
    void aLinkIsNotRead() throws IOException {
        Path secret = Files.writeString(folder.resolve("secret"), "secret");
        Path link = Files.createSymbolicLink(folder.resolve("wind.law"), secret);
        assertThatThrownBy(() -> LibraryFile.read(link))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("found a symbolic link");
        assertThatThrownBy(() -> LawText.read(link))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("found a symbolic link");
    }

    private Path sparse(String name, long bytes) throws IOException {
        Path file = folder.resolve(name);
        try (RandomAccessFile out = new RandomAccessFile(file.toFile(), "rw")) {
            out.setLength(bytes);
        }
        return file;
    }
}
