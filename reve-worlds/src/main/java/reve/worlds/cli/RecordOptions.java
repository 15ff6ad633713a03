package reve.worlds.cli;

import java.nio.file.Path;
import java.util.Optional;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

/** Whether and how far a run is recorded. */
final class RecordOptions {
    private static final long MEBIBYTE = 1L << 20;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(names = "--record", paramLabel = "FILE",
            description = "Record the run, for ./reve replay. "
                    + "Of several worlds: a folder, in which each has WORLD.log.")
    private Optional<Path> file = Optional.empty();

    @Option(names = "--record-limit", paramLabel = "MIB",
            description = "Size at which the recording ends, and the run goes on [MiB] "
                    + "(default: none).")
    private Optional<Integer> limit = Optional.empty();

    Optional<Path> file() {
        return file;
    }

    /**
     * The size at which the recording ends [bytes].
     *
     * @throws ParameterException if it is no size, or there is no recording
     */
    long maxBytes() {
        if (limit.isPresent() && (limit.get() < 1 || file.isEmpty())) {
            throw new ParameterException(spec.commandLine(), limit.get() < 1
                    ? "--record-limit is " + limit.get() + ", expected 1 MiB or more"
                    : "--record-limit takes --record FILE; found none");
        }
        return limit.map(size -> size * MEBIBYTE).orElse(Long.MAX_VALUE);
    }
}
