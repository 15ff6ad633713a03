// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Optional;

/**
 * The file from which PostgreSQL's driver reads passwords. The environment variable {@code
 * PGPASSFILE} names it; the default is {@code ~/.pgpass}. For any thread.
 */
final class PasswordFile {
    private static final long MAX_BYTES = 1 << 20;

    private PasswordFile() {}

    /**
     * Checks that the driver can read the file without blocking. Accepts a missing file.
     *
     * @throws IOException naming the file if it is not a regular file, for example a pipe, or if it
     *     is larger than 1 MiB
     */
    static void check() throws IOException {
        check(
                Optional.ofNullable(System.getenv("PGPASSFILE"))
                        .map(Path::of)
                        .orElse(Path.of(System.getProperty("user.home"), ".pgpass")));
    }

    static void check(Path file) throws IOException {
        if (!Files.exists(file)) {
            return;
        }
        if (!Files.isRegularFile(file)) {
            throw new IOException(
                    file
                            + " is not a regular file, expected lines of the form"
                            + " HOST:PORT:DATABASE:USER:PASSWORD; remove it, or set the environment"
                            + " variable PGPASSFILE to another file");
        }
        if (Files.size(file) > MAX_BYTES) {
            throw new IOException(
                    file
                            + " has "
                            + Files.size(file)
                            + " bytes, expected at most "
                            + MAX_BYTES
                            + " bytes of lines HOST:PORT:DATABASE:USER:PASSWORD");
        }
    }
}
