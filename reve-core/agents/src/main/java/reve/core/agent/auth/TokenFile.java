// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import java.io.IOException;
import java.nio.channels.FileChannel;
import java.nio.channels.FileLock;
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
 * The tokens of a server, in a file that its owner alone may read and write. A change of the file
 * counts at once; one that cannot be read leaves what was read before. Any thread.
 */
public final class TokenFile {

    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");
    private static final long MAX_BYTES = 16L * 1024 * 1024;

    /** Of files for their owner alone, from the moment in which they are made. */
    public static final FileAttribute<Set<PosixFilePermission>> PRIVATE =
            PosixFilePermissions.asFileAttribute(FileVersion.OWNERS);

    private final Path path;
    private final InstantSource clock;

    /** Null if the file was not there. */
    private @Nullable FileVersion read;

    private Map<String, AgentToken> tokens;
    private Optional<String> problem = Optional.empty();

    private TokenFile(Path path, InstantSource clock) throws IOException {
        this.path = path;
        this.clock = clock;
        FileVersion version = version(path);
        this.read = version;
        this.tokens = read(path, version);
    }

    /**
     * @throws IOException if it is not there, not private, or not a file of tokens; the message
     *     says what to do
     */
    public static TokenFile open(Path path) throws IOException {
        return open(path, InstantSource.system());
    }

    /** Opens the file as the method without a clock does; the clock decides about expiry. */
    public static TokenFile open(Path path, InstantSource clock) throws IOException {
        return new TokenFile(path, clock);
    }

    /** Adds a token to a file, which is made if it is not there. */
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
     * Takes tokens out of a file.
     *
     * @param nameOrId a client's name, for all of its tokens, or a token's id
     * @return those taken out
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

    /** In the order in which they were added. */
    public Collection<AgentToken> tokens() {
        return refreshed().values();
    }

    /**
     * The token with that secret, unless it has expired. Takes as long whether there is one or not,
     * and however many there are: they are found by the hash, no part of which an attacker can
     * choose.
     */
    public Optional<AgentToken> find(String secret) {
        return Optional.ofNullable(refreshed().get(AgentToken.hash(secret)))
                .filter(this::isCurrent);
    }

    /** Those that open something now. */
    public Set<AgentToken> current() {
        return tokens().stream().filter(this::isCurrent).collect(Collectors.toUnmodifiableSet());
    }

    private boolean isCurrent(AgentToken token) {
        return !token.hasExpired(clock.instant());
    }

    /** Why the file as it is now does not count, if so. */
    public synchronized Optional<String> problem() {
        refreshed();
        return problem;
    }

    /** What to say when there is no problem any more. */
    public synchronized String solved() {
        return path + " was read again: " + tokens.size() + " tokens";
    }

    private synchronized Map<String, AgentToken> refreshed() {
        FileVersion now = null;
        try {
            now = version(path);
            if (!now.equals(read)) {
                tokens = read(path, now);
                problem = Optional.empty();
                LOG.info("{} was read again: {} tokens", path, tokens.size());
            }
        } catch (IOException e) {
            problem = Optional.of("the tokens stay as they were: " + e.getMessage());
        }
        read = now;
        return tokens;
    }

    // ---- the file ----

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
        if (!version.isFile()) { // reading a pipe waits for a writer
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
        if (version.bytes() > MAX_BYTES) {
            throw new FileSystemException(
                    path + " has " + version.bytes() + " bytes, expected at most " + MAX_BYTES);
        }
        try {
            var tokens = new LinkedHashMap<String, AgentToken>();
            TokenFormat.read(Files.readAllBytes(path))
                    .forEach(token -> tokens.put(token.sha256(), token));
            return Collections.unmodifiableMap(tokens);
        } catch (IllegalArgumentException e) {
            throw new FileSystemException(path + " is no file of tokens: " + e.getMessage());
        }
    }

    /**
     * Changes of several programs come one after the other; readers see the file before or after
     * one.
     */
    private static void change(Path path, boolean make, UnaryOperator<List<AgentToken>> change)
            throws IOException {
        Path file = path.toAbsolutePath();
        if (Files.exists(file)) {
            version(file); // refuses a folder
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
            Files.createFile(next, PRIVATE);
            Files.write(next, bytes, StandardOpenOption.SYNC);
            Files.move(next, file, StandardCopyOption.ATOMIC_MOVE);
        }
    }
}
