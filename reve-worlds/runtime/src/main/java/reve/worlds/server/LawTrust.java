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
     * Returns why the server executes a library:
     *
     * <ul>
     *   <li>{@code untrusted}: the library runs in a sandbox;
     *   <li>{@code shipped}: its bytes are those of a law that ships;
     *   <li>{@code text}: it is a law as text that does not ship;
     *   <li>{@code operator}: it is native code or Python, and the operator permits it to run with
     *       the rights of the account.
     * </ul>
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
