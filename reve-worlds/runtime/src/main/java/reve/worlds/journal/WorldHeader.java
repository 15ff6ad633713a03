// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.frame.Timing;
import reve.core.image.CorruptException;
import reve.core.image.PrototypeCodec;
import reve.core.image.Trees;
import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.plugin.PluginInfo;
import reve.core.world.WorldPrototype;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;

import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The data of a recorded or stored world that never changes.
 *
 * @param folder the folder of the world file, with the world's meshes and textures
 * @param plugins the plugins of the command that made the frames
 */
public record WorldHeader(
        String name,
        WorldPrototype prototype,
        Timing timing,
        Path folder,
        List<PluginInfo> plugins) {

    /** Copies the list of plugins. */
    public WorldHeader {
        plugins = List.copyOf(plugins);
    }

    /**
     * Returns a reader of the world's meshes and textures. They are read on first use. For one
     * thread.
     */
    public Assets assets() {
        return new Assets(WorldFolder.named(folder));
    }

    /** Returns this header with another folder, for a world whose files have moved. */
    public WorldHeader in(Path moved) {
        return new WorldHeader(name, prototype, timing, moved, plugins);
    }

    /** Returns the header as bytes. */
    public byte[] write() {
        return Trees.write(tree());
    }

    /**
     * Reads the bytes of {@link #write}.
     *
     * @throws CorruptException with the reason, if they are damaged
     */
    public static WorldHeader read(byte[] bytes) {
        try {
            return read(Trees.read(bytes));
        } catch (IllegalArgumentException | JacksonException e) {
            throw new CorruptException("its header makes no sense: " + e.getMessage(), e);
        }
    }

    Map<String, Object> tree() {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("world", name);
        tree.put("prototype", PrototypeCodec.write(prototype));
        tree.put("framesPerSecond", timing.framesPerSecond());
        tree.put("stepsPerFrame", timing.stepsPerFrame());
        tree.put("folder", folder.toAbsolutePath().toString());
        if (!plugins.isEmpty()) {
            tree.put("plugins", plugins.stream().map(WorldHeader::tree).toList());
        }
        return tree;
    }

    static WorldHeader read(JsonNode tree) {
        return new WorldHeader(
                Trees.text(tree, "world"),
                PrototypeCodec.read(Trees.field(tree, "prototype")),
                new Timing(
                        (int) Trees.integer(tree, "framesPerSecond"),
                        (int) Trees.integer(tree, "stepsPerFrame")),
                Path.of(Trees.text(tree, "folder")),
                Trees.listIfAny(tree, "plugins").stream().map(WorldHeader::plugin).toList());
    }

    private static Map<String, Object> tree(PluginInfo plugin) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("file", plugin.file());
        tree.put("sha256", plugin.sha256());
        plugin.version().ifPresent(version -> tree.put("version", version));
        return tree;
    }

    private static PluginInfo plugin(JsonNode tree) {
        return new PluginInfo(
                Trees.text(tree, "file"),
                Trees.text(tree, "sha256"),
                tree.has("version") ? Optional.of(Trees.text(tree, "version")) : Optional.empty());
    }

    /**
     * Returns one message for each plugin that made the frames and is missing now, or has another
     * content now.
     *
     * @param present the plugins of this command
     */
    public List<String> missing(List<PluginInfo> present) {
        List<String> messages = new ArrayList<>();
        for (PluginInfo plugin : plugins) {
            Optional<PluginInfo> same =
                    present.stream().filter(now -> now.file().equals(plugin.file())).findFirst();
            if (present.stream().anyMatch(now -> now.sha256().equals(plugin.sha256()))) {
                continue;
            }
            messages.add(
                    same.map(now -> "the plugin " + plugin + " has changed, it is now " + now)
                            .orElse(
                                    "the plugin "
                                            + plugin
                                            + " is missing; name its folder with --plugins"));
        }
        return messages;
    }
}
