// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.disk.Reason;

import java.io.IOException;
import java.io.InputStream;
import java.nio.channels.FileChannel;
import java.nio.channels.FileLock;
import java.nio.file.AccessDeniedException;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.FileAttribute;
import java.nio.file.attribute.PosixFilePermission;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.InstantSource;
import java.util.ArrayList;
import java.util.Collection;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.UnaryOperator;
import java.util.stream.Collectors;

/**
 * The tokens of a server, in a file with access for its owner only. Changes of the file take effect
 * at once. The tokens that were read before stay in effect if the file becomes invalid. For any
 * thread.
 */
public final class TokenFile {

    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");
    private static final long MAX_BYTES = 16L * 1024 * 1024;

    /** Attributes for creating a file that only its owner can access from the start. */
    public static final FileAttribute<Set<PosixFilePermission>> PRIVATE =
            PosixFilePermissions.asFileAttribute(FileVersion.OWNERS);

    private final Path path;
    private final InstantSource clock;
    private final PatientReader reader;

    /** Version of the file that was read; null if it did not exist. */
    private @Nullable FileVersion read;

    private Map<String, AgentToken> tokens;
    private Optional<String> problem = Optional.empty();

    /** The tokens of a version of the file. */
    private record Content(FileVersion version, Map<String, AgentToken> tokens) {}

    private TokenFile(Path path, InstantSource clock) throws IOException {
        this.path = path;
        this.clock = clock;
        this.reader = new PatientReader(path);
        FileVersion version = version(path);
        this.read = version;
        this.tokens = read(path, version);
    }

    /**
     * Opens a file of tokens.
     *
     * @throws IOException if the file does not exist, is accessible to others, or has no valid
     *     tokens; the message names the remedy
     */
    public static TokenFile open(Path path) throws IOException {
        return open(path, InstantSource.system());
    }

    /** Opens the file like {@link #open(Path)}, with another clock for the check of expiry. */
    public static TokenFile open(Path path, InstantSource clock) throws IOException {
        return new TokenFile(path, clock);
    }

    /** Adds a token to a file; creates the file if needed. */
    public static void add(Path path, AgentToken token) throws IOException {
        change(
                path,
                true,
                tokens -> {
                    tokens.add(token);
                    return tokens;
                });
    }

    /**
     * Removes tokens from a file.
     *
     * @param nameOrId a client's name, for all its tokens, or a token's id
     * @return the removed tokens
     */
    public static List<AgentToken> revoke(Path path, String nameOrId) throws IOException {
        var revoked = new ArrayList<AgentToken>();
        change(
                path,
                false,
                tokens -> {
                    tokens.stream()
                            .filter(
                                    token ->
                                            token.name().equals(nameOrId)
                                                    || token.id().equals(nameOrId))
                            .forEach(revoked::add);
                    tokens.removeAll(revoked);
                    return tokens;
                });
        return revoked;
    }

    /** Returns the tokens in the order in which they were added. */
    public Collection<AgentToken> tokens() {
        return refreshed().values();
    }

    /**
     * Returns the token with this secret, unless the token has expired. The time of the lookup
     * reveals nothing about the stored tokens: the lookup uses the hash of the secret, which an
     * attacker cannot choose.
     */
    public Optional<AgentToken> find(String secret) {
        return Optional.ofNullable(refreshed().get(AgentToken.hash(secret)))
                .filter(this::isCurrent);
    }

    /** Returns the tokens that are valid now. */
    public Set<AgentToken> current() {
        return tokens().stream().filter(this::isCurrent).collect(Collectors.toUnmodifiableSet());
    }

    private boolean isCurrent(AgentToken token) {
        return !token.hasExpired(clock.instant());
    }

    /** Returns why the tokens in the file are not in effect; empty if there is no problem. */
    public synchronized Optional<String> problem() {
        refreshed();
        return problem;
    }

    /** Returns the message for the operator that a problem has ended. */
    public synchronized String solved() {
        return path + " was read again: " + tokens.size() + " tokens";
    }

    private synchronized Map<String, AgentToken> refreshed() {
        FileVersion before = read;
        Map<String, AgentToken> known = tokens;
        try {
            Content content =
                    reader.read(
                            () -> {
                                FileVersion now = version(path);
                                return new Content(
                                        now, now.equals(before) ? known : read(path, now));
                            });
            read = content.version();
            if (!content.version().equals(before)) {
                tokens = content.tokens();
                problem = Optional.empty();
                LOG.info("{} was read again: {} tokens", path, tokens.size());
            }
        } catch (IOException e) {
            read = null;
            problem = Optional.of("the tokens stay as they were: " + reason(e));
        }
        return tokens;
    }

