// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.pe.adapter.LawLibrary;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.ArrayList;
import java.util.List;

/**
 * The file of known law libraries: the shipped libraries of worlds that this account stored or
 * recorded, by the SHA-256 of their bytes. Because of it, a store still opens without {@code
 * --trust} after an upgrade of the release has changed these libraries. The file belongs to the
 * account; stores and recordings cannot add to it. For any thread.
 */
final class KnownLaws {
    private static final Logger LOG = LoggerFactory.getLogger("laws");
    private static final Path FILE = folder().resolve("known-laws");

    private KnownLaws() {}

    /** Returns whether a library with these bytes is known to this account. */
    static boolean contains(String sha256) {
        try {
            return Files.exists(FILE)
                    && Files.readAllLines(FILE).stream().anyMatch(line -> line.startsWith(sha256));
        } catch (IOException unreadable) {
            LOG.warn("{} cannot be read: {}", FILE, unreadable.toString());
            return false;
        }
    }

    /** Adds libraries to the file. Blocks on file access. */
    static synchronized void keep(List<LawLibrary> libraries) {
        List<String> lines = new ArrayList<>();
        for (LawLibrary library : libraries) {
            if (!contains(library.sha256())) {
                lines.add(library.sha256() + "  " + library.name());
            }
        }
        if (lines.isEmpty()) {
            return;
        }
        try {
            Files.createDirectories(
                    FILE.getParent(),
                    PosixFilePermissions.asFileAttribute(
                            PosixFilePermissions.fromString("rwx------")));
            Files.write(FILE, lines, StandardOpenOption.CREATE, StandardOpenOption.APPEND);
        } catch (IOException unwritable) {
            LOG.info(
                    "{} cannot be written, so stores of these laws need --trust after an upgrade:"
                            + " {}",
                    FILE,
                    unwritable.toString());
        }
    }

    private static Path folder() {
        String state = System.getenv("XDG_STATE_HOME");
        return state == null || state.isBlank()
                ? Path.of(System.getProperty("user.home"), ".local", "state", "reve")
                : Path.of(state, "reve");
    }
}
