// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.file.WorldPack;
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
import java.util.Optional;
import java.util.function.Consumer;

/**
 * The argument WORLD of most commands. It names a world file, a folder with a world file, or a pack
 * (a world in one file).
 */
final class WorldArgument {
    /** Maximum number of worlds that a message lists. */
    private static final int MOST = 20;

    @Parameters(
            paramLabel = "WORLD",
            description =
                    "A world file, a folder that contains a world.yaml, or a pack (reve pack).")
    private Path path;

    /** The folder into which a pack was unpacked. */
    private Optional<Path> unpacked = Optional.empty();

    WorldArgument() {
        this(Path.of(""));
    }

    WorldArgument(Path path) {
        this.path = path;
    }

    /**
     * Returns a world whose pack is not in a file.
     *
     * @param name the world, for messages
     * @param pack the bytes of the pack
     */
    static WorldArgument unpacked(String name, byte[] pack) throws IOException {
        WorldArgument world = new WorldArgument(Path.of(name));
        Path file = Files.createTempFile("reve-", WorldPack.ENDING);
        try {
            Files.write(file, pack);
            world.unpacked = Optional.of(PackFolder.open(file));
        } finally {
            Files.delete(file);
        }
        return world;
    }

    /**
     * Returns the end of a message about a missing world. It lists the names of worlds in the same
     * folder.
     */
    private String others() {
        Path parent = path.toAbsolutePath().normalize().getParent();
        if (parent == null || path.getFileName() == null) {
            return "";
        }
        List<String> names = new ArrayList<>();
        try (DirectoryStream<Path> all = Files.newDirectoryStream(parent)) {
            for (Path each : all) {
                String name = String.valueOf(each.getFileName());
                if (Files.isRegularFile(each.resolve(WorldFile.NAME))
                        || name.endsWith(".yaml")
                        || name.endsWith(WorldPack.ENDING)) {
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

    /** Returns the argument. */
    Path given() {
        return path;
    }

    /** Returns whether the argument names a pack. */
    boolean isPack() {
        return unpacked.isPresent() || WorldPack.isPack(path);
    }

    /** Returns the file that the user named: a world file or a pack. */
    Path shown() {
        return Files.isDirectory(path) ? path.resolve(WorldFile.NAME) : path;
    }

    /** Returns the path of the world file. Unpacks a pack first, and returns the unpacked file. */
    Path file() throws IOException {
        if (!isPack()) {
            return shown();
        }
        if (unpacked.isEmpty()) {
            unpacked = Optional.of(PackFolder.open(path));
        }
        return unpacked.get().resolve(WorldFile.NAME);
    }

    /**
     * Refuses an option whose file would store the path of the world's folder if the argument is a
     * pack. The folder of a pack is removed when the command ends, so that path would become
     * invalid.
     */
    void requireLasting(CommandSpec spec, String option, boolean given) {
        if (given && isPack()) {
            throw new ParameterException(
                    spec.commandLine(),
                    option
                            + " keeps the name of the world's folder, and "
                            + path
                            + " is a pack, whose folder is removed at the end; unpack it, for"
                            + " example with unzip, and name the folder");
        }
    }

    /** Returns the folder of the world file and of the files that it refers to. */
    Path folder() throws IOException {
        Path parent = file().toAbsolutePath().getParent();
        return parent == null ? Path.of("/") : parent;
    }

    /** Reads and checks the world file, and prints its warnings to {@code err}. */
    WorldDescription load(PrintWriter err) throws IOException, WorldFileException {
        WorldDescription description = read();
        description.warnings().forEach(err::println);
        err.flush();
        return description;
    }

    /** Reads and checks the world file. */
    WorldDescription read() throws IOException, WorldFileException {
        return read(_ -> {});
    }

    /**
     * Reads and checks the world file.
     *
     * @param found receives the names of the files that it refers to, as in {@link
     *     WorldFile#load(Path, String, Consumer)}
     */
    WorldDescription read(Consumer<String> found) throws IOException, WorldFileException {
        Path file = file();
        if (!Files.exists(file)) {
            throw new NoSuchFileException(
                    "there is no world file "
                            + file
                            + "; name a file, or a folder that holds a world.yaml"
                            + others());
        }
        try (Patience _ = new Patience(System.err, "reading " + shown())) {
            if (!isPack() && Files.isDirectory(path)) {
                return WorldFile.loadFolder(path, found);
            }
            String name = isPack() ? path.resolve(WorldFile.NAME).toString() : file.toString();
            return WorldFile.load(file, name, found);
        }
    }
}
