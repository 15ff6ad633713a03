package reve.core.agent;

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
import java.nio.file.attribute.FileTime;
import java.nio.file.attribute.PosixFileAttributes;
import java.nio.file.attribute.PosixFilePermission;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.InstantSource;
import java.util.ArrayList;
import java.util.Collections;
import java.util.EnumSet;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.function.UnaryOperator;
import java.util.stream.Collectors;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

/**
 * The tokens of a server, in a file that its owner alone may read and write. A change of the file
 * counts at once; one that cannot be read leaves what was read before. Any thread.
 */
public final class TokenFile {

    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");
    private static final long MAX_BYTES = 16L * 1024 * 1024;
    private static final Set<PosixFilePermission> OWNERS =
            EnumSet.of(PosixFilePermission.OWNER_READ, PosixFilePermission.OWNER_WRITE);
    private static final FileAttribute<Set<PosixFilePermission>> PRIVATE =
            PosixFilePermissions.asFileAttribute(OWNERS);

    private final Path path;
    private final InstantSource clock;
    private Version read;
    private Set<AgentToken> tokens;

    /** Tells one content of the file from the next. */
    private record Version(FileTime modified, long bytes, Object inode,
            Set<PosixFilePermission> permissions) {}

    private TokenFile(Path path, InstantSource clock) throws IOException {
        this.path = path;
        this.clock = clock;
        this.read = version(path);
        this.tokens = read(path, read);
    }

    /**
     * @throws IOException if it is not there, not private, or not a file of tokens; the message
     *     says what to do
     */
    public static TokenFile open(Path path) throws IOException {
        return open(path, InstantSource.system());
    }

    static TokenFile open(Path path, InstantSource clock) throws IOException {
        return new TokenFile(path, clock);
    }

    /** Adds a token to a file, which is made if it is not there. */
    public static void add(Path path, AgentToken token) throws IOException {
        change(path, true, tokens -> {
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
        change(path, false, tokens -> {
            tokens.stream()
                    .filter(token -> token.name().equals(nameOrId) || token.id().equals(nameOrId))
                    .forEach(revoked::add);
            tokens.removeAll(revoked);
            return tokens;
        });
        return revoked;
    }

    /** In the order in which they were added. */
    public synchronized Set<AgentToken> tokens() {
        refresh();
        return tokens;
    }

    /**
     * The token with that secret, unless it has expired. Takes as long whether there is one or not.
     */
    Optional<AgentToken> find(String secret) {
        String hash = AgentToken.hash(secret);
        AgentToken found = null;
        for (AgentToken token : tokens()) {
            found = token.hasHash(hash) ? token : found;
        }
        return Optional.ofNullable(found).filter(this::isCurrent);
    }

    /** Those that open something now. */
    Set<AgentToken> current() {
        return tokens().stream().filter(this::isCurrent).collect(Collectors.toUnmodifiableSet());
    }

    private boolean isCurrent(AgentToken token) {
        return !token.hasExpired(clock.instant());
    }

    private void refresh() {
        try {
            Version now = version(path);
            if (!now.equals(read)) {
                read = now;
                tokens = read(path, now);
                LOG.info("{} was read again: {} tokens", path, tokens.size());
            }
        } catch (IOException e) {
            LOG.error("the tokens stay as they were: {}", e.getMessage());
        }
    }

    // ---- the file ----

    private static Version version(Path path) throws IOException {
        PosixFileAttributes file;
        try {
            file = Files.readAttributes(path, PosixFileAttributes.class);
        } catch (NoSuchFileException e) {
            throw new NoSuchFileException("there is no file of tokens " + path
                    + "; `./reve token new NAME --file " + path + "` makes one");
        }
        if (file.isDirectory()) {
            throw new FileSystemException(path + " is a folder, expected a file of tokens");
        }
        return new Version(file.lastModifiedTime(), file.size(), file.fileKey(),
                file.permissions());
    }

    private static Set<AgentToken> read(Path path, Version version) throws IOException {
        if (!OWNERS.containsAll(version.permissions())) {
            throw new FileSystemException(path + " is open to others (mode "
                    + PosixFilePermissions.toString(version.permissions()) + "); run `chmod 600 "
                    + path + "`");
        }
        if (version.bytes() > MAX_BYTES) {
            throw new FileSystemException(path + " has " + version.bytes()
                    + " bytes, expected at most " + MAX_BYTES);
        }
        try {
            return Collections.unmodifiableSet(
                    new LinkedHashSet<>(TokenFormat.read(Files.readAllBytes(path))));
        } catch (IllegalArgumentException e) {
            throw new FileSystemException(path + " is no file of tokens: " + e.getMessage());
        }
    }

    /**
     * Changes of several programs come one after the other; readers see the file before
     * or after one.
     */
    private static void change(Path path, boolean make, UnaryOperator<List<AgentToken>> change)
            throws IOException {
        Path file = path.toAbsolutePath();
        if (Files.exists(file)) {
            version(file); // refuses a folder
        } else if (!Files.isDirectory(file.getParent())) {
            throw new NoSuchFileException("there is no folder " + file.getParent() + " for "
                    + file.getFileName() + "; make it first");
        }
        Path lock = file.resolveSibling("." + file.getFileName() + ".lock");
        Path next = file.resolveSibling("." + file.getFileName() + ".new");
        try (FileChannel guard = FileChannel.open(lock,
                Set.of(StandardOpenOption.CREATE, StandardOpenOption.WRITE), PRIVATE);
                FileLock _ = guard.lock()) {
            Set<AgentToken> before = make && !Files.exists(file) ? Set.of()
                    : read(file, version(file));
            byte[] bytes = TokenFormat.write(change.apply(new ArrayList<>(before)));
            Files.deleteIfExists(next);
            Files.createFile(next, PRIVATE);
            Files.write(next, bytes, StandardOpenOption.SYNC);
            Files.move(next, file, StandardCopyOption.ATOMIC_MOVE);
        }
    }
}
