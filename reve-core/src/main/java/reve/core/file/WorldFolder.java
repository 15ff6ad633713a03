package reve.core.file;

import java.io.File;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.InvalidPathException;
import java.nio.file.Path;
import java.util.Objects;
import java.util.Optional;
import org.jspecify.annotations.Nullable;

/** The folder of a world file: what the world is made of is read from inside it and nowhere else. */
final class WorldFolder {
    private final @Nullable Path root;
    /** As the world file's name has it. */
    private final @Nullable Path named;
    private final Allowance bytes = new Allowance(SourceText.MAX_BYTES);

    private WorldFolder(@Nullable Path root, @Nullable Path named) {
        this.root = root;
        this.named = named;
    }

    /** The folder that a world file stands in. */
    static WorldFolder of(Path worldFile) {
        return new WorldFolder(worldFile.toAbsolutePath().getParent(), worldFile.getParent());
    }

    /** Of a text that is no file: there is nothing beside it. */
    static WorldFolder none() {
        return new WorldFolder(null, null);
    }

    /**
     * The regular file that a text names, relative to the file that the text stands in, as messages
     * call it; empty and a problem noted if there is none, or if it is not inside the folder.
     */
    Optional<Path> find(Node node, Problems problems) {
        Optional<String> name = node.text();
        if (name.isEmpty()) {
            return Optional.empty();
        }
        String refusal;
        try {
            Path path = Path.of(name.get());
            Path found = Path.of(node.file()).resolveSibling(path);
            refusal = refusal(name.get(), path, found);
            if (refusal.isEmpty()) {
                return Optional.of(found);
            }
        } catch (InvalidPathException noPath) {
            refusal = "is no file name";
        } catch (IOException unreadable) {
            refusal = "cannot be read: " + unreadable.getMessage();
        }
        problems.add(node, node.label() + ": `" + Node.shorten(name.get()) + "` " + refusal);
        return Optional.empty();
    }

    /** The path within the folder, {@code /} between names, of what a file there calls that. */
    String pathOf(Node node, String name) {
        Path beside = Path.of(node.file()).getParent();
        if (root == null || Objects.equals(beside, named)) {
            return name;
        }
        Path within = named == null ? beside : named.relativize(beside);
        return within.toString().replace(File.separatorChar, '/') + "/" + name;
    }

    /**
     * The text of a file; that of all files together is limited.
     *
     * @throws WorldFileException if it is too large, or not UTF-8, or cannot be read
     */
    String read(Path found, Problems problems) throws WorldFileException {
        try {
            return SourceText.read(found, problems, bytes);
        } catch (IOException unreadable) {
            throw problems.fatal(1, 1, "cannot be read: " + unreadable.getMessage());
        }
    }

    /** Text that was read already; it counts alike. */
    String decode(byte[] content, Problems problems) throws WorldFileException {
        return SourceText.decode(content, problems, bytes);
    }

    /** Why not; empty if the file can be read. */
    private String refusal(String name, Path path, Path found) throws IOException {
        if (root == null) {
            return "cannot be read: this world comes from no folder";
        }
        if (name.contains("://")) {
            return "is an address; only files in the world's folder are read";
        }
        if (path.isAbsolute()) {
            return "is an absolute path; files are named relative to the file that names them";
        }
        for (Path part : path) {
            if (part.toString().equals("..")) {
                return "leads out of its folder; `..` is not allowed";
            }
        }
        if (!Files.exists(found)) {
            return "does not exist; looked for " + found;
        }
        if (!Files.isRegularFile(found)) {
            return "is not a regular file";
        }
        return found.toRealPath().startsWith(root.toRealPath()) ? ""
                : "is a link to a place outside the world's folder";
    }
}
