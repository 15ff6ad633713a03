// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Texture;

import java.nio.file.Path;
import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/** The mesh and image files of one world, with limits on their total size. For one thread. */
final class AssetFiles {

    private static final int MAX_IMAGE_BYTES = 32 << 20;

    private final WorldFolder folder;
    private final Budget budget;

    /** Decoded images that meshes name, by real path. Several meshes may share an image. */
    private final Map<Path, Texture> images = new HashMap<>();

    AssetFiles(WorldFolder folder, Budget budget) {
        this.folder = folder;
        this.budget = budget;
    }

    Budget budget() {
        return budget;
    }

    /** Returns the real path of a file, with links resolved. */
    Path find(String path) throws AssetException {
        return folder.find(path);
    }

    /**
     * Returns the real path of the folder that contains the file at {@code path}. Does not follow
     * the file itself if it is a link.
     */
    Path folderOf(String path) throws AssetException {
        return folder.folderOf(path);
    }

    /** Reads a file. Checks its size before it allocates memory. */
    byte[] read(String path, int maxBytes) throws AssetException {
        return folder.read(path, maxBytes, size -> budget.takeBytes(path, size));
    }

    /**
     * Reads an image.
     *
     * @param path path of the image, relative to the world's folder
     * @param file value for {@link Texture#file}
     */
    Texture image(String path, Optional<String> file) throws AssetException {
        return ImageDecoder.decode(read(path, MAX_IMAGE_BYTES), path, file, budget);
    }

    /** Returns the image of a file that a mesh names. Decodes each file once. */
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
