// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.disk.PartFile;
import reve.core.disk.Reason;
import reve.pe.adapter.LawLibrary;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.function.Predicate;

/**
 * The file of known law libraries. A library is known if it shipped with the release or was in the
 * operator's folder when this account stored or recorded worlds. Libraries are identified by the
 * SHA-256 of their bytes. Known libraries may be replaced later, by an upgrade or by a new version
 * in the folder. A store that contains the old bytes still opens without {@code --trust}. The
 * operator must name the same folder again for a library of a folder.
 *
 * <p>A library that is known from a folder of untrusted laws runs in a sandbox only.
 *
 * <p>A line contains the SHA-256, the name and, for a library of a folder, the folder. The file
 * belongs to the account; stores and recordings cannot add to it. It keeps at most {@link
 * #MOST_LINES} libraries, the newest ones. For any thread.
 */
final class KnownLaws {
    private static final Logger LOG = LoggerFactory.getLogger("laws");
    private static final Path FILE = folder().resolve("known-laws");

    /** Maximum number of libraries. The older half is dropped when the maximum is reached. */
    private static final int MOST_LINES = 10_000;

    /** Separates the name of a library from its folder. */
    private static final String OF = "  of ";

    /** Separates the name of a library from its folder of untrusted laws. */
    private static final String UNTRUSTED_OF = "  untrusted of ";

    private static final long MOST_BYTES = 16L << 20;

    private KnownLaws() {}

    /**
     * Returns whether a library with these bytes is known to this account.
     *
     * @param folder the operator's folder that this command uses
     */
    static boolean contains(String sha256, Optional<Path> folder) {
        return hasLine(
                sha256,
                line ->
                        !line.contains(OF) && !line.contains(UNTRUSTED_OF)
                                || folder.map(own -> line.endsWith(of(OF, own))).orElse(false));
    }

    /**
     * Returns whether a library with these bytes was in this folder of untrusted laws, so it may
     * run in a sandbox.
     */
    static boolean containsUntrusted(String sha256, Path folder) {
        return hasLine(sha256, line -> line.endsWith(of(UNTRUSTED_OF, folder)));
    }

    private static boolean hasLine(String sha256, Predicate<String> isMeant) {
        try {
            return lines().stream().filter(line -> line.startsWith(sha256)).anyMatch(isMeant);
        } catch (IOException unreadable) {
            LOG.warn("{} cannot be read: {}", FILE, unreadable.toString());
            return false;
        }
    }

    private static String of(String separator, Path folder) {
        return separator + folder.toAbsolutePath().normalize();
    }

    /**
     * Adds libraries to the file. Blocks on file access.
     *
     * @param folder the folder that contains the libraries; empty for libraries that ship with the
     *     release
     */
    static void keep(List<LawLibrary> libraries, Optional<Path> folder) {
        keepAll(libraries, folder.map(own -> of(OF, own)).orElse(""));
    }

    /** Adds libraries of a folder of untrusted laws like {@link #keep}. */
    static void keepUntrusted(List<LawLibrary> libraries, Path folder) {
        keepAll(libraries, of(UNTRUSTED_OF, folder));
    }

    private static synchronized void keepAll(List<LawLibrary> libraries, String place) {
        try {
            List<String> present = lines();
            Set<String> known = new HashSet<>(present);
            List<String> lines = new ArrayList<>();
            for (LawLibrary library : libraries) {
                String line = library.sha256() + "  " + library.name() + place;
                if (line.lines().count() == 1 && known.add(line)) {
                    lines.add(line);
                }
            }
            if (lines.isEmpty()) {
                return;
            }
            Files.createDirectories(
                    FILE.getParent(),
                    PosixFilePermissions.asFileAttribute(
                            PosixFilePermissions.fromString("rwx------")));
            if (present.size() + lines.size() > MOST_LINES) {
                List<String> kept =
                        new ArrayList<>(present.subList(present.size() / 2, present.size()));
                kept.addAll(lines);
                Path part = PartFile.create(FILE); // only this process uses this file
                Files.write(part, kept);
                PartFile.move(part, FILE, StandardCopyOption.ATOMIC_MOVE);
                return;
            }
            Files.write(FILE, lines, StandardOpenOption.CREATE, StandardOpenOption.APPEND);
        } catch (IOException unwritable) {
            LOG.warn(
                    "{} cannot be written, so stores of these laws need --trust after they were"
                            + " replaced: {}",
                    FILE,
                    Reason.of(unwritable));
        }
    }

    /** Returns the lines of the file; none if it is missing. */
    private static List<String> lines() throws IOException {
        if (!Files.exists(FILE)) {
            return List.of();
        }
        if (!Files.isRegularFile(FILE) || Files.size(FILE) > MOST_BYTES) {
            throw new IOException("it is no regular file of at most " + MOST_BYTES + " bytes");
        }
        // The text is decoded without a check, so that a damaged byte in one line does not
        // invalidate the other lines.
        return new String(Files.readAllBytes(FILE), StandardCharsets.UTF_8).lines().toList();
    }

    private static Path folder() {
        String state = System.getenv("XDG_STATE_HOME");
        return state == null || state.isBlank()
                ? Path.of(System.getProperty("user.home"), ".local", "state", "reve")
                : Path.of(state, "reve");
    }
}
