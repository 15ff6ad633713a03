package reve.worlds.cli;

import java.nio.file.Path;
import java.util.Optional;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;
import reve.core.agent.AuditPlan;

/** Whether and how a server records what it sends to clients. */
final class AuditOptions {
    private static final long MEBIBYTE = 1L << 20;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(names = "--audit", paramLabel = "FILE",
            description = "Append what each client is told, and when, as one JSON object per "
                    + "message.")
    private Optional<Path> file = Optional.empty();

    @Option(names = "--audit-size", paramLabel = "MIB", defaultValue = "64",
            description = "Size at which the audit file becomes FILE.1 and a new one begins [MiB] "
                    + "(default: ${DEFAULT-VALUE}).")
    private int size;

    @Option(names = "--audit-keep", paramLabel = "N", defaultValue = "8",
            description = "Older audit files that are kept, FILE.1 to FILE.N "
                    + "(default: ${DEFAULT-VALUE}).")
    private int keep;

    @Option(names = "--audit-required",
            description = "Disconnect clients while the audit file cannot be written, instead of "
                    + "serving them without a record.")
    private boolean required;

    Optional<Path> file() {
        return file;
    }

    /** @throws ParameterException if the options do not fit together */
    Optional<AuditPlan> plan() {
        if (size < 1 || keep < 1) {
            throw new ParameterException(spec.commandLine(), "--audit-size is " + size
                    + " and --audit-keep is " + keep + ", expected 1 or more for each");
        }
        if (required && file.isEmpty()) {
            throw new ParameterException(spec.commandLine(),
                    "--audit-required takes --audit FILE; found none");
        }
        return file.map(path -> new AuditPlan(path, size * MEBIBYTE, keep, required));
    }
}
