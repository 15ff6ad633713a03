// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import reve.core.file.LawReference;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
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
import java.util.stream.Stream;

/**
 * A world and the files that it needs on another machine.
 *
 * @param files files by their names in a pack
 */
record PackedFiles(WorldDescription world, SortedMap<String, Path> files) {
    /** Name of the expected results of a world. */
    static final String EXPECTED = "expected.json";

    private static final String LAWS = "laws";
    private static final List<String> LAW_FILES = List.of(".so", ".law", ".py");

    /**
     * Reads a world file and finds the files that it refers to.
     *
     * @param folder the operator's folder of laws, if there is one
     */
    static PackedFiles of(CommandSpec spec, WorldArgument world, Optional<Path> folder)
            throws IOException, WorldFileException, AssetException {
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
        addLaws(spec, world, description, own, folder, files);
        return new PackedFiles(description, files);
    }

    /**
     * Adds the laws in the world's own folder, and those laws from {@code --laws} that the world
     * names.
     */
    private static void addLaws(
            CommandSpec spec,
            WorldArgument world,
            WorldDescription description,
            WorldFolder own,
            Optional<Path> folder,
            SortedMap<String, Path> to)
            throws IOException, AssetException {
        for (String name : ownLaws(world)) {
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
                                        .map(PackedFiles::inLaws)
                                        .toList());
                to.put(inLaws(found.file().getFileName().toString()), found.file());
            }
        }
    }

    /** Returns the name in a pack of a file with a law. */
    static String inLaws(String file) {
        return LAWS + "/" + file;
    }

    private static List<String> ownLaws(WorldArgument world) throws IOException {
        Path laws = world.folder().resolve(LAWS);
        if (!Files.isDirectory(laws)) {
            return List.of();
        }
        try (Stream<Path> all = Files.list(laws)) {
            return all.map(file -> file.getFileName().toString())
                    .filter(name -> LAW_FILES.stream().anyMatch(name::endsWith))
                    .sorted()
                    .map(PackedFiles::inLaws)
                    .toList();
        }
    }
}
