// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import reve.core.file.WorldPack;
import reve.core.text.Visible;

import java.io.IOException;
import java.nio.channels.FileChannel;
import java.nio.channels.FileLock;
import java.nio.channels.OverlappingFileLockException;
import java.nio.file.DirectoryIteratorException;
import java.nio.file.DirectoryStream;
import java.nio.file.FileVisitResult;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.nio.file.SimpleFileVisitor;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.BasicFileAttributes;
import java.nio.file.attribute.UserPrincipal;
import java.time.Duration;
import java.time.Instant;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;

/**
 * The private folder into which a process unpacks packs (worlds in one file). Only this account can
 * read the folder. The process removes it when it ends. The process holds a lock while it uses the
 * folder. A later process recognizes the folders of killed processes by the missing lock, and
 * removes them. For any thread.
 */
final class PackFolder {
    private static final String PREFIX = "reve-pack-";

    /** The file that the process locks while it uses the folder. */
    private static final String LOCK = "in-use";

    private static final String WORLD = "world";

    /**
     * Age from which an unlocked folder counts as abandoned. A younger folder may belong to a
     * process that has not locked it yet.
     */
    private static final Duration YOUNG = Duration.ofMinutes(1);

    /**
     * The folders of this process. It must not open their locks again: a process loses its lock on
     * a file when it closes any of its descriptors of this file.
     */
    private static final Set<Path> OWN = ConcurrentHashMap.newKeySet();

    /** The folder of this process that it uses now. Guarded by the lock of this class. */
    private static @Nullable Path current;

    private PackFolder() {}

    /** Unpacks a pack, and returns the folder of its world. */
    static Path open(Path pack) throws IOException {
        Path folder = Files.createTempDirectory(folderOfProcess(pack), WORLD);
        WorldPack.unpack(pack, folder);
        return folder;
    }

    /** Returns the folder of this process; a new one if a program has removed it. */
    private static synchronized Path folderOfProcess(Path pack) throws IOException {
        if (current == null || !Files.isDirectory(current)) {
            current = create(pack);
        }
        return current;
    }

    private static Path create(Path pack) throws IOException {
        Path place = Files.createTempDirectory(PREFIX);
        OWN.add(place);
        removeAbandoned(place.getParent(), Files.getOwner(place), Instant.now().minus(YOUNG));
        FileChannel lock =
                FileChannel.open(
                        place.resolve(LOCK),
                        StandardOpenOption.CREATE_NEW,
                        StandardOpenOption.WRITE);
        lock.lock();
        try {
            Runtime.getRuntime()
                    .addShutdownHook(
                            Thread.ofPlatform()
                                    .name("pack folder")
                                    .unstarted(() -> removeOwn(place, lock)));
        } catch (IllegalStateException ending) {
            remove(place);
            throw new IOException(pack + ": was not opened, because the program ends", ending);
        }
        return place;
    }

    /** Removes the folders of {@code owner} that no process has locked since {@code before}. */
    static void removeAbandoned(Path parent, UserPrincipal owner, Instant before) {
        try (DirectoryStream<Path> places = Files.newDirectoryStream(parent, PREFIX + "*")) {
            for (Path place : places) {
                if (!OWN.contains(place) && isAbandoned(place, owner, before)) {
                    remove(place);
                }
            }
        } catch (IOException | DirectoryIteratorException unreadable) {
            // The exception is ignored. The abandoned folders remain, and a later process removes
            // them.
        }
    }

    private static boolean isAbandoned(Path place, UserPrincipal owner, Instant before) {
        Path file = place.resolve(LOCK);
        try {
            if (!Files.isDirectory(place, LinkOption.NOFOLLOW_LINKS)
                    || !Files.getOwner(place, LinkOption.NOFOLLOW_LINKS).equals(owner)
                    || !Files.isRegularFile(file, LinkOption.NOFOLLOW_LINKS)
                    || Files.getLastModifiedTime(file).toInstant().isAfter(before)) {
                return false;
            }
            try (FileChannel channel = FileChannel.open(file, StandardOpenOption.WRITE);
                    FileLock lock = channel.tryLock()) {
                return lock != null;
            }
        } catch (IOException | OverlappingFileLockException inUse) {
            return false;
        }
    }

    /** Removes the folder. The channel keeps the folder locked until the removal is complete. */
    private static void removeOwn(Path place, FileChannel lock) {
        remove(place);
        try {
            lock.close();
        } catch (IOException closed) {
            // The exception is ignored, because the process ends and releases the lock anyway.
        }
    }

    private static void remove(Path folder) {
        try {
            Files.walkFileTree(
                    folder,
                    new SimpleFileVisitor<>() {
                        @Override
                        public FileVisitResult visitFile(Path file, BasicFileAttributes attributes)
                                throws IOException {
                            Files.delete(file);
                            return FileVisitResult.CONTINUE;
                        }

                        @Override
                        public FileVisitResult postVisitDirectory(
                                Path each, @Nullable IOException failure) throws IOException {
                            Files.delete(each);
                            return FileVisitResult.CONTINUE;
                        }
                    });
        } catch (IOException unremovable) {
            System.err.println(
                    Visible.line("reve: " + folder + " could not be removed: " + unremovable));
        }
    }
}
