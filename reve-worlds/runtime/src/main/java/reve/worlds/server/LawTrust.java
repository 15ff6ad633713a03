// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.pe.PreparedLibrary;
import reve.pe.adapter.LawLibrary;

import java.io.IOException;
import java.nio.file.DirectoryStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Set;
import java.util.TreeSet;

/** The reason why a server executes a law library, for operators. For any thread. */
final class LawTrust {
    private static final Logger LOG = LoggerFactory.getLogger("laws");

    private final Path shipped;
    private volatile Set<String> hashes = Set.of();

    /**
     * @param shipped folder of the laws that ship
     */
    LawTrust(Path shipped) {
        this.shipped = shipped;
    }

    /** Reads the SHA-256 of the laws that ship, unless they were read. Blocks on file access. */
    void read() {
        if (!hashes.isEmpty()) {
            return;
        }
        Set<String> found = new TreeSet<>();
        try (DirectoryStream<Path> files = Files.newDirectoryStream(shipped, "*.{so,law,py}")) {
            for (Path file : files) {
                if (Files.size(file) <= PreparedLibrary.MAX_BYTES) {
                    found.add(LawFiles.sha256(Files.readAllBytes(file)));
                }
            }
        } catch (IOException unreadable) {
            LOG.debug("{} cannot be read: {}", shipped, unreadable.toString());
        }
        hashes = found;
    }

    /**
     * Returns {@code untrusted} for a library that runs in a sandbox, {@code shipped} for the bytes
     * of a law that ships, {@code text} for another law as text, and {@code operator} for native
     * code or Python that the operator lets run with the rights of the account.
     */
    String of(LawLibrary library, boolean apart) {
        if (apart) {
            return "untrusted";
        }
        if (hashes.contains(library.sha256())) {
            return "shipped";
        }
        return library.isText() ? "text" : "operator";
    }
}
