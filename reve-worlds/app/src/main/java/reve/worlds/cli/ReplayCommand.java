// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.image.CorruptException;
import reve.pe.PhysicsException;
import reve.worlds.journal.JournalRecord;
import reve.worlds.server.LawPath;
import reve.worlds.server.Replay;
import reve.worlds.server.Simulation;
import reve.worlds.server.StoredRun;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;
import java.util.stream.Collectors;

/** The command {@code replay}: repeats a recorded run and compares every bit. */
@Command(
        name = "replay",
        description =
                "Repeats a recording or a store and compares every bit; reports the first"
                        + " difference.")
public final class ReplayCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            paramLabel = "FILE|WORLD",
            description =
                    "Recording that --record wrote, or store that serve --store wrote; with --store"
                            + " URL the name of a world.")
    private Path file = Path.of("");

    @Mixin private SharedWorld shared = new SharedWorld();

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Option(
            names = "--until",
            paramLabel = "FRAME",
            defaultValue = "9223372036854775807",
            description = "Stop after this frame (default: the last one).")
    private long until;

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        plugins.use();
        if (until < 0) {
            throw new ParameterException(
                    spec.commandLine(), "--until is " + until + ", expected a frame from 0 on");
        }
        try (StoredRun records = open()) {
            Replay replay = records.replay();
            Progress progress = new Progress(System.err, 0);
            long last = Math.min(until, records.lastFrame());
            while (records.hasNext() && take(replay, records.next())) {
                long left = Math.max(0, last - replay.frame());
                double all = Math.max(1, replay.frames() + left);
                progress.at("frame " + replay.frame(), replay.frames() / all);
            }
            progress.done();
            boolean same = replay.divergence().isEmpty();
            if (replay.frame() < 0) {
                throw new CorruptException(
                        file
                                + " ends before the first image of the world: "
                                + "there is nothing to replay");
            }
            try (Simulation simulation = replay.release()) {
                report(replay, simulation, records.wasCut());
            }
            return same ? ExitCode.OK : ExitCode.FAILURE;
        }
    }

    private StoredRun open() throws IOException {
        LawPath path = laws.path(spec);
        Optional<SharedWorld.Found> found = shared.find(file);
        return found.isPresent() ? found.get().open(path) : StoredRun.open(file, path);
    }

    private boolean take(Replay replay, JournalRecord record) {
        try {
            return replay.take(record, until);
        } catch (CorruptException meaningless) {
            throw new CorruptException(
                    place(replay) + meaningless.getMessage() + missing(replay), meaningless);
        } catch (PhysicsException refused) {
            throw new PhysicsException(refused.status(), place(replay) + refused.getMessage());
        }
    }

    /** Returns the plugins that are missing, as the end of a message. */
    private static String missing(Replay replay) {
        return replay.missingPlugins().stream()
                .map(problem -> "; " + problem)
                .collect(Collectors.joining());
    }

    private String place(Replay replay) {
        return file + (replay.frame() < 0 ? "" : ", after frame " + replay.frame()) + ": ";
    }

    private void report(Replay replay, Simulation simulation, boolean cut) throws IOException {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("identical", replay.divergence().isEmpty());
        fields.put("frames", replay.frames());
        fields.put("frame", simulation.loop().frame());
        fields.put(
                "stateHash", String.format(Locale.ROOT, "%016x", simulation.physics().stateHash()));
        fields.put("cut", cut);
        if (!replay.missingPlugins().isEmpty()) {
            fields.put("missingPlugins", replay.missingPlugins());
        }
        if (!replay.changedRules().isEmpty()) {
            fields.put("changedRules", replay.changedRules());
        }
        replay.divergence().ifPresent(found -> fields.put("difference", found.fields()));
        if (json) {
            Json.print(spec, fields);
            return;
        }
        PrintWriter err = spec.commandLine().getErr();
        replay.missingPlugins().forEach(problem -> err.println("reve: " + problem));
        err.flush();
        var out = spec.commandLine().getOut();
        if (cut) {
            out.println("the recording ends in the middle of a record, as after a crash");
        }
        out.println(
                replay.divergence()
                        .map(found -> "different: " + found.message())
                        .orElse("identical: " + replay.frames() + " frames"));
        if (until != Long.MAX_VALUE
                && simulation.loop().frame() < until
                && replay.divergence().isEmpty()) {
            out.println(
                    "the recording ends at frame "
                            + simulation.loop().frame()
                            + ", before frame "
                            + until);
        }
        out.println("state hash: " + fields.get("stateHash"));
        out.flush();
    }
}
