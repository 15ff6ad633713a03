// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.core.file.LawReference;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldPack;
import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;
import reve.worlds.server.LawPath;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.SortedMap;
import java.util.TreeMap;
import java.util.concurrent.Callable;
import java.util.stream.Stream;

/** The command {@code pack}: writes a world and all files that it needs into one file, a pack. */
@Command(
        name = "pack",
        description =
                "Makes one file of a world with its laws, included files, meshes and pictures, to"
                        + " be run on another machine.")
public final class PackCommand implements Callable<Integer> {
    private static final String EXPECTED = "expected.json";
    private static final String LAWS = "laws";
    private static final List<String> LAW_FILES = List.of(".so", ".law", ".py");

    @Spec private CommandSpec spec = CommandSpec.create();

    @Mixin private WorldArgument world = new WorldArgument();

    @Option(
            names = "--laws",
            paramLabel = "DIR",
            description = "Folder of laws that the world names; the pack gets copies of them.")
    private Optional<Path> folder = Optional.empty();

    @Option(
            names = "--expected",
            paramLabel = "FILE",
            description =
                    "Results to put into the pack as "
                            + EXPECTED
                            + " (default: the "
                            + EXPECTED
                            + " beside the world file, if there is one).")
    private Optional<Path> expected = Optional.empty();

    @Option(
            names = "--out",
            paramLabel = "FILE",
            description = "The pack to write (default: NAME.reve in the current folder).")
    private Optional<Path> out = Optional.empty();

    @Override
    public Integer call() throws Exception {
        if (world.isPack()) {
            throw new ParameterException(
                    spec.commandLine(),
                    world.shown() + " is a pack already; copy it, or name the world to pack");
        }
        SortedMap<String, Path> files = new TreeMap<>();
        WorldFolder own = new WorldFolder(world.folder());
        List<String> named = new ArrayList<>();
        WorldDescription description = world.read(named::add);
        for (String name : named) {
            files.put(name, own.find(name));
        }
        if (files.containsKey(WorldFile.NAME) && !world.file().endsWith(WorldFile.NAME)) {
            throw new ParameterException(
                    spec.commandLine(),
                    world.shown()
                            + " names the file "
                            + WorldFile.NAME
                            + ", which is the name of the world file in a pack; rename that file");
        }
        files.put(WorldFile.NAME, world.file().toRealPath());
        addLaws(description, own, files);
        addExpected(own, files);
        Path pack = target();
        for (Path file : files.values()) {
            if (Files.exists(pack) && Files.isSameFile(file, pack)) {
                throw new ParameterException(
                        spec.commandLine(), "--out " + pack + " is a file of the world itself");
            }
        }
        WorldPack.write(pack, files);
        spec.commandLine()
                .getOut()
                .printf(
                        "%s: %s, %d files, %d bytes%s%n",
                        pack,
                        description.name(),
                        files.size(),
                        Files.size(pack),
                        files.keySet().stream()
                                        .anyMatch(
                                                name ->
                                                        name.endsWith(".so")
                                                                || name.endsWith(".py"))
                                ? "; it brings native code, which needs --trust where it runs"
                                : "");
        spec.commandLine().getOut().flush();
        return ExitCode.OK;
    }

    private Path target() throws IOException {
        Path name = world.file().toAbsolutePath().normalize();
        Path called = name.endsWith(WorldFile.NAME) ? name.getParent() : name;
        String base =
                called == null || called.getFileName() == null
                        ? "world"
                        : called.getFileName().toString().replaceFirst("\\.ya?ml$", "");
        Path given = out.orElse(Path.of(base + WorldPack.ENDING));
        WritableFile.require(spec, "--out", given, WritableFile.PACK, "a pack");
        return given;
    }

    /**
     * Adds the laws in the world's own folder, and those laws from {@code --laws} that the world
     * names.
     */
    private void addLaws(WorldDescription description, WorldFolder own, SortedMap<String, Path> to)
            throws IOException, AssetException {
        for (String name : ownLaws()) {
            to.put(name, own.find(name));
        }
        LawPath path = LawOptions.named(spec, folder).forWorld(world.folder());
        for (LawReference law : description.laws()) {
            if (law.text().isPresent()) {
                continue;
            }
            LawPath.Found found = path.find(law.name());
            if (found.origin() == LawPath.Origin.FOLDER) {
                to.keySet()
                        .removeAll(
                                LawPath.filesOf(law.name()).stream()
                                        .map(PackCommand::inLaws)
                                        .toList());
                to.put(inLaws(found.file().getFileName().toString()), found.file());
            }
        }
    }

    private static String inLaws(String file) {
        return LAWS + "/" + file;
    }

    private List<String> ownLaws() throws IOException {
        Path laws = world.folder().resolve(LAWS);
        if (!Files.isDirectory(laws)) {
            return List.of();
        }
        try (Stream<Path> all = Files.list(laws)) {
            return all.map(file -> file.getFileName().toString())
                    .filter(name -> LAW_FILES.stream().anyMatch(name::endsWith))
                    .sorted()
                    .map(PackCommand::inLaws)
                    .toList();
        }
    }

    private void addExpected(WorldFolder own, SortedMap<String, Path> to)
            throws IOException, AssetException {
        if (expected.isPresent()) {
            if (!Files.isRegularFile(expected.get())) {
                throw new ParameterException(
                        spec.commandLine(),
                        "--expected " + expected.get() + ": there is no such file");
            }
            to.put(EXPECTED, expected.get());
        } else if (Files.exists(world.folder().resolve(EXPECTED))) {
            to.put(EXPECTED, own.find(EXPECTED));
        }
    }
}
