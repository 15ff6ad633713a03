package reve.core.mesh;

import java.util.HashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import reve.core.world.Mesh;
import reve.core.world.Texture;

/**
 * The meshes and textures that one world uses. Each file is read once, and all who name it share
 * what was read. One thread.
 */
public final class Assets {

    private static final int MAX_FILE_BYTES = 64 << 20;
    private static final int MAX_IMAGE_BYTES = 32 << 20;

    private final Optional<AssetFolder> folder;
    private final Budget budget = new Budget();
    private final Map<String, Loaded<Mesh>> meshes = new HashMap<>();
    private final Map<String, Loaded<Texture>> textures = new HashMap<>();

    /** What came of reading a file: the same answer to all who ask. */
    private record Loaded<T>(Optional<T> value, Optional<AssetException> problem) {
        T get() throws AssetException {
            if (problem.isPresent()) {
                throw problem.get();
            }
            return value.orElseThrow();
        }
    }

    private interface Reading<T> {
        T read(AssetFolder from) throws AssetException;
    }

    /** @param folder of the world file; empty for a world without one, which then has no assets */
    public Assets(Optional<AssetFolder> folder) {
        this.folder = folder;
    }

    /**
     * The mesh of a {@code .glb}, {@code .gltf} or {@code .obj} file: all of its triangles.
     *
     * @param path relative to the world's folder
     * @throws AssetException if it cannot be used, saying why
     */
    public Mesh mesh(String path) throws AssetException {
        return once(meshes, path, from -> {
            byte[] bytes = from.read(path, MAX_FILE_BYTES);
            var sources = new Sources(from, path, budget);
            String name = path.toLowerCase(Locale.ROOT);
            if (name.endsWith(".glb") || name.endsWith(".gltf")) {
                return GltfReader.read(bytes, sources);
            }
            if (name.endsWith(".obj")) {
                return ObjMeshReader.read(bytes, sources);
            }
            throw new AssetException(path + ": expected a mesh in a .glb, .gltf or .obj file; "
                    + "convert others to .glb");
        });
    }

    /**
     * The image of a PNG or JPEG file.
     *
     * @param path relative to the world's folder
     * @throws AssetException if it cannot be used, saying why
     */
    public Texture texture(String path) throws AssetException {
        return once(textures, path, from ->
                ImageDecoder.decode(from.read(path, MAX_IMAGE_BYTES), path, Optional.of(path),
                        budget));
    }

    private <T> T once(Map<String, Loaded<T>> known, String path, Reading<T> reading)
            throws AssetException {
        Loaded<T> loaded = known.get(path);
        if (loaded == null) {
            loaded = load(path, reading);
            known.put(path, loaded);
        }
        return loaded.get();
    }

    private <T> Loaded<T> load(String path, Reading<T> reading) {
        try {
            AssetFolder from = folder.orElseThrow(() -> new AssetException(
                    path + ": a world that is not read from a file has no folder to find it in"));
            return new Loaded<>(Optional.of(reading.read(from)), Optional.empty());
        } catch (AssetException problem) {
            return new Loaded<>(Optional.empty(), Optional.of(problem));
        }
    }
}
