// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.frame.Timing;
import reve.core.image.PrototypeCodec;
import reve.core.image.Trees;
import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * The data of a recorded or stored world that never changes.
 *
 * @param folder the folder of the world file, with the world's meshes and textures
 */
public record WorldHeader(String name, WorldPrototype prototype, Timing timing, Path folder) {

    /**
     * Returns a reader of the world's meshes and textures. They are read on first use. For one
     * thread.
     */
    public Assets assets() {
        return new Assets(WorldFolder.named(folder));
    }

    /** Returns this header with another folder, for a world whose files have moved. */
    public WorldHeader in(Path moved) {
        return new WorldHeader(name, prototype, timing, moved);
    }

    Map<String, Object> tree() {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("world", name);
        tree.put("prototype", PrototypeCodec.write(prototype));
        tree.put("framesPerSecond", timing.framesPerSecond());
        tree.put("stepsPerFrame", timing.stepsPerFrame());
        tree.put("folder", folder.toAbsolutePath().toString());
        return tree;
    }

    static WorldHeader read(JsonNode tree) {
        return new WorldHeader(
                Trees.text(tree, "world"),
                PrototypeCodec.read(Trees.field(tree, "prototype")),
                new Timing(
                        (int) Trees.integer(tree, "framesPerSecond"),
                        (int) Trees.integer(tree, "stepsPerFrame")),
                Path.of(Trees.text(tree, "folder")));
    }
}
