// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.disk.PartFile;
import reve.core.disk.Reason;
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
import java.util.function.Consumer;

/**
 * Reader of world files. A world file is YAML (including JSON) and follows the schema {@code
 * reve-world.schema.json}. This class has no state. For any thread.
 */
public final class WorldFile {
    /** Version of the format, the value of the key {@code reve}. */
    public static final int FORMAT_VERSION = 1;

    /** Name of the world file in a world's folder. */
    public static final String NAME = "world.yaml";

    private WorldFile() {}

    /**
     * Reads and checks a file with its included files.
     *
     * @throws WorldFileException with all problems, by line and column
     * @throws IOException if the system cannot read the file
     */
    public static WorldDescription load(Path path) throws WorldFileException, IOException {
        return load(path, path.toString(), _ -> {});
    }

    /**
     * Reads and checks a file like {@link #load(Path)}.
     *
     * @param shown name of the file for problems
     * @param found receives the path of each file that the world file names. The paths are relative
     *     to the folder of the world file and separated by {@code /}. The same path may be passed
     *     several times
     */
    public static WorldDescription load(Path path, String shown, Consumer<String> found)
            throws WorldFileException, IOException {
        var problems = new Problems(shown);
        var folder = new WorldFolder(path.toAbsolutePath().getParent(), found);
        return new WorldReader(new Assets(folder), problems)
                .read(WorldSource.read(path, folder, problems));
    }

    /**
     * Reads the file {@value #NAME} of a folder, like {@link #load}. Neither this file nor the
     * files that it names may be outside the folder, because the user chose only the folder.
     *
     * @throws WorldFileException also if the world file is a link out of the folder or not a
     *     regular file
     */
    public static WorldDescription loadFolder(Path folder) throws WorldFileException, IOException {
        return loadFolder(folder, _ -> {});
    }

    /**
     * Reads a folder like {@link #loadFolder(Path)}.
     *
     * @param found like in {@link #load(Path, String, Consumer)}
     */
    public static WorldDescription loadFolder(Path folder, Consumer<String> found)
            throws WorldFileException, IOException {
        Path file = folder.resolve(NAME);
        try {
            new WorldFolder(folder).find(NAME);
        } catch (AssetException refused) {
            throw new Problems(file.toString()).fatal(1, 1, refused.getMessage());
        }
        return load(file, file.toString(), found);
    }

    /**
     * Reads and checks the content of a world file that is in memory. It cannot refer to other
     * files.
     *
     * @param name name of the file for problems
     * @throws WorldFileException like {@link #load}
     */
    public static WorldDescription parse(String name, byte[] content) throws WorldFileException {
        return parse(name, content, WorldFolder.none());
    }

    /**
     * Reads and checks the content of a world file like {@link #parse}. It may refer to meshes and
     * images, but includes no other file.
     *
     * @param folder the folder of the files that it refers to
     */
    public static WorldDescription parse(String name, byte[] content, WorldFolder folder)
            throws WorldFileException {
        var problems = new Problems(name);
        return new WorldReader(new Assets(folder), problems)
                .read(WorldSource.parse(content, problems));
    }

    /**
     * Reads a world file like {@link #parse}, with the limits for one message of a client: its
     * items create at most 10,000 items, 1,000,000 values and 1,000,000 evaluations of formulas,
     * and their symbols have at most 4,000,000 characters.
     *
     * @throws WorldFileException like {@link #load}
     */
    public static WorldDescription parseMessage(String name, byte[] content)
            throws WorldFileException {
        var problems = new Problems(name);
        Expansion.Limits limits = Expansion.Limits.ofMessage();
        WorldDescription world =
                new WorldReader(new Assets(WorldFolder.none()), limits, problems)
                        .read(WorldSource.parse(content, problems));
        limits.requireCharacters(world.items(), problems);
        return world;
    }

    /**
     * Returns a world as the content of a world file. {@link #load} reads it back to the bit. The
     * paths of meshes and images in the text stay relative to the folder of the original world
     * file.
     *
     * @throws IllegalArgumentException naming the part that a world file cannot express, for
     *     example a world that is too large
     */
    public static byte[] encode(WorldDescription world) {
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
        return text;
    }

    /**
     * Writes a world file atomically, with the content of {@link #encode}.
     *
     * @throws IllegalArgumentException like {@link #encode}
     * @throws IOException if the system cannot write the file
     */
    public static void save(Path path, WorldDescription world) throws IOException {
        byte[] text = encode(world);
        Path target = path.toAbsolutePath();
        try {
            Path part = PartFile.create(target);
            try {
                Files.write(part, text);
                PartFile.move(part, target, StandardCopyOption.ATOMIC_MOVE);
            } finally {
                PartFile.remove(part);
            }
        } catch (IOException e) {
            throw Reason.naming(path, e);
        }
    }

    /** Reads and checks an item that uses no mesh or texture files. */
    public static ItemDefinition parseItem(String name, String text, WorldPrototype prototype)
            throws WorldFileException {
        return parseItem(name, text, prototype, new Assets(WorldFolder.none()));
    }

    /**
     * Reads and checks the text of an item that an {@link ItemWriter} wrote. Referenced items need
     * not exist. Actions may use physics properties even if the item has no physics aspect.
     *
     * @param name name of the text for problems
     * @param prototype prototype of the item's world
     * @param assets source of the item's mesh and texture
     * @throws WorldFileException like {@link #load}
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
