// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.core.agent.AuditPlan;

import java.nio.file.Path;
import java.util.Optional;

/** Whether and how a server records what it sends to clients. */
final class AuditOptions {
    private static final long MEBIBYTE = 1L << 20;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--audit",
            paramLabel = "FILE",
            description =
                    "Append what each client is told, and when, as one JSON object per "
                            + "message.")
    private Optional<Path> file = Optional.empty();

    @Option(
            names = "--audit-size",
            paramLabel = "MIB",
            description =
                    "Size at which the audit file becomes FILE.1 and a new one begins [MiB] "
                            + "(default: "
                            + AuditPlan.DEFAULT_BYTES / MEBIBYTE
                            + ").")
    private Optional<Integer> size = Optional.empty();

    @Option(
            names = "--audit-keep",
            paramLabel = "N",
            description =
                    "Older audit files that are kept, FILE.1 to FILE.N "
                            + "(default: "
                            + AuditPlan.DEFAULT_KEEP
                            + ").")
    private Optional<Integer> keep = Optional.empty();

    @Option(
            names = "--audit-required",
            description =
                    "Disconnect clients while the audit file cannot be written, instead of "
                            + "serving them without a record.")
    private boolean required;

    Optional<Path> file() {
        return file;
    }

    /**
     * @throws ParameterException if the options do not fit together
     */
    Optional<AuditPlan> plan() {
        PartnerOption.requireCount(spec, "--audit-size", size, "--audit FILE", file);
        PartnerOption.requireCount(spec, "--audit-keep", keep, "--audit FILE", file);
        PartnerOption.require(spec, "--audit-required", required, "--audit FILE", file);
        long bytes = size.map(each -> each * MEBIBYTE).orElse(AuditPlan.DEFAULT_BYTES);
        return file.map(
                path -> new AuditPlan(path, bytes, keep.orElse(AuditPlan.DEFAULT_KEEP), required));
    }
}
