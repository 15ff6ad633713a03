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

/** The options that name the folder of laws and permit native code. */
final class LawOptions {
    @Option(
            names = "--laws",
            paramLabel = "DIR",
            description =
                    "Folder to search for the laws that a world names, besides the shipped ones."
                            + " serve watches it: it loads new libraries and unloads removed ones.")
    private Optional<Path> folder = Optional.empty();

    @Option(
            names = "--trust",
            description =
                    "Open native code that comes with the world, the store or the "
                            + "recording. The code runs with all of your rights.")
    private boolean trust;

    /** Returns the operator's folder of laws. */
    Optional<Path> folder() {
        return folder;
    }

    /**
     * Returns the law path for a command, without the laws that come with a world.
     *
     * @throws ParameterException if {@code --laws} names no folder, or a world-writable one
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
