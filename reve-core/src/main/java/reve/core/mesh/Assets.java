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

    private final WorldFolder folder;
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
        T read() throws AssetException;
    }

    public Assets(WorldFolder folder) {
        this.folder = folder;
    }

    /**
     * The mesh of a {@code .glb}, {@code .gltf} or {@code .obj} file: all of its triangles.
     *
     * @param path relative to the world's folder
     * @throws AssetException if it cannot be used, saying why
     */
    public Mesh mesh(String path) throws AssetException {
        return once(meshes, path, () -> {
            byte[] bytes = folder.read(path, MAX_FILE_BYTES);
            var sources = new Sources(folder, path, budget);
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
        return once(textures, path, () ->
                ImageDecoder.decode(folder.read(path, MAX_IMAGE_BYTES), path, Optional.of(path),
                        budget));
    }

    private <T> T once(Map<String, Loaded<T>> known, String path, Reading<T> reading)
            throws AssetException {
        Loaded<T> loaded = known.get(path);
        if (loaded == null) {
            loaded = load(reading);
            known.put(path, loaded);
        }
        return loaded.get();
    }

    private static <T> Loaded<T> load(Reading<T> reading) {
        try {
            return new Loaded<>(Optional.of(reading.read()), Optional.empty());
        } catch (AssetException problem) {
            return new Loaded<>(Optional.empty(), Optional.of(problem));
        }
    }
}
