// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;

/** A check of a file that a command will write. */
final class WritableFile {
    private static final int MARK_BYTES = 65_536;

    /** The first characters of every pack file. */
    static final String PACK = "PK\u0003\u0004";

    private WritableFile() {}

    /**
     * Returns the path to which a command writes: the absolute path, or the target of a link. The
     * check runs before the command starts its work. It refuses a folder, a device and a pipe, and
     * a path whose folder cannot be written to.
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

    /**
     * Checks the path like {@link #require}. Also refuses an existing file of another kind, such as
     * a database or a file with secrets, so that a mistyped name does not destroy this file.
     *
     * @param mark text that every file of the right kind contains in its first 64 KiB
     * @param kind name of this kind, for messages
     */
    static Path require(CommandSpec spec, String option, Path given, String mark, String kind)
            throws IOException {
        Path file = require(spec, option, given);
        if (Files.exists(file) && Files.size(file) > 0) {
            try (InputStream in = Files.newInputStream(file)) {
                String begin = new String(in.readNBytes(MARK_BYTES), StandardCharsets.ISO_8859_1);
                boolean isPack =
                        begin.startsWith(PACK) && !mark.equals(PACK); // a pack may contain any mark
                if (isPack || !begin.contains(mark)) {
                    throw refused(
                            spec,
                            option,
                            given,
                            "exists and is not " + kind + "; name another file, or remove it");
                }
            }
        }
        return file;
    }

    private static ParameterException refused(
            CommandSpec spec, String option, Path given, String reason) {
        return new ParameterException(spec.commandLine(), option + " " + given + ": " + reason);
    }
}
