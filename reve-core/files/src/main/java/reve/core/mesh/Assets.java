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
 * The meshes and textures that one world uses. Each file is read once, by whatever path or link it
 * is named, and all items that name it share what was read. One thread.
 */
public final class Assets {

    private static final int MAX_FILE_BYTES = 64 << 20;

    private final AssetFiles files;
    private final Map<Place, Loaded<Mesh>> meshes = new HashMap<>();
    private final Map<Place, Loaded<Texture>> textures = new HashMap<>();

    /**
     * What a path leads to.
     *
     * @param file its real path
     * @param beside the real folder that the file's own references begin at
     */
    private record Place(Path file, Path beside) {}

    /**
     * What came of reading a file: the same answer for all that name it.
     *
     * @param path that it was read by
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

    /** The files in a world's folder; none is read yet. */
    public Assets(WorldFolder folder) {
        this(folder, new Budget(System::nanoTime));
    }

    /** For tests of the time that reading may take. */
    Assets(WorldFolder folder, Budget budget) {
        this.files = new AssetFiles(folder, budget);
    }

    /**
     * The mesh of a {@code .glb}, {@code .gltf} or {@code .obj} file: all of its triangles.
     *
     * @param path relative to the world's folder
     * @throws AssetException if it cannot be used, saying why
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
     * The image of a PNG or JPEG file.
     *
     * @param path relative to the world's folder
     * @throws AssetException if it cannot be used, saying why
     */
    public Texture texture(String path) throws AssetException {
        return once(textures, path, () -> files.image(path, Optional.of(path)));
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
