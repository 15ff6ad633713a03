// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.image.CorruptException;
import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;
import reve.pe.PreparedLibrary;
import reve.pe.adapter.LawLibrary;
import reve.worlds.server.History;
import reve.worlds.server.LawPath;
import reve.worlds.server.StoredRun;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.SortedMap;
import java.util.TreeMap;

/**
 * The world of a recording or a store at the end of one frame, and the files that it needs on
 * another machine.
 *
 * @param frame the number of the frame
 * @param files meshes and images by their names in a pack
 * @param made the world file, the laws and the expected results by their names in a pack
 * @param notes one message for each part of the state that the pack does not contain
 */
record PackedRecording(
        WorldDescription world,
        long frame,
        SortedMap<String, Path> files,
        SortedMap<String, byte[]> made,
        List<String> notes) {
    /** Maximum world time of the expected results [s]. */
    private static final long EXPECTED_SECONDS = 10;

    /**
     * The frame to pack.
     *
     * @param at time after the first state [s]
     * @param frame number of the frame; at most one of both is present, none means the last frame
     */
    record Moment(Optional<Double> at, Optional<Long> frame) {
        private long of(CommandSpec spec, History history) {
            return frame.orElseGet(
                    () -> {
                        long since = Frames.of(spec, "--at", at, history.timing());
                        return since == Long.MAX_VALUE ? since : history.frame() + since;
                    });
        }
    }

    /**
     * Repeats a recording or a store up to a frame, and collects the files of its world.
     *
     * @param worldFile the world file of the run; if empty, the {@value WorldFile#NAME} in the
     *     folder that the recording names
     */
    static PackedRecording of(
            CommandSpec spec,
            Path recording,
            LawPath laws,
            Optional<WorldArgument> worldFile,
            Moment moment)
            throws IOException, WorldFileException, AssetException {
        Optional<Path> folder =
                worldFile.isEmpty() ? Optional.empty() : Optional.of(worldFile.get().folder());
        Optional<WorldDescription> given =
                worldFile.isEmpty() ? Optional.empty() : Optional.of(worldFile.get().read());
        try (History history = new History(StoredRun.open(recording, laws, given, folder))) {
            goTo(spec, recording, history, moment);
            List<String> notes = new ArrayList<>();
            Optional<WorldDescription> rest =
                    given.isPresent() ? given : found(recording, history, notes);
            WorldDescription world = history.description(rest);
            long frame = history.frame();
            byte[] text = WorldFile.encode(world);
            SortedMap<String, byte[]> made = new TreeMap<>(Map.of(WorldFile.NAME, text));
            for (LawLibrary law : history.ownLaws()) {
                made.put(PackedFiles.inLaws(fileOf(law)), law.bytes());
            }
            notes.addAll(history.ruleProblems());
            List<String> left = notContained(history);
            left.forEach(each -> notes.add("the pack does not contain " + each));
            for (LawLibrary law : history.otherVersions()) {
                notes.add(
                        recording
                                + " contains another version of the law '"
                                + law.name()
                                + "' than this release; the pack uses the law of the release that"
                                + " runs it");
            }
            SortedMap<String, Path> files =
                    files(recording, text, folder.orElseGet(history::folder), folder.isPresent());
            if (left.isEmpty() && history.otherVersions().isEmpty()) {
                addExpected(history, made);
            }
            return new PackedRecording(world, frame, files, made, List.copyOf(notes));
        }
    }

    private static void goTo(CommandSpec spec, Path recording, History history, Moment moment) {
        if (!history.next()) {
            throw new CorruptException(
                    recording
                            + " ends before the first image of the world: there is nothing to pack");
        }
        long first = history.frame();
        long wanted = moment.of(spec, history);
        if (wanted < first) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--frame is " + wanted + ", but " + recording + " begins with frame " + first);
        }
        Progress progress = new Progress(System.err, 0);
        while (history.frame() < wanted && history.next()) {
            progress.at("frame " + history.frame(), history.part());
        }
        progress.done();
        if (history.frame() < wanted && wanted != Long.MAX_VALUE) {
            throw new ParameterException(
                    spec.commandLine(),
                    recording
                            + " ends at frame "
                            + history.frame()
                            + ", "
                            + (double) (history.frame() - first)
                                    / history.timing().framesPerSecond()
                            + " s after its first state, expected frame "
                            + wanted);
        }
    }

    /** Returns the world file in the folder that the recording names, if it is the right one. */
    private static Optional<WorldDescription> found(
            Path recording, History history, List<String> notes) {
        Path own = history.folder().resolve(WorldFile.NAME);
        String reason = "there is no such file";
        if (Files.isRegularFile(own)) {
            try {
                WorldDescription found = WorldFile.loadFolder(history.folder());
                history.requireSame(found);
                return Optional.of(found);
            } catch (WorldFileException | CorruptException | IOException other) {
                reason = String.valueOf(other.getMessage()).lines().findFirst().orElse("");
            }
        }
        notes.add(
                recording
                        + (history.hasChangedRules()
                                ? " contains no camera, no agents, and only the rules that were"
                                        + " changed while the world ran, and so does the pack,"
                                        + " because "
                                : " contains no camera, agents and rules, and the pack has none,"
                                        + " because ")
                        + own
                        + " is not used ("
                        + reason
                        + "); name the world file with --world WORLD");
        return Optional.empty();
    }

    private static SortedMap<String, Path> files(
            Path recording, byte[] text, Path folder, boolean isChosen)
            throws WorldFileException, AssetException {
        List<String> named = new ArrayList<>();
        WorldFolder files =
                isChosen
                        ? new WorldFolder(folder, named::add)
                        : WorldFolder.named(folder, named::add);
        WorldFile.parse(recording + "/" + WorldFile.NAME, text, files);
        SortedMap<String, Path> found = new TreeMap<>();
        for (String name : List.copyOf(named)) {
            found.put(name, files.find(name));
        }
        return found;
    }

    /** Returns the parts of the state that a world file lacks. A new world has none of them. */
    private static List<String> notContained(History history) {
        return history.frame() == 0 ? List.of() : history.notDescribed();
    }

    private static String fileOf(LawLibrary law) {
        List<String> names = LawPath.filesOf(law.name());
        return PreparedLibrary.isPython(law.bytes()) ? names.getLast() : names.getFirst();
    }

    /**
     * Adds the hash of the last frame, up to which the world of the pack has the bits of the
     * recorded run. This is the frame before the next change that laws did not cause.
     */
    private static void addExpected(History history, SortedMap<String, byte[]> made) {
        long most = EXPECTED_SECONDS * history.timing().framesPerSecond();
        long frames = 0;
        long hash = 0;
        while (frames < most && history.next() && !history.isChanged()) {
            frames++;
            hash = history.stateHash();
        }
        if (frames > 0) {
            Map<String, Object> expected = new LinkedHashMap<>();
            expected.put("doc", "State after `frames` frames, as `./reve run --json` prints it.");
            expected.put("frames", frames);
            expected.put("seconds", (double) frames / history.timing().framesPerSecond());
            expected.put("stateHash", String.format(Locale.ROOT, "%016x", hash));
            made.put(
                    PackedFiles.EXPECTED,
                    (Json.text(expected) + "\n").getBytes(StandardCharsets.UTF_8));
        }
    }
}
