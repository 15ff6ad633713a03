// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;

class PartFileTest {
    @TempDir private Path folder;

    /** Otherwise the program could follow a link and empty a file of someone else. */
    @Test
    void filesAndLinksOfOthersStayAsTheyAre() throws IOException {
        Path precious = Files.writeString(folder.resolve("precious.txt"), "precious");
        Path link = Files.createSymbolicLink(folder.resolve("x.csv.part"), precious);
        Path second = Files.writeString(folder.resolve("x.csv.part2"), "of another program");

        Path part = PartFile.create(folder.resolve("x.csv"));

        assertThat(part).isEqualTo(folder.resolve("x.csv.part3")).isEmptyFile();
        assertThat(link).isSymbolicLink();
        assertThat(precious).hasContent("precious");
        assertThat(second).hasContent("of another program");
        assertThat(PartFile.create(folder.resolve("y.csv"))).hasFileName("y.csv.part");
    }
}
