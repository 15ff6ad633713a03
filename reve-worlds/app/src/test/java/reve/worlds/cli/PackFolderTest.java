// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldFile;
import reve.core.file.WorldPack;

import java.io.IOException;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.FileTime;
import java.time.Duration;
import java.time.Instant;
import java.util.Map;
import java.util.TreeMap;

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

    /**
     * A process has one folder for all packs, so that it needs one descriptor for its lock. It
     * keeps the lock while it opens further packs.
     */
    @Test
    void aProcessKeepsItsOwnFoldersAndTheirLocks() throws Exception {
        Path pack = folder.resolve("world.reve");
        Path world = Files.writeString(folder.resolve("w.yaml"), "reve: 1\nname: w\n");
        WorldPack.write(pack, new TreeMap<>(Map.of(WorldFile.NAME, world)));
        Path unpacked = PackFolder.open(pack);
        Path first = unpacked.getParent();
        Path lock = first.resolve("in-use");
        // In another process, because Java opens and closes the file to set its time.
        var old = new ProcessBuilder("touch", "-d", "2 minutes ago", lock.toString());
        assertThat(old.start().waitFor()).isZero();

        Path again = PackFolder.open(pack);

        assertThat(again).isNotEqualTo(unpacked).hasParent(first);
        assertThat(again.resolve(WorldFile.NAME)).exists();
        assertThat(unpacked.resolve(WorldFile.NAME)).exists();
        String tryLock =
                "import fcntl, sys; fcntl.lockf(open(sys.argv[1], 'r+'), fcntl.LOCK_EX |"
                        + " fcntl.LOCK_NB)";
        var other = new ProcessBuilder("python3", "-c", tryLock, lock.toString());
        assertThat(other.start().waitFor()).as("another process gets the lock").isNotZero();
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
