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
 * The text files that a world is made of: the world file, and those in its folder that it names,
 * directly or not. All together are limited.
 */
final class SourceFiles {
    private final WorldFolder folder;

    /** The folder as the world file's name has it; null for none. */
    private final @Nullable Path named;

    private final Allowance bytes = new Allowance(SourceText.MAX_BYTES);

    /**
     * A file in the folder.
     *
     * @param name what messages call it: as the world file was named
     */
    record Source(String name, Path path) {}

    /**
     * @param worldFile as messages call it
     */
    SourceFiles(WorldFolder folder, String worldFile) {
        this.folder = folder;
        this.named = Path.of(worldFile).getParent();
    }

    /** The file that a text names; empty and a problem noted if the folder has no such file. */
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
     * The path within the folder, {@code /} between names, of what a text names relative to the
     * file that it stands in.
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
     * @throws WorldFileException if it is too large, or not UTF-8, or cannot be read
     */
    String read(Source source, Problems problems) throws WorldFileException {
        try {
            return SourceText.read(source.path(), problems, bytes);
        } catch (IOException unreadable) {
            throw problems.fatal(1, 1, "cannot be read: " + unreadable.getMessage());
        }
    }

    /** The text of the world file, which may be anywhere; else as the other one. */
    String read(Path worldFile, Problems problems) throws WorldFileException, IOException {
        return SourceText.read(worldFile, problems, bytes);
    }

    /** The text of a world file that was read already; it counts alike. */
    String decode(byte[] content, Problems problems) throws WorldFileException {
        return SourceText.decode(content, problems, bytes);
    }
}
