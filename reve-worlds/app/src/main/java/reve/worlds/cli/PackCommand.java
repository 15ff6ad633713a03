// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.core.file.WorldFile;
import reve.core.file.WorldPack;
import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Optional;
import java.util.SortedMap;
import java.util.concurrent.Callable;

/** The command {@code pack}: writes a world and all files that it needs into one file, a pack. */
@Command(
        name = "pack",
        description =
                "Makes one file of a world with its laws, included files, meshes and pictures, to"
                        + " be run on another machine.")
public final class PackCommand implements Callable<Integer> {
    private static final String EXPECTED = "expected.json";

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
        PackedFiles packed = PackedFiles.of(spec, world, folder);
        SortedMap<String, Path> files = packed.files();
        addExpected(new WorldFolder(world.folder()), files);
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
                        packed.world().name(),
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
