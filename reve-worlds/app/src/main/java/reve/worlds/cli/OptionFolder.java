// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import reve.core.disk.Reason;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;

/** A folder that an option names. */
final class OptionFolder {
    private OptionFolder() {}

    /**
     * Returns where a demonstration writes unless its option names a folder: in the folder build of
     * a checkout, or beside the working folder's files if an installed release runs, whose own
     * folder may be read-only.
     */
    static Path ofDemo(String name) {
        Path build = Path.of(System.getProperty("reve.root", "."), "build");
        return Files.isDirectory(build) ? build.resolve(name) : Path.of("reve-" + name);
    }

    /**
     * Creates the folder if it is missing. Does not create its parent, because a missing parent
     * probably means a typing error.
     *
     * @throws ParameterException if the path is not a folder, or its parent does not exist
     */
    static void make(CommandSpec spec, String option, Path given) {
        Path folder = given.toAbsolutePath().normalize();
        if (Files.isDirectory(folder)) {
            return;
        }
        if (Files.exists(folder)) {
            throw refused(spec, option, given, "is a file, expected a folder");
        }
        if (!Files.isDirectory(folder.getParent())) {
            throw refused(
                    spec,
                    option,
                    given,
                    "there is no folder " + folder.getParent() + "; make it first");
        }
        try {
            Files.createDirectory(folder);
        } catch (IOException e) {
            throw refused(spec, option, given, "it cannot be made: " + Reason.of(e));
        }
    }

    private static ParameterException refused(
            CommandSpec spec, String option, Path given, String reason) {
        return new ParameterException(spec.commandLine(), option + " " + given + ": " + reason);
    }
}
