// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.worlds.journal.RecordingPlan;

import java.nio.file.Path;
import java.util.Optional;

/** The options that control the recording of a run. */
final class RecordOptions {
    private static final long MEBIBYTE = 1L << 20;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--record",
            paramLabel = "FILE",
            description =
                    "Record the run for the command replay. An existing recording becomes"
                            + " FILE.1. With several worlds, FILE is a folder with a log for each.")
    private Optional<Path> file = Optional.empty();

    @Option(
            names = "--record-limit",
            paramLabel = "MIB",
            description =
                    "Size at which the recording ends while the run continues [MiB] "
                            + "(default: none).")
    private Optional<Integer> limit = Optional.empty();

    @Option(
            names = "--record-keep",
            paramLabel = "N",
            description =
                    "Number of older recordings that are kept, FILE.1 to FILE.N (default: "
                            + RecordingPlan.DEFAULT_KEEP
                            + ").")
    private Optional<Integer> keep = Optional.empty();

    Optional<Path> file() {
        return file;
    }

    /**
     * Returns the recording plan, or empty if no recording was requested.
     *
     * @throws ParameterException if the options contradict each other
     */
    Optional<RecordingPlan> plan() {
        PartnerOption.requireCount(spec, "--record-limit", limit, "--record FILE", file);
        PartnerOption.requireCount(spec, "--record-keep", keep, "--record FILE", file);
        long maxBytes = limit.map(size -> size * MEBIBYTE).orElse(Long.MAX_VALUE);
        return file.map(
                path -> new RecordingPlan(path, maxBytes, keep.orElse(RecordingPlan.DEFAULT_KEEP)));
    }
}
