// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.worlds.journal.RecordingPlan;

import java.nio.file.Path;
import java.util.Optional;

/** Whether and how far a run is recorded. */
final class RecordOptions {
    private static final long MEBIBYTE = 1L << 20;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--record",
            paramLabel = "FILE",
            description =
                    "Record the run, for the command replay. A recording that FILE holds becomes"
                            + " FILE.1. Of several worlds: a folder, in which each has WORLD.log.")
    private Optional<Path> file = Optional.empty();

    @Option(
            names = "--record-limit",
            paramLabel = "MIB",
            description =
                    "Size at which the recording ends, and the run goes on [MiB] "
                            + "(default: none).")
    private Optional<Integer> limit = Optional.empty();

    @Option(
            names = "--record-keep",
            paramLabel = "N",
            description =
                    "Older recordings that are kept, FILE.1 to FILE.N (default: "
                            + RecordingPlan.DEFAULT_KEEP
                            + ").")
    private Optional<Integer> keep = Optional.empty();

    Optional<Path> file() {
        return file;
    }

    /**
     * How to record, if a recording is wanted.
     *
     * @throws ParameterException if the options do not fit together
     */
    Optional<RecordingPlan> plan() {
        PartnerOption.requireCount(spec, "--record-limit", limit, "--record FILE", file);
        PartnerOption.requireCount(spec, "--record-keep", keep, "--record FILE", file);
        long maxBytes = limit.map(size -> size * MEBIBYTE).orElse(Long.MAX_VALUE);
        return file.map(
                path -> new RecordingPlan(path, maxBytes, keep.orElse(RecordingPlan.DEFAULT_KEEP)));
    }
}
