// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import java.io.IOException;
import java.nio.file.CopyOption;
import java.nio.file.FileAlreadyExistsException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;

/**
 * Creation of incomplete files. A program writes a file beside its final place and moves the
 * complete file there. Readers therefore find either the old or the new file. For any thread.
 */
public final class PartFile {
    private static final int MOST = 1000;

    /** Incomplete files of this process. They are removed if a signal ends the process. */
    private static final Set<Path> UNFINISHED = ConcurrentHashMap.newKeySet();

    /** Whether the program removes incomplete files itself if a signal ends the process. */
    private static volatile boolean isLeft;

    static {
        Runtime.getRuntime()
                .addShutdownHook(new Thread(PartFile::removeUnlessLeft, "incomplete files"));
    }

    private PartFile() {}

    /**
     * Leaves incomplete files to the caller if a signal ends the process, because the caller still
     * completes them. The caller then calls {@link #removeUnfinished} before the process ends. Must
     * be called before the end of the process begins.
     *
     * @param isCallers false: a signal removes the files at once, as by default
     */
    public static void leave(boolean isCallers) {
        isLeft = isCallers;
    }

    /**
     * Creates an empty file beside {@code place}, with the ending {@code .part}. Uses {@code
     * .part2} and so on if a file, link or pipe of this name exists. An existing file stays
     * unchanged, because another program may own it.
     *
     * @throws IOException if the file cannot be created
     */
    public static Path create(Path place) throws IOException {
        String name = place.getFileName() + ".part";
        for (int number = 1; ; number++) {
            Path part = place.resolveSibling(number == 1 ? name : name + number);
            try {
                Path created = Files.createFile(part);
                UNFINISHED.add(created);
                return created;
            } catch (FileAlreadyExistsException taken) {
                if (number == MOST) {
                    throw taken;
                }
            }
        }
    }

    /**
     * Moves a complete file to its place.
     *
     * @throws IOException if it cannot be moved; the caller then removes it
     */
    public static void move(Path part, Path place, CopyOption... options) throws IOException {
        Files.move(part, place, options);
        UNFINISHED.remove(part);
    }

    /** Removes an incomplete file. */
    public static void remove(Path part) throws IOException {
        UNFINISHED.remove(part);
        Files.deleteIfExists(part);
    }

    private static void removeUnlessLeft() {
        if (!isLeft) {
            removeUnfinished();
        }
    }

    /** Removes all incomplete files of this process. */
    public static void removeUnfinished() {
        for (Path part : UNFINISHED) {
            try {
                Files.deleteIfExists(part);
            } catch (IOException stays) {
                // The exception is ignored, because the process ends.
            }
        }
    }
}
