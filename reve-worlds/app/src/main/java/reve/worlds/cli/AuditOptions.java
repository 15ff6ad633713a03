// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.core.agent.audit.AuditPlan;

import java.nio.file.Path;
import java.util.Optional;

/**
 * The options for the audit record, which is a file of the messages that the server sends to
 * clients.
 */
final class AuditOptions {
    private static final long MEBIBYTE = 1L << 20;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--audit",
            paramLabel = "FILE",
            description =
                    "Append each message to a client, with its time, as one JSON object per "
                            + "message.")
    private Optional<Path> file = Optional.empty();

    @Option(
            names = "--audit-size",
            paramLabel = "MIB",
            description =
                    "Size at which the audit file is renamed to FILE.1 and a new one begins [MiB] "
                            + "(default: "
                            + AuditPlan.DEFAULT_BYTES / MEBIBYTE
                            + ").")
    private Optional<Integer> size = Optional.empty();

    @Option(
            names = "--audit-keep",
            paramLabel = "N",
            description =
                    "Number of older audit files that are kept, FILE.1 to FILE.N "
                            + "(default: "
                            + AuditPlan.DEFAULT_KEEP
                            + ").")
    private Optional<Integer> keep = Optional.empty();

    @Option(
            names = "--audit-required",
            description =
                    "Disconnect clients if the audit file cannot be written, instead of "
                            + "serving them without a record.")
    private boolean required;

    Optional<Path> file() {
        return file;
    }

    /**
     * Returns the audit plan, or empty if no audit was requested.
     *
     * @throws ParameterException if the options contradict each other
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
