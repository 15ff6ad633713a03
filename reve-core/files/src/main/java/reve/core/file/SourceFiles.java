// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;

import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;

import java.io.File;
import java.io.IOException;
import java.nio.file.Path;
import java.util.Objects;
import java.util.Optional;

/**
 * The text files of a world: the world file, and the files in its folder that it names directly or
 * through other files. The total size of these files is limited.
 */
final class SourceFiles {
    private final WorldFolder folder;

    /**
     * The folder in the name of the world file as the user gave it; null if this name contains no
     * folder.
     */
    private final @Nullable Path named;

    private final Allowance bytes = new Allowance(SourceText.MAX_BYTES);

    /**
     * A file in the folder.
     *
     * @param name name for messages, relative to the same folder as the world file's name
     */
    record Source(String name, Path path) {}

    /**
     * @param worldFile name of the world file for messages
     */
    SourceFiles(WorldFolder folder, String worldFile) {
        this.folder = folder;
        this.named = Path.of(worldFile).getParent();
    }

    /**
     * Returns the file that the text of a node names. Records a problem and returns empty if the
     * folder has no such file.
     */
    Optional<Source> find(Node node, Problems problems) {
        Optional<String> text = node.text();
        if (text.isEmpty()) {
            return Optional.empty();
        }
        try {
            Path real = folder.find(pathOf(node, text.get()));
            return Optional.of(
                    new Source(Path.of(node.file()).resolveSibling(text.get()).toString(), real));
        } catch (AssetException refused) {
            problems.add(node, node.label() + ": " + refused.getMessage());
            return Optional.empty();
        }
    }

    /**
     * Returns the path of a named file within the folder, separated by {@code /}. The name is
     * relative to the file that contains it.
     */
    String pathOf(Node node, String name) {
        Path beside = Path.of(node.file()).getParent();
        if (beside == null || Objects.equals(beside, named)) {
            return name;
        }
        Path within = named == null ? beside : named.relativize(beside);
        return within.toString().replace(File.separatorChar, '/') + "/" + name;
    }

    /**
     * Reads the text of a file.
     *
     * @throws WorldFileException if the file is too large, not UTF-8, or unreadable
     */
    String read(Source source, Problems problems) throws WorldFileException {
        try {
            return SourceText.read(source.path(), problems, bytes);
        } catch (IOException unreadable) {
            throw problems.fatal(1, 1, "cannot be read: " + unreadable.getMessage());
        }
    }

    /**
     * Reads the text of the world file, which may be in any folder. The method is otherwise like
     * {@link #read(Source, Problems)}.
     */
    String read(Path worldFile, Problems problems) throws WorldFileException, IOException {
        return SourceText.read(worldFile, problems, bytes);
    }

    /**
     * Decodes the text of a world file that is already in memory. Its size counts towards the
     * limit.
     */
    String decode(byte[] content, Problems problems) throws WorldFileException {
        return SourceText.decode(content, problems, bytes);
    }
}
