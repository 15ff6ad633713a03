// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.concurrent.atomic.AtomicBoolean;

/** Regular files, and other objects that may be in their place. */
@Timeout(60) // a pipe must not block
class RegularFileTest {
    /** Number of attempts after which an outcome that did not occur never does. */
    private static final int MOST = 1_000_000;

    @TempDir private Path folder;

    private Path pipe(String name) throws Exception {
        Path pipe = folder.resolve(name);
        assertThat(new ProcessBuilder("mkfifo", pipe.toString()).start().waitFor()).isZero();
        return pipe;
    }

    @Test
    void aFileIsReadUpToItsLimit() throws Exception {
        Path file = Files.write(folder.resolve("a"), new byte[] {1, 2, 3});
        assertThat(RegularFile.read(file, 3)).containsExactly(1, 2, 3);
        assertThatThrownBy(() -> RegularFile.read(file, 2))
                .isInstanceOf(IOException.class)
                .hasMessage("it has more than 2 bytes");
        Path empty = Files.createFile(folder.resolve("empty"));
        assertThat(RegularFile.read(empty, 0)).isEmpty();
        assertThat(RegularFile.otherKind(empty)).isEmpty();
    }

    @Test
    void whateverElseIsThereIsRefusedWithoutBlocking() throws Exception {
        Path zeros = Files.createSymbolicLink(folder.resolve("zeros"), Path.of("/dev/zero"));
        refused(zeros, "found a symbolic link");
        refused(pipe("pipe"), "found a special file");
        refused(Path.of("/dev/zero"), "found a special file");
        refused(folder, "found a folder");
        assertThatThrownBy(() -> RegularFile.read(folder.resolve("none"), 100))
                .hasMessage("there is no such file");
    }

    private static void refused(Path file, String reason) throws IOException {
        assertThatThrownBy(() -> RegularFile.read(file, 100))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("expected a regular file, " + reason);
        assertThat(RegularFile.otherKind(file)).isEqualTo(withoutFound(reason, file));
    }

    private static String withoutFound(String reason, Path file) {
        String kind = reason.substring("found ".length());
        return Files.isSymbolicLink(file) ? kind + "; copy the file itself here" : kind;
    }

    @Test
    void onlyFoldersAreListed() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("laws"));
        Files.createFile(laws.resolve("b.law"));
        Files.createFile(laws.resolve("a.law"));
        Path link = Files.createSymbolicLink(folder.resolve("link"), laws);
        assertThat(FolderFiles.in(laws))
                .containsExactly(laws.resolve("a.law"), laws.resolve("b.law"));
        assertThat(FolderFiles.in(link))
                .containsExactly(link.resolve("a.law"), link.resolve("b.law"));
        assertThatThrownBy(() -> FolderFiles.in(pipe("pipe")))
                .isInstanceOf(FileSystemException.class)
                .hasMessageContaining("it is not a folder");
        assertThatThrownBy(() -> FolderFiles.in(folder.resolve("none")))
                .isInstanceOf(FileSystemException.class)
                .hasMessageContaining("there is no such folder");
    }

    @Test
    void aPipeThatTakesThePlaceOfAFileDoesNotBlock() throws Exception {
        Path file = folder.resolve("law");
        var done = new AtomicBoolean();
        Path regular = Files.write(folder.resolve("regular"), new byte[] {7});
        Path pipe = pipe("pipe");
        Thread exchanging =
                Thread.ofPlatform()
                        .start(
                                () -> {
                                    while (!done.get()) {
                                        put(regular, file);
                                        put(pipe, file);
                                    }
                                });
        int read = 0;
        int tried = 0;
        try {
            // The other thread may begin late.
            for (; tried < 3000 || (read == 0 || read == tried) && tried < MOST; tried++) {
                try {
                    assertThat(RegularFile.read(file, 10)).containsExactly(7);
                    read++;
                } catch (IOException refused) {
                    assertThat(refused.getMessage()).containsAnyOf("special file", "no such file");
                }
            }
        } finally {
            done.set(true);
            exchanging.join();
        }
        assertThat(read).isBetween(1, tried - 1);
    }

    /** Links a file at another place. The link replaces the object that is there. */
    private void put(Path what, Path place) {
        try {
            Path next = folder.resolve("next");
            Files.createLink(next, what);
            Files.move(next, place, StandardCopyOption.ATOMIC_MOVE);
        } catch (IOException impossible) {
            throw new IllegalStateException(impossible);
        }
    }
}
