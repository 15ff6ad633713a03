package reve.worlds.cli;

import java.nio.file.Files;
import java.nio.file.Path;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

/** A file that a command is going to write. */
final class WritableFile {
    private WritableFile() {}

    /** Its absolute path; refuses what is a folder or in none, before any work is done for it. */
    static Path require(CommandSpec spec, String option, Path given) {
        Path file = given.toAbsolutePath().normalize();
        if (file.getParent() == null || !Files.isDirectory(file.getParent())) {
            throw new ParameterException(spec.commandLine(),
                    option + " " + given + ": there is no folder " + file.getParent()
                    + "; make it first");
        }
        if (Files.isDirectory(file)) {
            throw new ParameterException(spec.commandLine(),
                    option + " " + given + ": is a folder, expected a file");
        }
        return file;
    }
}
