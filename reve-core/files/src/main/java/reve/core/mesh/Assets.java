// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Mesh;
import reve.core.world.Relief;
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
    private final Map<Place, Loaded<Mesh>> meshesInOwnAxes = new HashMap<>();
    private final Map<Place, Loaded<Texture>> textures = new HashMap<>();
    private final Map<Place, Loaded<HeightGrid>> grids = new HashMap<>();
    private final Map<Terrain, Mesh> terrains = new HashMap<>();

    /**
     * A resolved path.
     *
     * @param file real path of the file
     * @param beside real path of the folder to which references inside the file are relative
     */
    private record Place(Path file, Path beside) {}

    /** A file of heights, and the measures of the terrain that is made of it. */
    private record Terrain(Path file, Relief relief) {}

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
     * Returns the mesh that consists of all triangles in a {@code .glb}, {@code .gltf}, {@code
     * .obj} or {@code .dae} file.
     *
     * @param path relative to the world's folder
     * @throws AssetException with the reason if the file cannot be used
     */
    public Mesh mesh(String path) throws AssetException {
        return mesh(meshes, path, true);
    }

    /**
     * Returns a mesh like {@link #mesh}, but does not turn the axis that a {@code .dae} file names
     * as its upward axis to +Y.
     */
    public Mesh meshInAxesOfFile(String path) throws AssetException {
        return mesh(meshesInOwnAxes, path, false);
    }

    private Mesh mesh(Map<Place, Loaded<Mesh>> known, String path, boolean upright)
            throws AssetException {
        return once(
                known,
                path,
                () -> {
                    String name = path.toLowerCase(Locale.ROOT);
                    boolean gltf = name.endsWith(".glb") || name.endsWith(".gltf");
                    boolean collada = name.endsWith(".dae");
                    if (!gltf && !collada && !name.endsWith(".obj")) {
                        throw new AssetException(
                                path
                                        + ": expected a mesh in a .glb, .gltf, .obj or .dae file; "
                                        + "convert others to .glb");
                    }
                    byte[] bytes = files.read(path, MAX_FILE_BYTES);
                    var sources = new Sources(files, path);
                    if (collada) {
                        return ColladaReader.read(bytes, sources, upright);
                    }
                    return gltf
                            ? GltfReader.read(bytes, sources)
                            : ObjMeshReader.read(bytes, sources);
                });
    }

    /** Returns whether a file of heights is an image, according to its name. */
    public static boolean isImageOfHeights(String path) {
        return path.toLowerCase(Locale.ROOT).endsWith(HeightGrid.IMAGE);
    }

    /**
     * Returns the heights in a {@code .png} or {@code .txt} file.
     *
     * @param path relative to the world's folder
     * @throws AssetException with the reason if the file cannot be used
     */
    public HeightGrid heights(String path) throws AssetException {
        return once(
                grids,
                path,
                () -> {
                    boolean image = isImageOfHeights(path);
                    if (!image && !path.toLowerCase(Locale.ROOT).endsWith(HeightGrid.TEXT)) {
                        throw new AssetException(
                                path
                                        + ": expected heights in a grey .png image or a .txt file"
                                        + " of numbers; convert it");
                    }
                    var sources = new Sources(files, path);
                    byte[] bytes = files.read(path, MAX_FILE_BYTES);
                    return image
                            ? HeightGrid.ofImage(bytes, sources)
                            : HeightGrid.ofText(bytes, sources);
                });
    }

    /**
     * Returns the mesh of a terrain with the heights in a {@code .png} or {@code .txt} file. Reads
     * each file once. Items with the same file and the same measures share the mesh.
     *
     * @param path relative to the world's folder
     * @param relief measures of the terrain, which have a range if the file is an image
     * @throws AssetException with the reason if the file cannot be used
     */
    public Mesh terrain(String path, Relief relief) throws AssetException {
        HeightGrid grid = heights(path);
        var terrain = new Terrain(files.find(path), relief);
        Mesh known = terrains.get(terrain);
        if (known == null) {
            files.budget().begin();
            try {
                known = grid.mesh(relief, new Sources(files, path));
            } finally {
                files.budget().end();
            }
            terrains.put(terrain, known);
        }
        return known;
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
