// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;

import reve.pe.adapter.LawFolder;
import reve.worlds.Product;
import reve.worlds.server.LawPath;

import java.nio.file.Path;
import java.util.Optional;

/** Where a command finds laws, and which native code it may open. */
final class LawOptions {
    @Option(
            names = "--laws",
            paramLabel = "DIR",
            description =
                    "Folder of law libraries: the laws that a world names are looked for here, too."
                            + " serve watches it: libraries dropped here act, removed ones stop.")
    private Optional<Path> folder = Optional.empty();

    @Option(
            names = "--trust",
            description =
                    "Open native code that comes with the world, the store or the "
                            + "recording. It runs with all of your rights.")
    private boolean trust;

    /** The operator's folder. */
    Optional<Path> folder() {
        return folder;
    }

    /**
     * The rule for all commands, without the laws of a world's own.
     *
     * @throws ParameterException if {@code --laws} names no folder, or one that everybody may write
     *     to
     */
    LawPath path(CommandSpec spec) {
        try {
            folder.ifPresent(LawFolder::require);
        } catch (IllegalArgumentException unfit) {
            throw new ParameterException(spec.commandLine(), "--laws: " + unfit.getMessage());
        }
        return new LawPath(Product.nativeFolder().resolve("laws"), folder, Optional.empty(), trust);
    }
}
