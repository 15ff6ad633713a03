// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import java.io.IOException;
import java.nio.file.FileAlreadyExistsException;
import java.nio.file.Files;
import java.nio.file.Path;

/**
 * Creation of incomplete files. A program writes a file beside its final place and moves the
 * complete file there. Readers therefore find either the old or the new file. For any thread.
 */
public final class PartFile {
    private static final int MOST = 1000;

    private PartFile() {}

    /**
     * Creates an empty file beside {@code place}, with the ending {@code .part}. If a file, link or
     * pipe of this name exists, uses {@code .part2} and so on. An existing file stays unchanged,
     * because another program may own it.
     *
     * @throws IOException if the file cannot be created
     */
    public static Path create(Path place) throws IOException {
        String name = place.getFileName() + ".part";
        for (int number = 1; ; number++) {
            Path part = place.resolveSibling(number == 1 ? name : name + number);
            try {
                return Files.createFile(part);
            } catch (FileAlreadyExistsException taken) {
                if (number == MOST) {
                    throw taken;
                }
            }
        }
    }
}
