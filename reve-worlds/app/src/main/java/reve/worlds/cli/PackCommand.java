// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.file.LawReference;
import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.file.WorldPack;
import reve.core.frame.Pacing;
import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;
import reve.pe.PhysicsException;
import reve.worlds.server.LawPath;
import reve.worlds.server.Simulation;
import reve.worlds.server.StoredRun;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.SortedMap;
import java.util.SortedSet;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.concurrent.Callable;

/** The command {@code pack}: writes a world and all files that it needs into one file, a pack. */
@Command(
        name = "pack",
        description =
                "Makes one file of a world with its laws, included files, meshes and pictures, to"
                        + " be run on another machine. Also makes it of the world of a recording or"
                        + " a store, at a chosen frame.")
public final class PackCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            paramLabel = "WORLD|FILE",
            description =
                    "A world file, a folder that contains a world.yaml, a recording (--record), or"
                            + " a store (serve --store).")
    private Path path = Path.of("");

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Option(
            names = "--at",
            paramLabel = "S",
            description =
                    "Time after the first state of a recording or a store at which its world is"
                            + " packed [s] (default: the end).")
    private Optional<Double> at = Optional.empty();

    @Option(
            names = "--frame",
            paramLabel = "N",
            description = "Number of the frame that is packed, instead of --at.")
    private Optional<Long> frame = Optional.empty();

    @Option(
            names = "--world",
            paramLabel = "WORLD",
            description =
                    "World file of a recording or a store, with its camera, agents, rules and"
                            + " meshes (default: the world.yaml in the folder that the recording"
                            + " names).")
    private Optional<Path> worldFile = Optional.empty();

    @Option(
            names = "--expected",
            paramLabel = "FILE",
            description =
                    "Results to put into the pack as "
                            + PackedFiles.EXPECTED
                            + " (default: the "
                            + PackedFiles.EXPECTED
                            + " beside the world file, if there is one; of a recording, its next"
                            + " frames).")
    private Optional<Path> expected = Optional.empty();

    @Option(
            names = "--out",
            paramLabel = "FILE",
            description = "The pack to write (default: NAME.reve in the current folder).")
    private Optional<Path> out = Optional.empty();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        plugins.use();
        if (StoredRun.isOne(path)) {
            packRecording();
        } else {
            packWorld(new WorldArgument(path));
        }
        return ExitCode.OK;
    }

    private void packWorld(WorldArgument world)
            throws IOException, WorldFileException, AssetException {
        if (world.isPack()) {
            throw wrong(world.shown() + " is a pack already; copy it, or name the world to pack");
        }
        if (at.isPresent() || frame.isPresent() || worldFile.isPresent()) {
            throw wrong(
                    "--at, --frame and --world are for a recording or a store, which "
                            + world.shown()
                            + " is not");
        }
        PackedFiles packed = PackedFiles.of(spec, world, laws.folder());
        List<Problem> warnings = check(world, packed.world());
        SortedMap<String, Path> files = packed.files();
        if (Files.exists(world.folder().resolve(PackedFiles.EXPECTED))) {
            files.put(
                    PackedFiles.EXPECTED,
                    new WorldFolder(world.folder()).find(PackedFiles.EXPECTED));
        }
        write(
                new Made(packed.world().name(), Optional.empty(), List.of(), warnings),
                target(world.file()),
                files,
                new TreeMap<>());
    }

    /**
     * Builds the world and loads its laws, except those that need {@code --trust}. Prints the
     * warnings and returns them.
     *
     * @throws PhysicsException if the engine refuses a law
     */
    private List<Problem> check(WorldArgument world, WorldDescription description)
            throws IOException {
        LawPath lawPath = laws.path(spec).forWorld(world.folder());
        List<LawReference> opened =
                description.laws().stream().filter(law -> !lawPath.needsTrust(law.name())).toList();
        boolean complete = opened.size() == description.laws().size();
        try (Simulation simulation =
                new Simulation(description.withLaws(opened), Pacing.FAST, lawPath)) {
            return Warnings.print(spec, simulation.warnings(complete));
        }
    }

    private void packRecording() throws IOException, WorldFileException, AssetException {
        if (at.isPresent() && frame.isPresent()) {
            throw wrong("--at and --frame both choose the frame; leave one of them out");
        }
        if (frame.isPresent() && frame.get() < 0) {
            throw wrong("--frame is " + frame.get() + ", expected a frame from 0 on");
        }
        Path pack = target(path);
        PackedRecording packed =
                PackedRecording.of(
                        spec,
                        path,
                        laws.path(spec),
                        worldFile.map(WorldArgument::new),
                        new PackedRecording.Moment(at, frame));
        write(
                new Made(
                        packed.world().name(),
                        Optional.of(packed.frame()),
                        packed.notes(),
                        List.of()),
                pack,
                packed.files(),
                packed.made());
    }

    /**
     * The world in the pack.
     *
     * @param frame the frame of a recording or a store
     * @param notes one message for each part of a recorded state that the pack does not contain
     * @param warnings the warnings of the check of a world file
     */
    private record Made(
            String world, Optional<Long> frame, List<String> notes, List<Problem> warnings) {}

    private ParameterException wrong(String message) {
        return new ParameterException(spec.commandLine(), message);
    }

    private void write(
            Made world, Path pack, SortedMap<String, Path> files, SortedMap<String, byte[]> made)
            throws IOException {
        if (expected.isPresent()) {
            if (!Files.isRegularFile(expected.get())) {
                throw wrong("--expected " + expected.get() + ": there is no such file");
            }
            files.put(PackedFiles.EXPECTED, expected.get());
            made.remove(PackedFiles.EXPECTED);
        }
        for (Path file : files.values()) {
            if (Files.exists(pack) && Files.isSameFile(file, pack)) {
                throw wrong("--out " + pack + " is a file of the world itself");
            }
        }
        WorldPack.write(pack, files, made);
        var names = new TreeSet<>(files.keySet());
        names.addAll(made.keySet());
        List<String> trusted = new ArrayList<>();
        if (names.stream().anyMatch(each -> each.endsWith(".so"))) {
            trusted.add("native code");
        }
        if (names.stream().anyMatch(each -> each.endsWith(".py"))) {
            trusted.add("Python");
        }
        if (json) {
            printJson(world, pack, names, !trusted.isEmpty());
            return;
        }
        PrintWriter err = spec.commandLine().getErr();
        world.notes.forEach(note -> err.println("reve: " + note));
        err.flush();
        PrintWriter output = spec.commandLine().getOut();
        output.printf(
                "%s: %s%s, %d files, %d bytes%s%n",
                pack,
                world.world,
                world.frame.map(number -> " at frame " + number).orElse(""),
                names.size(),
                Files.size(pack),
                trusted.isEmpty()
                        ? ""
                        : "; it contains "
                                + String.join(" and ", trusted)
                                + ", which needs --trust where it runs");
        output.flush();
    }

    private void printJson(Made world, Path pack, SortedSet<String> names, boolean needsTrust)
            throws IOException {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("pack", pack.toString());
        fields.put("world", world.world);
        world.frame.ifPresent(number -> fields.put("frame", number));
        fields.put("files", names);
        fields.put("bytes", Files.size(pack));
        fields.put("needsTrust", needsTrust);
        fields.put("notes", world.notes);
        fields.put("warnings", Warnings.fields(world.warnings));
        Json.print(spec, fields);
    }

    /** Returns the path of the pack. Its default name is that of the world or the recording. */
    private Path target(Path source) throws IOException {
        Path name = source.toAbsolutePath().normalize();
        Path called = name.endsWith(WorldFile.NAME) ? name.getParent() : name;
        String base =
                called == null || called.getFileName() == null
                        ? "world"
                        : called.getFileName().toString().replaceFirst("\\.(ya?ml|log|db)$", "");
        Path given = out.orElse(Path.of(base + WorldPack.ENDING));
        WritableFile.require(spec, "--out", given, WritableFile.PACK, "a pack");
        return given;
    }
}
