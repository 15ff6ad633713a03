// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Parameters;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;

/** The argument WORLD of most commands. */
final class WorldArgument {
    @Parameters(
            paramLabel = "WORLD",
            description = "A world file, or a folder that contains a world.yaml.")
    private Path path;

    WorldArgument() {
        this(Path.of(""));
    }

    WorldArgument(Path path) {
        this.path = path;
    }

    /** Returns the path of the world file. */
    Path file() {
        return Files.isDirectory(path) ? path.resolve(WorldFile.NAME) : path;
    }

    /** Returns the folder of the world file and of the files that it refers to. */
    Path folder() {
        Path parent = file().toAbsolutePath().getParent();
        return parent == null ? Path.of("/") : parent;
    }

    /** Reads and checks the file, and prints its warnings to {@code err}. */
    WorldDescription load(PrintWriter err) throws IOException, WorldFileException {
        WorldDescription description = read();
        description.warnings().forEach(err::println);
        err.flush();
        return description;
    }

    /** Reads and checks the file. */
    WorldDescription read() throws IOException, WorldFileException {
        Path file = file();
        if (!Files.exists(file)) {
            throw new NoSuchFileException(
                    "there is no world file "
                            + file
                            + "; name a file, or a folder that holds a world.yaml");
        }
        try (Patience _ = new Patience(System.err, "reading " + file)) {
            return Files.isDirectory(path) ? WorldFile.loadFolder(path) : WorldFile.load(file);
        }
    }
}