    private String reason(IOException e) {
        return e instanceof AccessDeniedException
                ? path + " cannot be read: " + Reason.of(e)
                : e.getMessage();
    }

    private static FileVersion version(Path path) throws IOException {
        FileVersion version;
        try {
            version = FileVersion.of(path);
        } catch (NoSuchFileException e) {
            throw new NoSuchFileException(
                    "there is no file of tokens "
                            + path
                            + "; the command `token new NAME --file "
                            + path
                            + "` makes one");
        }
        if (version.isFolder()) {
            throw new FileSystemException(path + " is a folder, expected a file of tokens");
        }
        if (!version.isFile()) { // reading a pipe would block until a writer opens it
            throw new FileSystemException(
                    path
                            + " is a pipe or a device, expected a file of "
                            + "tokens; name that file");
        }
        return version;
    }

    private static Map<String, AgentToken> read(Path path, FileVersion version) throws IOException {
        if (version.isOpenToOthers()) {
            throw new FileSystemException(version.openToOthers(path));
        }
        if (version.bytes() == 0) { // for example a file of /proc, which may never end
            throw new FileSystemException(path + " is no file of tokens: it is empty");
        }
        if (version.bytes() > MAX_BYTES) {
            throw new FileSystemException(
                    path + " has " + version.bytes() + " bytes, expected at most " + MAX_BYTES);
        }
        try (InputStream in = Files.newInputStream(path)) {
            var tokens = new LinkedHashMap<String, AgentToken>();
            // The size is limited here, too, because the file may have been replaced after its size
            // was checked.
            TokenFormat.read(in.readNBytes((int) MAX_BYTES))
                    .forEach(token -> tokens.put(token.sha256(), token));
            return Collections.unmodifiableMap(tokens);
        } catch (IllegalArgumentException e) {
            throw new FileSystemException(path + " is no file of tokens: " + e.getMessage());
        }
    }

    /**
     * Returns the file that a link leads to. A change must replace this file, because replacing the
     * link would not change the file that the server reads.
     */
    private static Path target(Path file) throws IOException {
        if (!Files.isSymbolicLink(file)) {
            return file;
        }
        if (!Files.exists(file)) {
            throw new NoSuchFileException(
                    file + " is a link to a file that is not there; remove it, or name that file");
        }
        return file.toRealPath();
    }

    /**
     * Gives a file the owner of another file, and its group if possible. The server, which runs
     * under this account, can then still read the file. Only root can change an owner.
     *
     * @return whether the owners are the same now
     */
    private static boolean keepOwner(Path from, Path to) throws IOException {
        for (String attribute : List.of("unix:gid", "unix:uid")) {
            try {
                Files.setAttribute(to, attribute, Files.getAttribute(from, attribute));
            } catch (FileSystemException e) {
                // The exception is ignored, because the process may lack the permission. The
                // comparison below shows whether the owners differ.
            }
        }
        return Files.getAttribute(from, "unix:uid").equals(Files.getAttribute(to, "unix:uid"));
    }

    /**
     * Changes the file. A lock serializes changes by several programs. Replaces the file
     * atomically, so that readers never see half a change.
     */
    private static void change(Path path, boolean make, UnaryOperator<List<AgentToken>> change)
            throws IOException {
        Path file = target(path.toAbsolutePath());
        if (Files.exists(file)) {
            version(file); // this call throws an exception for a folder
        } else if (!Files.isDirectory(file.getParent())) {
            throw new NoSuchFileException(
                    "there is no folder "
                            + file.getParent()
                            + " for "
                            + file.getFileName()
                            + "; make it first");
        }
        Path lock = file.resolveSibling("." + file.getFileName() + ".lock");
        Path next = file.resolveSibling("." + file.getFileName() + ".new");
        try (FileChannel guard =
                        FileChannel.open(
                                lock,
                                Set.of(StandardOpenOption.CREATE, StandardOpenOption.WRITE),
                                PRIVATE);
                FileLock _ = guard.lock()) {
            Map<String, AgentToken> before =
                    make && !Files.exists(file) ? Map.of() : read(file, version(file));
            byte[] bytes = TokenFormat.write(change.apply(new ArrayList<>(before.values())));
            Files.deleteIfExists(next);
            try {
                Files.createFile(next, PRIVATE);
                Files.write(next, bytes, StandardOpenOption.SYNC);
                if (Files.exists(file)) {
                    keepOwner(file, lock);
                    if (!keepOwner(file, next)) {
                        throw new IOException(
                                "it belongs to another account, whose server could not read the"
                                        + " changed file; run this command as that account");
                    }
                }
                Files.move(next, file, StandardCopyOption.ATOMIC_MOVE);
            } catch (IOException e) {
                Files.deleteIfExists(next);
                throw Reason.naming(file, e);
            }
        }
    }
}
