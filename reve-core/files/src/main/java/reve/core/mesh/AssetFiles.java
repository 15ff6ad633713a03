// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Texture;

import java.nio.file.Path;
import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/** The files of one world's meshes and images, limited together. One thread. */
final class AssetFiles {

    private static final int MAX_IMAGE_BYTES = 32 << 20;

    private final WorldFolder folder;
    private final Budget budget;

    /** Images of meshes by their real paths, which many meshes may share. */
    private final Map<Path, Texture> images = new HashMap<>();

    AssetFiles(WorldFolder folder, Budget budget) {
        this.folder = folder;
        this.budget = budget;
    }

    Budget budget() {
        return budget;
    }

    /** Where a file lies, by whatever path or link it is named. */
    Path find(String path) throws AssetException {
        return folder.find(path);
    }

    /** The real path of the folder that a path's last name is looked for in. */
    Path folderOf(String path) throws AssetException {
        return folder.folderOf(path);
    }

    /** Reads a file, whose size is checked before memory is taken for it. */
    byte[] read(String path, int maxBytes) throws AssetException {
        return folder.read(path, maxBytes, size -> budget.takeBytes(path, size));
    }

    /**
     * Reads an image.
     *
     * @param file see {@link Texture#file}
     */
    Texture image(String path, Optional<String> file) throws AssetException {
        return ImageDecoder.decode(read(path, MAX_IMAGE_BYTES), path, file, budget);
    }

    /** The image of a file that a mesh names; each file is decoded once. */
    Texture imageOfMesh(String path) throws AssetException {
        Path real = find(path);
        Texture known = images.get(real);
        if (known == null) {
            known = image(path, Optional.empty());
            images.put(real, known);
        }
        return known;
    }
}
