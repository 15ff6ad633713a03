// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import reve.core.file.WorldPack;

import java.io.IOException;
import java.nio.file.FileVisitResult;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.SimpleFileVisitor;
import java.nio.file.attribute.BasicFileAttributes;

/**
 * The private folder into which a pack (a world in one file) is unpacked. Only this account can
 * read it; the process removes it when it ends.
 */
final class PackFolder {
    private PackFolder() {}

    /** Unpacks a pack, and returns the folder. */
    static Path open(Path pack) throws IOException {
        Path folder = Files.createTempDirectory("reve-pack-");
        try {
            Runtime.getRuntime()
                    .addShutdownHook(
                            Thread.ofPlatform()
                                    .name("pack folder")
                                    .unstarted(() -> remove(folder)));
        } catch (IllegalStateException ending) {
            remove(folder);
            throw new IOException(pack + ": was not opened, because the program ends", ending);
        }
        WorldPack.unpack(pack, folder);
        return folder;
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
            System.err.println("reve: " + folder + " could not be removed: " + unremovable);
        }
    }
}
