// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.UUID;

class FrameFilesTest {
    private static final UUID ID = UUID.randomUUID();

    @TempDir private Path folder;
    private Path store;

    @BeforeEach
    void name() {
        store = folder.resolve("my.db");
    }

    @Test
    void eachFileNamesTheStoreAndTheFileBeforeIt() throws IOException {
        fill();
        RunLog.Link second = link(2);
        RunLog.Link third = link(3);
        assertThat(second.store()).isEqualTo(ID);
        assertThat(third.number()).isEqualTo(3);
        assertThat(third.before()).isEqualTo(second.id()).isNotZero();
        assertThat(link(1).before()).isZero();
    }

    @Test
    void theManifestClaimsTheNewestFileAndFrame() throws IOException {
        fill();
        Manifest.Claim claim = Manifest.read(store).orElseThrow();
        assertThat(claim.store()).isEqualTo(ID);
        assertThat(claim.file()).isEqualTo(3);
        assertThat(claim.fileId()).isEqualTo(link(3).id());
        assertThat(claim.frame()).isEqualTo(6);
        assertThat(claim.isOfAnotherBoot()).isFalse();
    }

    @Test
    void filesBeforeTheOldestImageAreRemovedAndNothingElse() throws IOException {
        fill();
        Files.writeString(folder.resolve("my.db-frames-old"), "mine");
        files(3).dropBefore(3);
        assertThat(FrameFiles.present(store)).containsOnlyKeys(3L);
        assertThat(folder.resolve("my.db-frames-old")).exists();
    }

    @Test
    void aManifestThatIsRemovedIsMadeAgainWithTheNextFile() throws IOException {
        FrameFiles files = files(0);
        files.next().close();
        files.write(frame(1));
        Files.delete(Manifest.path(store));
        files.next().close();
        files.close();
        assertThat(Manifest.read(store).orElseThrow().frame()).isEqualTo(1);
    }

    @Test
    void whatCannotBeWrittenIsToldByNameAndReason() throws IOException {
        Files.createDirectory(folder.resolve("my.db-frames-1"));
        assertThatExceptionOfType(IOException.class)
                .isThrownBy(() -> files(0).next())
                .withMessageContaining("my.db-frames-1 could not be written: Is a directory");
    }

    /** Writes six frames into three files. */
    private void fill() throws IOException {
        FrameFiles files = files(0);
        for (int frame = 1; frame <= 6; frame++) {
            if (frame % 2 == 1) {
                files.next().close();
            }
            files.write(frame(frame));
        }
        files.close();
    }

    private FrameFiles files(long number) {
        return new FrameFiles(store, Manifest.Claim.nothing(ID), number, 0);
    }

    private RunLog.Link link(long number) throws IOException {
        try (RunLog.Reader reader = RunLog.open(FrameFiles.path(store, number))) {
            return reader.link().orElseThrow();
        }
    }

    private static JournalRecord.Frame frame(long number) {
        return new JournalRecord.Frame(
                number, "{\"frame\":%d}".formatted(number).getBytes(StandardCharsets.UTF_8));
    }
}
