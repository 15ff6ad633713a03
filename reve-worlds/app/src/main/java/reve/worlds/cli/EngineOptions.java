// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;

import reve.core.file.WorldDescription;
import reve.worlds.server.LawPath;

import java.util.Optional;

/** The options that state how the engine runs the laws of a world. */
final class EngineOptions {
    private static final int MAX_THREADS = 256;

    @Option(
            names = "--threads",
            paramLabel = "N",
            description =
                    "Maximum number of threads that the laws of a world share (default: that of the"
                            + " world file, or 1). Results do not depend on it.")
    private Optional<Integer> threads = Optional.empty();

    @Option(
            names = "--validate",
            description =
                    "Hold laws to their declarations: each runs on guarded copies, and an access"
                            + " that it did not declare is a fault. Slower.")
    private boolean validate;

    /** Returns a copy of a world's description that has the number of threads from the options. */
    WorldDescription of(CommandSpec spec, WorldDescription world) {
        if (threads.isPresent() && (threads.get() < 1 || threads.get() > MAX_THREADS)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--threads is " + threads.get() + ", expected 1 to " + MAX_THREADS);
        }
        return threads.map(world::withThreads).orElse(world);
    }

    LawPath of(LawPath path) {
        return path.withValidation(validate);
    }
}
