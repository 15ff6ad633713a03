// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Mesh;
import reve.core.world.Texture;

import java.nio.file.Path;
import java.util.HashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/**
 * The meshes and textures of one world. Each file is read once, even if items name it by different
 * paths or links. All these items share the result. For one thread.
 */
public final class Assets {

    private static final int MAX_FILE_BYTES = 64 << 20;

    private final AssetFiles files;
    private final Map<Place, Loaded<Mesh>> meshes = new HashMap<>();
    private final Map<Place, Loaded<Texture>> textures = new HashMap<>();

    /**
     * A resolved path.
     *
     * @param file real path of the file
     * @param beside real path of the folder to which references inside the file are relative
     */
    private record Place(Path file, Path beside) {}

    /**
     * The result of an attempt to read a file. All items that name the file share it.
     *
     * @param path the path by which the file was read
     * @param value the content of the file; empty after a failure
     * @param problem the reason of a failure
     */
    private record Loaded<T>(String path, Optional<T> value, Optional<AssetException> problem) {
        T get(String by) throws AssetException {
            if (problem.isEmpty()) {
                return value.orElseThrow();
            }
            if (by.equals(path)) {
                throw problem.get();
            }
            throw new AssetException(by + ": is the same file as " + problem.get().getMessage());
        }
    }

    private interface Reading<T> {
        T read() throws AssetException;
    }

    /** Creates an empty cache for the files in a world's folder. */
    public Assets(WorldFolder folder) {
        this(folder, new Budget(System::nanoTime));
    }

    /** Creates a cache with another budget, for tests. */
    Assets(WorldFolder folder, Budget budget) {
        this.files = new AssetFiles(folder, budget);
    }

    /**
     * Returns the mesh that consists of all triangles in a {@code .glb}, {@code .gltf} or {@code
     * .obj} file.
     *
     * @param path relative to the world's folder
     * @throws AssetException with the reason if the file cannot be used
     */
    public Mesh mesh(String path) throws AssetException {
        return once(
                meshes,
                path,
                () -> {
                    String name = path.toLowerCase(Locale.ROOT);
                    boolean gltf = name.endsWith(".glb") || name.endsWith(".gltf");
                    if (!gltf && !name.endsWith(".obj")) {
                        throw new AssetException(
                                path
                                        + ": expected a mesh in a .glb, .gltf or .obj file; "
                                        + "convert others to .glb");
                    }
                    byte[] bytes = files.read(path, MAX_FILE_BYTES);
                    var sources = new Sources(files, path);
                    return gltf
                            ? GltfReader.read(bytes, sources)
                            : ObjMeshReader.read(bytes, sources);
                });
    }

    /**
     * Returns the image of a {@code .png}, {@code .jpg} or {@code .jpeg} file. Does not open files
     * of other types, because a stored world names its folder, which may be any folder.
     *
     * @param path relative to the world's folder
     * @throws AssetException with the reason if the file cannot be used
     */
    public Texture texture(String path) throws AssetException {
        return once(
                textures,
                path,
                () -> {
                    String name = path.toLowerCase(Locale.ROOT);
                    if (!name.endsWith(".png")
                            && !name.endsWith(".jpg")
                            && !name.endsWith(".jpeg")) {
                        throw new AssetException(
                                path
                                        + ": expected a picture in a .png, .jpg or .jpeg file; "
                                        + "rename or convert it");
                    }
                    return files.image(path, Optional.of(path));
                });
    }

    private <T> T once(Map<Place, Loaded<T>> known, String path, Reading<T> reading)
            throws AssetException {
        Place place = new Place(files.find(path), files.folderOf(path));
        Loaded<T> loaded = known.get(place);
        if (loaded == null) {
            loaded = load(path, reading);
            known.put(place, loaded);
        }
        return loaded.get(path);
    }

    private <T> Loaded<T> load(String path, Reading<T> reading) {
        files.budget().begin();
        try {
            return new Loaded<>(path, Optional.of(reading.read()), Optional.empty());
        } catch (AssetException problem) {
            return new Loaded<>(path, Optional.empty(), Optional.of(problem));
        } finally {
            files.budget().end();
        }
    }
}
