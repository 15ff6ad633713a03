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
import java.io.UncheckedIOException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.util.List;
import java.util.Optional;
import java.util.function.Consumer;
import java.util.stream.Stream;

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
     * Returns the end of a message about a missing world. It suggests a world with a similar path,
     * or lists the worlds of the folder.
     */
    private String others() {
        if (Files.isDirectory(path)) {
            return listed(path, worldsIn(path));
        }
        Optional<Path> near = similar().or(this::sample).filter(WorldArgument::isWorld);
        if (near.isPresent()) {
            return "; did you mean `" + near.get() + "`?";
        }
        Path parent = path.toAbsolutePath().normalize().getParent();
        return parent == null ? "" : listed(parent, worldsIn(parent));
    }

    private static String listed(Path folder, List<String> worlds) {
        String more = worlds.size() > MOST ? " and " + (worlds.size() - MOST) + " more" : "";
        return worlds.isEmpty()
                ? ""
                : "; in "
                        + folder
                        + " are "
                        + String.join(", ", worlds.subList(0, Math.min(MOST, worlds.size())))
                        + more;
    }

    /** Returns the path with its first part that does not exist replaced by a similar name. */
    private Optional<Path> similar() {
        Path found = path.isAbsolute() ? path.getRoot() : Path.of("");
        for (int i = 0; i < path.getNameCount(); i++) {
            Path next = found.resolve(path.getName(i));
            if (!Files.exists(next)) {
                Path folder = found;
                Path rest = path.subpath(i, path.getNameCount());
                return Suggestion.nearest(path.getName(i).toString(), namesIn(folder))
                        .map(folder::resolve)
                        .map(
                                near ->
                                        rest.getNameCount() == 1
                                                ? near
                                                : near.resolve(
                                                        rest.subpath(1, rest.getNameCount())));
            }
            found = next;
        }
        return Optional.empty();
    }

    /** Returns the sample world whose name the argument is, or is similar to. */
    private Optional<Path> sample() {
        Path samples = Path.of(System.getProperty("reve.root", "."), "worlds");
        if (path.getNameCount() != 1 || path.isAbsolute()) {
            return Optional.empty();
        }
        List<String> names = worldsIn(samples);
        String name = path.toString();
        return (names.contains(name) ? Optional.of(name) : Suggestion.nearest(name, names))
                .map(samples::resolve)
                .map(WorldArgument::fromHere);
    }

    /** Returns a path relative to the working folder if it is in this folder. */
    private static Path fromHere(Path file) {
        Path here = Path.of("").toAbsolutePath();
        Path absolute = file.toAbsolutePath().normalize();
        return absolute.startsWith(here) ? here.relativize(absolute) : absolute;
    }

    private static boolean isWorld(Path file) {
        return Files.isRegularFile(file.resolve(WorldFile.NAME))
                || Files.isRegularFile(file)
                        && Stream.of(".yaml", WorldPack.ENDING)
                                .anyMatch(ending -> file.toString().endsWith(ending));
    }

    /** Returns the names of the worlds in a folder, in alphabetical order. */
    private static List<String> worldsIn(Path folder) {
        return namesIn(folder).stream().filter(name -> isWorld(folder.resolve(name))).toList();
    }

    private static List<String> namesIn(Path folder) {
        try (Stream<Path> all = Files.list(folder)) {
            return all.map(file -> String.valueOf(file.getFileName())).sorted().toList();
        } catch (IOException | UncheckedIOException unreadable) {
            return List.of(); // an unreadable folder has no names to suggest
        }
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
