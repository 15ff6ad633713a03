// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import static org.assertj.core.api.Assertions.assertThatCode;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.io.RandomAccessFile;
import java.nio.file.Files;
import java.nio.file.Path;

class PasswordFileTest {
    @TempDir private Path folder;

    @Test
    void aMissingFileAndAFileOfLinesAreAccepted() throws IOException {
        Path file = folder.resolve("pgpass");
        assertThatCode(() -> PasswordFile.check(file)).doesNotThrowAnyException();
        Files.writeString(file, "db:5432:worlds:reve:secret\n");
        assertThatCode(() -> PasswordFile.check(file)).doesNotThrowAnyException();
    }

    @Test
    void aPipeIsRefusedWithoutReadingIt() throws Exception {
        Path pipe = folder.resolve("pipe");
        new ProcessBuilder("mkfifo", pipe.toString()).start().waitFor();
        assertThatThrownBy(() -> PasswordFile.check(pipe))
                .isInstanceOf(IOException.class)
                .hasMessageContaining(pipe + " is not a regular file")
                .hasMessageContaining("PGPASSFILE");
    }

    @Test
    void aHugeFileIsRefused() throws Exception {
        Path file = folder.resolve("huge");
        try (var huge = new RandomAccessFile(file.toFile(), "rw")) {
            huge.setLength(1 << 21);
        }
        assertThatThrownBy(() -> PasswordFile.check(file))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("2097152 bytes, expected at most 1048576");
    }
}
