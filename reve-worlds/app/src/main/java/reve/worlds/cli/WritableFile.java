// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;

/** A check of a file that a command will write. */
final class WritableFile {
    private WritableFile() {}

    /**
     * Returns the path to write: the absolute path, or the target of a link. Before the command
     * starts its work, refuses a path whose folder cannot be written to, and a path that is a
     * folder, a device or a pipe.
     */
    static Path require(CommandSpec spec, String option, Path given) throws IOException {
        Path file = given.toAbsolutePath().normalize();
        if (Files.isDirectory(file)) {
            throw refused(spec, option, given, "is a folder, expected a file");
        }
        if (!Files.isDirectory(file.getParent())) {
            throw refused(
                    spec,
                    option,
                    given,
                    "there is no folder " + file.getParent() + "; make it first");
        }
        if (Files.exists(file) && !Files.isRegularFile(file)) {
            throw refused(spec, option, given, "is a device or a pipe, expected a file");
        }
        Path target = Files.isSymbolicLink(file) && Files.exists(file) ? file.toRealPath() : file;
        if (!Files.isWritable(target.getParent())) {
            throw refused(
                    spec,
                    option,
                    given,
                    "the folder " + target.getParent() + " cannot be written to");
        }
        return target;
    }

    private static ParameterException refused(
            CommandSpec spec, String option, Path given, String reason) {
        return new ParameterException(spec.commandLine(), option + " " + given + ": " + reason);
    }
}
