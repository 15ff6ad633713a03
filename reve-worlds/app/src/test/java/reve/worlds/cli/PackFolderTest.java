// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.FileTime;
import java.time.Duration;
import java.time.Instant;

/**
 * Earlier processes unpacked packs into folders. The tests check which of these folders a process
 * removes.
 */
class PackFolderTest {
    @TempDir private Path folder;

    @Test
    void foldersOfKilledProcessesAreRemovedAndNoOthers() throws IOException {
        Path killed = place("reve-pack-killed", Duration.ofMinutes(2));
        Path starting = place("reve-pack-starting", Duration.ZERO);
        Path running = place("reve-pack-running", Duration.ofMinutes(2));
        Path withoutLock = Files.createDirectory(folder.resolve("reve-pack-foreign"));
        Path elsewhere = place("elsewhere", Duration.ofMinutes(2));
        Path link =
                Files.createSymbolicLink(folder.resolve("reve-pack-link"), elsewhere.getFileName());
        try (FileChannel channel =
                FileChannel.open(running.resolve("in-use"), StandardOpenOption.WRITE)) {
            channel.lock();
            PackFolder.removeAbandoned(
                    folder, Files.getOwner(folder), Instant.now().minus(Duration.ofMinutes(1)));
        }
        assertThat(killed).doesNotExist();
        assertThat(folder)
                .isDirectoryContaining(path -> path.equals(starting))
                .isDirectoryContaining(path -> path.equals(running))
                .isDirectoryContaining(path -> path.equals(withoutLock))
                .isDirectoryContaining(path -> path.equals(elsewhere))
                .isDirectoryContaining(path -> path.equals(link));
    }

    /** Creates the folder of a process that was killed {@code age} after its start. */
    private Path place(String name, Duration age) throws IOException {
        Path place = Files.createDirectory(folder.resolve(name));
        Path lock = Files.createFile(place.resolve("in-use"));
        Files.createDirectory(place.resolve("world"));
        Files.writeString(place.resolve("world/world.yaml"), "reve: 1\n");
        Files.setLastModifiedTime(lock, FileTime.from(Instant.now().minus(age)));
        return place;
    }
}
