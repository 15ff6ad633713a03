// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Parameters;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.text.Suggestion;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.DirectoryIteratorException;
import java.nio.file.DirectoryStream;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;

/** The argument WORLD of most commands. */
final class WorldArgument {
    /** Maximum number of worlds that a message lists. */
    private static final int MOST = 20;

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

    /** Returns the end of a message about a missing world: the worlds beside it. */
    private String others() {
        Path parent = path.toAbsolutePath().normalize().getParent();
        if (parent == null || path.getFileName() == null) {
            return "";
        }
        List<String> names = new ArrayList<>();
        try (DirectoryStream<Path> all = Files.newDirectoryStream(parent)) {
            for (Path each : all) {
                String name = String.valueOf(each.getFileName());
                if (Files.isRegularFile(each.resolve(WorldFile.NAME)) || name.endsWith(".yaml")) {
                    names.add(name);
                }
            }
        } catch (IOException | DirectoryIteratorException unreadable) {
            return "";
        }
        Collections.sort(names);
        String near = Suggestion.of(path.getFileName().toString(), names);
        return !near.isEmpty()
                ? near
                : names.isEmpty()
                        ? ""
                        : "; in "
                                + parent
                                + " are "
                                + String.join(", ", names.subList(0, Math.min(MOST, names.size())));
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
                            + "; name a file, or a folder that holds a world.yaml"
                            + others());
        }
        try (Patience _ = new Patience(System.err, "reading " + file)) {
            return Files.isDirectory(path) ? WorldFile.loadFolder(path) : WorldFile.load(file);
        }
    }
}
