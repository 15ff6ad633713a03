// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.io.OutputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;

class WholeFileTest {
    @TempDir private Path folder;

    private static byte[] bytes(String text) {
        return text.getBytes(StandardCharsets.UTF_8);
    }

    @Test
    void aFailureKeepsTheOlderFileAndNamesIt() throws IOException {
        Path place = Files.writeString(folder.resolve("plot.png"), "old");
        assertThatThrownBy(
                        () ->
                                WholeFile.write(
                                        place,
                                        out -> {
                                            out.write(bytes("half"));
                                            throw new IOException("No space left on device");
                                        }))
                .isInstanceOf(IOException.class)
                .hasMessage(place + ": No space left on device");
        assertThat(place).hasContent("old");
        WholeFile.write(place, out -> out.write(bytes("new")));
        assertThat(place).hasContent("new");
        assertThat(folder).isDirectoryNotContaining("glob:**.part");
    }

    @Test
    void aFileThatIsNotFinishedLeavesNothing() throws IOException {
        try (var file = new WholeFile(folder.resolve("table.csv"))) {
            OutputStream out = file.out();
            out.write(bytes("half"));
        }
        assertThat(folder).isEmptyDirectory();
    }

    @Test
    void aFolderOrDeviceIsNotReplaced() {
        for (Path place : new Path[] {folder, Path.of("/dev/null")}) {
            assertThatThrownBy(() -> WholeFile.write(place, out -> out.write(bytes("x"))))
                    .isInstanceOf(IOException.class)
                    .hasMessageContainingAll(place.toString(), "no regular file");
        }
    }
}
