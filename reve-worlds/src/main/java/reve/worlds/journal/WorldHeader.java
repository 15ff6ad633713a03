// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.frame.Timing;
import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.store.PrototypeCodec;
import reve.core.store.Trees;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * What never changes about a world that is recorded or stored.
 *
 * @param folder of its world file, where meshes and textures are
 */
public record WorldHeader(String name, WorldPrototype prototype, Timing timing, Path folder) {

    /** The world's meshes and textures, read when first asked for. One thread. */
    public Assets assets() {
        return new Assets(new WorldFolder(folder));
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
