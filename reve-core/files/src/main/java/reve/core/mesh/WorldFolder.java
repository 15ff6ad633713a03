// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.InvalidPathException;
import java.nio.file.LinkOption;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.util.List;
import java.util.Optional;
import java.util.function.Consumer;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * The folder of a world file. All files that the world file names are read from this folder:
 * included files, tables, meshes, textures. Their paths are relative to the folder and separate
 * names with {@code /}. No path can leave the folder by {@code ..}, a link or a URL. For any
 * thread.
 */
public final class WorldFolder {

    private static final int MAX_PATH_LENGTH = 1024;

    /** Pattern of the key of a world file that states its format. */
    private static final Pattern WORLD = Pattern.compile("(?m)(^|[{,])\\s*[\"']?reve[\"']?\\s*:");

    private static final int BEGINNING_BYTES = 64 * 1024;
    private static final int MAX_SEARCHED = 1000;

    private final Optional<Path> folder;
    private final Consumer<String> found;

    /** True if files may be found only if the folder contains a world file. */
    private final boolean needsWorld;

    private volatile boolean hasWorld;

    /** Creates an access to the files in this folder and below. */
    public WorldFolder(Path folder) {
        this(folder, _ -> {});
    }

    /**
     * Creates an access to the files in this folder and below.
     *
     * @param found receives the path of each file that is found, each time it is found
     */
    public WorldFolder(Path folder, Consumer<String> found) {
        this(Optional.of(folder), found, false);
    }

    private WorldFolder(Optional<Path> folder, Consumer<String> found, boolean needsWorld) {
        this.folder = folder;
        this.found = found;
        this.needsWorld = needsWorld;
    }

    /**
     * Creates an access to the folder that a recording or a store names. A stranger may have made
     * the recording or the store. Therefore files can be found only if the folder contains a world
     * file.
     */
    public static WorldFolder named(Path folder) {
        return named(folder, _ -> {});
    }

    /**
     * Creates an access to the folder that a recording or a store names, like {@link #named(Path)}.
     *
     * @param found receives the path of each file that is found, each time it is found
     */
    public static WorldFolder named(Path folder, Consumer<String> found) {
        return new WorldFolder(Optional.of(folder), found, true);
    }

    /** Returns an access to no files, for a world that is not read from a file. */
    public static WorldFolder none() {
        return new WorldFolder(Optional.empty(), _ -> {}, false);
    }

    /**
     * Finds a file.
     *
     * @return the real path of a regular file in this folder or below
     * @throws AssetException if the path leaves the folder or has another form, or there is no such
     *     file
     */
    public Path find(String path) throws AssetException {
        requireWithin(path);
        Path existing =
                folder.orElseThrow(
                        () ->
                                new AssetException(
                                        path
                                                + ": a world that is not read from a file has no"
                                                + " folder to find it in"));
        try {
            if (needsWorld && !hasWorld()) {
                throw new AssetException(
                        path
                                + ": the folder "
                                + existing
                                + ", which the recording or store names, contains no world file");
            }
            Path root = existing.toRealPath();
            Path real = root.resolve(path).toRealPath();
            if (!real.startsWith(root)) {
                throw new AssetException(path + ": a link that leads out of the world's folder");
            }
            if (!Files.isRegularFile(real, LinkOption.NOFOLLOW_LINKS)) {
                throw new AssetException(path + ": not a regular file");
            }
            found.accept(path);
            return real;
        } catch (NoSuchFileException missing) {
            throw new AssetException(
                    path + ": there is no such file in the world's folder", missing);
        } catch (IOException | InvalidPathException unreadable) {
            throw new AssetException(
                    path + ": cannot be opened: " + Reason.ofSystem(unreadable), unreadable);
        }
    }

    private boolean hasWorld() throws IOException {
        if (!hasWorld) {
            try (Stream<Path> files = Files.list(folder.orElseThrow())) {
                hasWorld = files.limit(MAX_SEARCHED).anyMatch(WorldFolder::isWorld);
            }
        }
        return hasWorld;
    }

    private static boolean isWorld(Path file) {
        if (!Files.isRegularFile(file)) {
            return false;
        }
        try (InputStream in = Files.newInputStream(file)) {
            var beginning = new String(in.readNBytes(BEGINNING_BYTES), StandardCharsets.ISO_8859_1);
            return WORLD.matcher(beginning).find();
        } catch (IOException unreadable) {
            return false;
        }
    }

    /**
     * Returns the real path of the folder that contains the file at {@code path}. {@link #find}
     * must have accepted this path. A link in the place of the file itself is not followed.
     */
    Path folderOf(String path) throws AssetException {
        try {
            return folder.orElseThrow()
                    .toRealPath()
                    .resolve(path.substring(0, path.lastIndexOf('/') + 1))
                    .toRealPath();
        } catch (IOException failure) {
            throw new AssetException(
                    path + ": cannot be opened: " + Reason.ofSystem(failure), failure);
        }
    }

    /** A check of the size of a file, called before memory is allocated for it. */
    interface SizeCheck {
        void check(long bytes) throws AssetException;
    }

    /**
     * Reads a file.
     *
     * @throws AssetException if there is no such file, or it is larger than {@code maxBytes}
     */
    byte[] read(String path, int maxBytes, SizeCheck check) throws AssetException {
        Path file = find(path);
        try (InputStream in = Files.newInputStream(file, LinkOption.NOFOLLOW_LINKS)) {
            long size = Files.size(file);
            if (size > maxBytes) {
                throw new AssetException(
                        path
                                + ": has "
                                + size
                                + " bytes, at most "
                                + (maxBytes >> 20)
                                + " MiB are read");
            }
            check.check(size);
            return in.readNBytes((int) size);
        } catch (IOException unreadable) {
            throw new AssetException(
                    path + ": cannot be read: " + Reason.ofSystem(unreadable), unreadable);
        }
    }

    /**
     * Checks that a path is a sequence of names that stays within a folder. Reads no file.
     *
     * @throws AssetException if the path is absolute, or has `..`, `.`, `:`, `\\` or control
     *     characters
     */
    public static void requireWithin(String path) throws AssetException {
        if (path.isEmpty() || path.length() > MAX_PATH_LENGTH) {
            throw new AssetException(
                    "a path of " + path.length() + " characters, expected 1 to " + MAX_PATH_LENGTH);
        }
        boolean plain = path.chars().noneMatch(c -> c == '\\' || c == ':' || c < ' ');
        if (!plain || !List.of(path.split("/", -1)).stream().allMatch(WorldFolder::isName)) {
            throw new AssetException(
                    path
                            + ": expected a path within the world's folder, such as"
                            + " models/duck.glb: not an absolute one, without `..`, `.`, `:` or"
                            + " `\\`");
        }
    }

    private static boolean isName(String part) {
        return !part.isEmpty() && !part.equals(".") && !part.equals("..");
    }
}
