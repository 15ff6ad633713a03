// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.AssetException;
import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.Optional;
import java.util.Set;

/**
 * Reads world files: YAML (any JSON file is also valid) that follows the schema {@code
 * reve-world.schema.json}. Any thread; nothing is kept between calls.
 */
public final class WorldFile {
    /** The format version that {@code reve:} names. */
    public static final int FORMAT_VERSION = 1;

    /** Of the world file in a folder. */
    public static final String NAME = "world.yaml";

    private WorldFile() {}

    /**
     * Reads and checks a whole file, with those that it includes.
     *
     * @throws WorldFileException with all that is wrong with it, by line and column
     * @throws IOException if the system cannot read it
     */
    public static WorldDescription load(Path path) throws WorldFileException, IOException {
        var problems = new Problems(path.toString());
        var folder = new WorldFolder(path.toAbsolutePath().getParent());
        return new WorldReader(new Assets(folder), problems)
                .read(WorldSource.read(path, folder, problems));
    }

    /**
     * As {@link #load}, of the {@value #NAME} of a folder, which leads out of it no more than what
     * it names does: nobody chose that file.
     *
     * @throws WorldFileException if it is a link out of the folder, or not a regular file
     */
    public static WorldDescription loadFolder(Path folder) throws WorldFileException, IOException {
        Path file = folder.resolve(NAME);
        try {
            new WorldFolder(folder).find(NAME);
        } catch (AssetException refused) {
            throw new Problems(file.toString()).fatal(1, 1, refused.getMessage());
        }
        return load(file);
    }

    /**
     * Reads and checks the bytes of a file, which has no folder to find others in.
     *
     * @param name what problems call the file
     * @throws WorldFileException as {@link #load}
     */
    public static WorldDescription parse(String name, byte[] content) throws WorldFileException {
        var problems = new Problems(name);
        return new WorldReader(new Assets(WorldFolder.none()), problems)
                .read(WorldSource.parse(content, problems));
    }

    /**
     * Writes a world file that {@link #load} reads back to the bit, in place of the one that may be
     * there: all of it, or nothing. Models and images are named as they were: relative to the
     * folder of the file that the world came from.
     *
     * @throws IllegalArgumentException naming what no world file can hold, such as a world that is
     *     too large
     * @throws IOException if the system cannot write it
     */
    public static void save(Path path, WorldDescription world) throws IOException {
        byte[] text = WorldWriter.write(world).getBytes(StandardCharsets.UTF_8);
        if (text.length > SourceText.MAX_BYTES) {
            throw new IllegalArgumentException(
                    "world "
                            + world.name()
                            + " takes "
                            + text.length
                            + " bytes as a world file, of which at most "
                            + SourceText.MAX_BYTES
                            + " are read");
        }
        Path target = path.toAbsolutePath();
        Path part = target.resolveSibling(target.getFileName() + ".part");
        try {
            Files.write(part, text);
            Files.move(part, target, StandardCopyOption.ATOMIC_MOVE);
        } finally {
            Files.deleteIfExists(part);
        }
    }

    /** As the other one, of an item that needs no files. */
    public static ItemDefinition parseItem(String name, String text, WorldPrototype prototype)
            throws WorldFileException {
        return parseItem(name, text, prototype, new Assets(WorldFolder.none()));
    }

    /**
     * Reads and checks what {@link ItemWriter} wrote. Items that it refers to are not looked for,
     * and need not be given; an action may take it that the item has physics.
     *
     * @param name what problems call the text
     * @param prototype of the world that the item is for
     * @param assets where its mesh and texture come from
     * @throws WorldFileException as {@link #load}
     */
    public static ItemDefinition parseItem(
            String name, String text, WorldPrototype prototype, Assets assets)
            throws WorldFileException {
        var problems = new Problems(name);
        Node item = YamlReader.readKept(text, problems);
        SchemaCheck.checkItem(item, problems);
        var physics = new PhysicsReader(prototype, Set.of(), Doubts.IGNORED, problems);
        Optional<ItemDefinition> read =
                new ItemReader(
                                prototype,
                                physics,
                                assets,
                                (node, path) -> path,
                                node -> node,
                                Doubts.IGNORED,
                                problems)
                        .readAlone(item);
        problems.throwIfAny();
        return read.orElseThrow();
    }
}
